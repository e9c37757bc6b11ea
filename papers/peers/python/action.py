"""The exported action for the Python peers: its felts and, where a peer has no mechanics of its own, its equations of motion.

Compiled by numba. Written from the mechanism's JSON alone (its format stands in crates/erard-core/examples/peers/export.rs); it shares
nothing with Erard's engine nor with the Rust peer. Friction is regularised: tanh(u / width) replaces the set-valued sign.
SI units; x toward the back of the piano, y up, angles absolute and counter-clockwise.
"""

import json
import math
import sys
from types import SimpleNamespace

import numpy as np
from numba import njit

LINE, SEGMENT, DISC = range(3)


def read(path):
    """The mechanism as it stands in the file, checked for its format."""
    with open(path, encoding="utf-8") as file:
        mechanism = json.load(file)
    if mechanism.get("format") != "erard-mechanism/2":
        say(f"error: {path}: format is {mechanism.get('format')!r}; expected 'erard-mechanism/2'")
        sys.exit(2)
    return mechanism


def index(body):
    """The ground is -1."""
    return -1 if body is None else body


def curve_numbers(curve):
    """Kind, two vectors (line: point, normal; segment: ends; disc: center, nothing) and a radius."""
    if "line" in curve:
        return LINE, curve["line"]["point_m"], curve["line"]["normal"], 0.0
    if "segment" in curve:
        segment = curve["segment"]
        return SEGMENT, segment["from_m"], segment["to_m"], segment["rounding_m"]
    return DISC, curve["disc"]["center_m"], [0.0, 0.0], curve["disc"]["radius_m"]


def compiled(mechanism):
    """Compiled functions of the mechanism: `felts` and `push` (forces on a placed mechanism), `place`, `force`, `rates`, and what is asked of the
    strike point."""
    bodies, zones = mechanism["bodies"], mechanism["zones"]
    count = len(bodies)
    column = lambda key: np.array([body[key] for body in bodies], dtype=float)
    parent = np.array([index(body["parent"]) for body in bodies])
    pivot, mass, center = column("pivot_m"), column("mass_kg"), column("center_of_mass_m")
    dry, viscous = column("dry_friction_N_m"), column("viscous_friction_N_m_s")
    gravity = float(mechanism["gravity_m_s2"])

    # Of a body with everything hinged beyond it: mass, first moment about its pivot, and what the diagonal of the mass
    # matrix is.
    beyond, moment, diagonal = mass.copy(), center * mass[:, None], column("inertia_kg_m2")
    for i in reversed(range(count)):
        if parent[i] >= 0:
            beyond[parent[i]] += beyond[i]
            moment[parent[i]] += beyond[i] * pivot[i]
            diagonal[parent[i]] += beyond[i] * pivot[i] @ pivot[i]

    spring_torque, spring_stiffness = np.zeros(count), np.zeros(count)
    for spring in mechanism["springs"]:
        stiffness = spring["stiffness_N_m_per_rad"]
        spring_torque[spring["body"]] += spring["torque_N_m"] + stiffness * spring["reference_rad"]
        spring_stiffness[spring["body"]] += stiffness

    disc_body = np.array([index(zone["disc"]["body"]) for zone in zones])
    disc_center = np.array([zone["disc"]["center_m"] for zone in zones])
    disc_radius = np.array([zone["disc"]["radius_m"] for zone in zones])
    curve_body = np.array([index(zone["curve_body"]) for zone in zones])
    curves = [curve_numbers(zone["curve"]) for zone in zones]
    kind = np.array([curve[0] for curve in curves])
    first, second = np.array([curve[1] for curve in curves]), np.array([curve[2] for curve in curves])
    rounding = np.array([curve[3] for curve in curves])
    stiffness = np.array([zone["felt"]["stiffness_N_per_m_r"] for zone in zones])
    exponent = np.array([zone["felt"]["exponent"] for zone in zones])
    damping = np.array([zone["felt"]["damping_N_s_per_m3"] for zone in zones])
    slide = np.array([zone["friction_coefficient"] for zone in zones])

    finger, finger_point = mechanism["finger"]["body"], np.array(mechanism["finger"]["point_m"])
    finger_direction = np.array(mechanism["finger"]["direction"])
    strike = mechanism["strike"]
    hammer, meets = strike["body"], float(strike["meets_m"])
    strike_point, toward = np.array(strike["point_m"]), np.array(strike["direction"])
    blow = mechanism["blow"]
    times, forces, slopes = (np.array(blow[key]) for key in ("times_s", "forces_N", "slopes_N_per_s"))

    @njit(inline="always")
    def turned(place, body, x, y):
        if body < 0:
            return x, y
        s, c = place[body, 0], place[body, 1]
        return c * x - s * y, s * x + c * y

    @njit(inline="always")
    def point(place, body, x, y):
        x, y = turned(place, body, x, y)
        if body < 0:
            return x, y
        return place[body, 2] + x, place[body, 3] + y

    @njit(inline="always")
    def velocity(place, body, x, y):
        if body < 0:
            return 0.0, 0.0
        return (
            place[body, 4] - place[body, 6] * (y - place[body, 3]),
            place[body, 5] + place[body, 6] * (x - place[body, 2]),
        )

    @njit(error_model="numpy")
    def place(q, v):
        """Per body: sine, cosine, pivot, the pivot's velocity, angular velocity."""
        placed = np.empty((count, 7))
        for i in range(count):
            placed[i, 0], placed[i, 1], placed[i, 6] = math.sin(q[i]), math.cos(q[i]), v[i]
            placed[i, 2], placed[i, 3] = point(placed, parent[i], pivot[i, 0], pivot[i, 1])
            placed[i, 4], placed[i, 5] = velocity(placed, parent[i], placed[i, 2], placed[i, 3])
        return placed

    @njit(inline="always")
    def push_at(place, body, x, y, fx, fy, torque):
        while body >= 0:
            torque[body] += (x - place[body, 2]) * fy - (y - place[body, 3]) * fx
            x, y = place[body, 2], place[body, 3]
            body = parent[body]

    @njit(error_model="numpy")
    def push(place, force, torque):
        """Adds the torques of the finger's force (N) on the bodies, in absolute angles."""
        x, y = point(place, finger, finger_point[0], finger_point[1])
        push_at(place, finger, x, y, force * finger_direction[0], force * finger_direction[1], torque)

    @njit(error_model="numpy")
    def felts(place, width, torque):
        """Adds the torques of all felts on the bodies, in absolute angles; `width` of the sliding friction in m/s."""
        for z in range(len(kind)):
            a, b = disc_body[z], curve_body[z]
            cx, cy = point(place, a, disc_center[z, 0], disc_center[z, 1])
            px, py = point(place, b, first[z, 0], first[z, 1])
            if kind[z] == LINE:
                nx, ny = turned(place, b, second[z, 0], second[z, 1])
                distance = (cx - px) * nx + (cy - py) * ny
            else:
                if kind[z] == SEGMENT:
                    ex, ey = point(place, b, second[z, 0], second[z, 1])
                    tx, ty = ex - px, ey - py
                    share = ((cx - px) * tx + (cy - py) * ty) / (tx * tx + ty * ty)
                    share = min(max(share, 0.0), 1.0)
                    px, py = px + share * tx, py + share * ty
                distance = math.hypot(cx - px, cy - py)
                nx, ny = (cx - px) / distance, (cy - py) / distance
                distance -= rounding[z]
            compression = disc_radius[z] - distance
            if compression <= 0.0:
                continue
            ux, uy = velocity(place, a, cx, cy)
            wx, wy = velocity(place, b, cx, cy)
            if exponent[z] == 2.0:
                elastic = compression * compression
            elif exponent[z] == 2.5:
                elastic = compression * compression * math.sqrt(compression)
            else:
                elastic = compression ** exponent[z]
            pressure = stiffness[z] * elastic - damping[z] * compression * compression * (nx * (ux - wx) + ny * (uy - wy))
            if pressure <= 0.0:
                continue
            x, y = cx - distance * nx, cy - distance * ny
            fx, fy = pressure * nx, pressure * ny
            if slide[z] > 0.0:
                ux, uy = velocity(place, a, x, y)
                wx, wy = velocity(place, b, x, y)
                slip = ny * (ux - wx) - nx * (uy - wy)
                drag = -slide[z] * pressure * math.tanh(slip / width)
                fx, fy = fx + drag * ny, fy - drag * nx
            push_at(place, a, x, y, fx, fy, torque)
            push_at(place, b, x, y, -fx, -fy, torque)

    @njit(error_model="numpy")
    def force(t):
        """The stroke's force, N: Hermite's cubic between samples, constant outside."""
        if t <= times[0]:
            return forces[0]
        if t >= times[-1]:
            return forces[-1]
        i = np.searchsorted(times, t, side="right") - 1
        h = times[i + 1] - times[i]
        s = (t - times[i]) / h
        rise = forces[i + 1] - forces[i]
        bend, twist = 3.0 * rise - h * (2.0 * slopes[i] + slopes[i + 1]), h * (slopes[i] + slopes[i + 1]) - 2.0 * rise
        return forces[i] + s * (h * slopes[i] + s * (bend + s * twist))

    @njit(error_model="numpy")
    def rates(y, given, width):
        """d(angles, angular velocities)/dt under a finger force (N); `width` of the pivots in rad/s, of contacts a tenth of it in m/s."""
        q, v = y[:count], y[count:]
        placed = place(q, v)
        torque, matrix = np.zeros(count), np.zeros((count, count))
        push(placed, given, torque)
        felts(placed, 0.1 * width, torque)
        for i in range(count):
            p = parent[i]
            turn, rate = q[i], v[i]
            if p >= 0:
                turn, rate = turn - q[p], rate - v[p]
            joint = spring_torque[i] - spring_stiffness[i] * turn - viscous[i] * rate - dry[i] * math.tanh(rate / width)
            torque[i] += joint
            if p >= 0:
                torque[p] -= joint
            matrix[i, i] = diagonal[i]
            mx, my = turned(placed, i, moment[i, 0], moment[i, 1])
            torque[i] -= gravity * mx
            branch = i
            while p >= 0:
                ax, ay = placed[branch, 2] - placed[p, 2], placed[branch, 3] - placed[p, 3]
                matrix[i, p] = ax * mx + ay * my
                cross = ax * my - ay * mx
                torque[i] -= v[p] * v[p] * cross
                torque[p] += v[i] * v[i] * cross
                branch, p = p, parent[p]
        # Cholesky's factor in the lower triangle; nothing is filled in between bodies of different chains.
        for i in range(count):
            for j in range(i + 1):
                entry = matrix[i, j]
                for k in range(j):
                    entry -= matrix[i, k] * matrix[j, k]
                matrix[i, j] = math.sqrt(entry) if i == j else entry / matrix[j, j]
            for j in range(i):
                torque[i] -= matrix[i, j] * torque[j]
            torque[i] /= matrix[i, i]
        out = np.empty(2 * count)
        for i in range(count - 1, -1, -1):
            for j in range(i + 1, count):
                torque[i] -= matrix[j, i] * torque[j]
            torque[i] /= matrix[i, i]
            out[i], out[count + i] = v[i], torque[i]
        return out

    @njit(error_model="numpy")
    def struck(placed):
        """Of the strike point: how far it is beyond where it meets the string (m), its velocity in that direction, its speed (m/s)."""
        x, y = point(placed, hammer, strike_point[0], strike_point[1])
        ux, uy = velocity(placed, hammer, x, y)
        along = ux * toward[0] + uy * toward[1]
        return x * toward[0] + y * toward[1] - meets, along, math.hypot(ux, uy)

    @njit(error_model="numpy")
    def beyond_string(y):
        """How far the strike point of a state is beyond where it meets the string, m."""
        return struck(place(y[:count], y[count:]))[0]

    @njit(error_model="numpy")
    def speed(y):
        """Speed of a state's strike point, m/s."""
        return struck(place(y[:count], y[count:]))[2]

    rest = np.zeros(2 * count)
    rest[:count] = column("rest_angle_rad")
    return SimpleNamespace(
        count=count,
        parent=parent,
        rest=rest,
        place=place,
        push=push,
        felts=felts,
        force=force,
        rates=rates,
        struck=struck,
        beyond_string=beyond_string,
        speed=speed,
    )


def instants(hold):
    """The instants at which the held hammer's angle is looked at, s."""
    return np.linspace(hold["from_s"], hold["until_s"], 91)


def say(text):
    """Progress."""
    print(text, file=sys.stderr, flush=True)


def largest_difference(samples, accelerations):
    """Largest difference of accelerations to the samples', relative to each sample's largest."""
    worst = 0.0
    for sample, found in zip(samples, accelerations):
        expected = np.array(sample["accelerations_rad_per_s2"])
        worst = max(worst, np.abs(found - expected).max() / np.abs(expected).max())
    return float(worst)
