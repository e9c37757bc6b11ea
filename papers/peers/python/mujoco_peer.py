"""The same action in MuJoCo: `mujoco_peer.py MECHANISM.json agreement|blow|hold SAMPLES.json [--quick]`.

MuJoCo has the bodies, hinges, springs, viscous friction and (as `frictionloss`) the pivots' dry friction; felts and finger are
added in its passive-force callback. The callback is machine code (a numba cfunc), so that neither Python nor its lock is
in the loop; the steps run inside one `mj_step` call. One JSON object a line.
"""

import ctypes
import json
import math
import sys
import time
import xml.etree.ElementTree as ET

import mujoco
import numpy as np
from numba import carray, cfunc, njit, types
from numba.extending import intrinsic

import action

# What a run reads and leaves, shared with the callback.
SCALE, CONSTANT, WIDTH, DRY, PER_STEP, CALLS, TIME, BEYOND, RATE, WHOLE, SLOPE, CONTACT, SPEED, SIZE = range(14)
# Integrator, evaluations of the forces per step, whether the pivots' dry friction is MuJoCo's own or regularised in the
# callback too (which is less stiff and needs no constraint solver).
METHODS = {
    "implicitfast": ("implicitfast", 1, True),
    "implicitfast, tanh pivots": ("implicitfast", 1, False),
    "discrete": ("discrete", 1, True),
    "discrete, tanh pivots": ("discrete", 1, False),
    "RK4": ("RK4", 4, True),
    "RK4, tanh pivots": ("RK4", 4, False),
}
# Four evaluations a step are not worth their time below this step, s.
SHORTEST_OF_RK4_S = 12.5e-6
STEPS_S = [800e-6, 400e-6, 200e-6, 100e-6, 90e-6, 80e-6, 50e-6, 25e-6, 12.5e-6, 6.25e-6, 3.125e-6, 1.5625e-6]
# Steps, widths in rad/s (at sliding contacts a tenth of it in m/s), repetitions.
BLOW = {
    False: (STEPS_S, [0.1, 0.03, 0.01, 3e-3, 1e-3], 3),
    True: ([100e-6, 50e-6, 25e-6, 12.5e-6], [0.1, 0.01], 2),
}
# The held note's steps and widths; by the integrators that take one evaluation a step.
HOLD = {False: ([50e-6, 12.5e-6], [0.1, 0.01, 1e-3]), True: ([50e-6], [0.1, 0.01])}


def model_xml(mechanism):
    """The mechanism as MuJoCo's XML: the plane is x-z, and counter-clockwise is about -y."""
    numbers = lambda *values: " ".join(repr(float(value)) for value in values)
    root = ET.Element("mujoco")
    ET.SubElement(root, "compiler", angle="radian", autolimits="false")
    option = ET.SubElement(root, "option", gravity=numbers(0, 0, -mechanism["gravity_m_s2"]))
    ET.SubElement(option, "flag", contact="disable", autoreset="disable")
    springs = {spring["body"]: spring for spring in mechanism["springs"]}
    places = {None: ET.SubElement(root, "worldbody")}
    for i, body in enumerate(mechanism["bodies"]):
        place = ET.SubElement(places[body["parent"]], "body", pos=numbers(body["pivot_m"][0], 0, body["pivot_m"][1]))
        joint = {
            "type": "hinge",
            "axis": "0 -1 0",
            "damping": numbers(body["viscous_friction_N_m_s"]),
            "frictionloss": numbers(body["dry_friction_N_m"]),
        }
        if i in springs:
            spring = springs[i]
            stiffness = spring["stiffness_N_m_per_rad"]
            joint["stiffness"] = numbers(stiffness)
            joint["springref"] = numbers(spring["reference_rad"] + spring["torque_N_m"] / stiffness)
        ET.SubElement(place, "joint", joint)
        x, y = body["center_of_mass_m"]
        inertia = body["inertia_kg_m2"] - body["mass_kg"] * (x * x + y * y)
        # Only the moment about y matters in the plane; a sphere's three are physical.
        ET.SubElement(place, "inertial", pos=numbers(x, 0, y), mass=numbers(body["mass_kg"]), diaginertia=numbers(*[inertia] * 3))
        places[i] = place
    return ET.tostring(root, encoding="unicode")


@intrinsic
def at_address(context, address):
    """An address as a pointer to doubles."""

    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

    return types.CPointer(types.float64)(types.intp), generate


class Peer:
    def __init__(self, mechanism):
        self.mechanism, self.action = mechanism, action.compiled(mechanism)
        self.model = mujoco.MjModel.from_xml_string(model_xml(mechanism))
        self.dry = np.array([body["dry_friction_N_m"] for body in mechanism["bodies"]])
        self.data = mujoco.MjData(self.model)
        self.shared = np.zeros(SIZE)
        self.joint_torques = self.compile_torques()
        self.callback = self.compile_callback()
        signature = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
        mujoco.set_mjcb_passive(signature(self.callback.address))

    def compile_torques(self):
        """Torques of felts and finger on the joints, from MuJoCo's joint angles; returns what the strike point does."""
        act, count, parent = self.action, self.action.count, self.action.parent
        place, push, felts, struck = act.place, act.push, act.felts, act.struck

        @njit(error_model="numpy")
        def joint_torques(qpos, qvel, given, width, torque):
            q, v = np.empty(count), np.empty(count)
            for i in range(count):
                q[i], v[i], torque[i] = qpos[i], qvel[i], 0.0
                if parent[i] >= 0:
                    q[i], v[i] = q[i] + q[parent[i]], v[i] + v[parent[i]]
            placed = place(q, v)
            push(placed, given, torque)
            felts(placed, width, torque)
            # A joint carries everything beyond it.
            for i in range(count - 1, -1, -1):
                if parent[i] >= 0:
                    torque[parent[i]] += torque[i]
            return struck(placed)

        return joint_torques

    def compile_callback(self):
        """The passive-force callback. It knows where this very mjData keeps its arrays."""
        data, count, force, joint_torques = self.data, self.action.count, self.action.force, self.joint_torques
        qpos_at, qvel_at, passive_at = (a.ctypes.data for a in (data.qpos, data.qvel, data.qfrc_passive))
        # The time has no array of its own; in the struct it stands right before the energies.
        time_at, shared_at = data.energy.ctypes.data - 8, self.shared.ctypes.data
        data.time = 0.123
        if ctypes.c_double.from_address(time_at).value != 0.123:
            action.say("error: this MuJoCo keeps its time elsewhere; the pinned version is in papers/peers/requirements.txt")
            sys.exit(2)
        data.time = 0.0
        dry = self.dry

        @cfunc(types.void(types.voidptr, types.voidptr))
        def passive(_model, _data):
            qpos, qvel = carray(at_address(qpos_at), count), carray(at_address(qvel_at), count)
            now, shared = carray(at_address(time_at), 1)[0], carray(at_address(shared_at), SIZE)
            torque = np.empty(count)
            given = shared[SCALE] * force(now) + shared[CONSTANT]
            beyond, along, speed = joint_torques(qpos, qvel, given, shared[WIDTH], torque)
            total = carray(at_address(passive_at), count)
            for i in range(count):
                total[i] += torque[i]
                if shared[DRY] > 0.0:
                    total[i] -= dry[i] * math.tanh(qvel[i] / shared[DRY])
            # The first evaluation of a step is at the step's start: look whether the hammer has met the string.
            if shared[CALLS] % shared[PER_STEP] == 0.0:
                before = shared[BEYOND]
                if shared[CALLS] > 0.0 and before <= 0.0 and beyond > 0.0 and shared[CONTACT] == 0.0:
                    # As if the step before went on: at this step's end the string has pushed already.
                    rate = math.sqrt(max(shared[RATE] ** 2 - 2.0 * shared[SLOPE] * before, 0.0))
                    shared[CONTACT] = shared[TIME] - 2.0 * before / (shared[RATE] + rate)
                    shared[SPEED] = rate * shared[WHOLE] / shared[RATE]
                if shared[CALLS] > 0.0:
                    shared[SLOPE] = (along - shared[RATE]) / (now - shared[TIME])
                shared[TIME], shared[BEYOND], shared[RATE], shared[WHOLE] = now, beyond, along, speed
            shared[CALLS] += 1.0

        return passive

    def relative(self, absolute):
        """Joint coordinates of absolute ones."""
        parent = self.action.parent
        return np.array([x - (absolute[p] if p >= 0 else 0.0) for x, p in zip(absolute, parent)])

    def prepare(self, method, step, width, scale, constant):
        integrator, per_step, own_dry = METHODS[method]
        option = self.model.opt
        option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
        option.timestep = step
        # As stiff as MuJoCo lets dry friction be at this step: the shortest time constant, the least softness.
        self.model.dof_solref[:] = [2.0 * step, 1.0]
        self.model.dof_solimp[:] = [0.9999, 0.9999, 0.001, 0.5, 2.0]
        self.model.dof_frictionloss[:] = self.dry if own_dry else 0.0
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = self.relative(self.action.rest[: self.action.count])
        self.shared[:] = 0.0
        self.shared[[SCALE, CONSTANT, WIDTH, PER_STEP]] = [scale, constant, 0.1 * width, per_step]
        self.shared[DRY] = 0.0 if own_dry else width

    def check(self):
        if not np.isfinite(self.data.qpos).all() or np.abs(self.data.qpos).max() > 10.0:
            raise RuntimeError("diverged")

    def blow(self, method, step, width, repetitions):
        blow, blows = self.mechanism["blow"], []
        steps = int(np.ceil(blow["until_s"] / step - 1e-9))
        for scale in blow["scales"]:
            seconds = []
            for _ in range(repetitions):
                self.prepare(method, step, width, scale, 0.0)
                start = time.perf_counter()
                mujoco.mj_step(self.model, self.data, nstep=steps)
                seconds.append(time.perf_counter() - start)
                self.check()
            hit = self.shared[CONTACT] > 0.0
            blows.append(
                {
                    "scale": scale,
                    "speed_m_per_s": self.shared[SPEED] if hit else None,
                    "contact_s": self.shared[CONTACT] if hit else None,
                    "seconds": min(seconds),
                    "callback_seconds": self.callback_seconds * self.shared[CALLS],
                    "steps": steps,
                }
            )
        return {"blows": blows}

    def hold(self, method, step, width):
        hold, angles = self.mechanism["hold"], []
        self.prepare(method, step, width, 0.0, hold["force_N"])
        start, done = time.perf_counter(), 0
        for instant in action.instants(hold):
            steps = round(instant / step) - done
            mujoco.mj_step(self.model, self.data, nstep=steps)
            done += steps
            self.check()
            angles.append(self.hammer_angle())
        return {"angles_rad": angles, "seconds": time.perf_counter() - start, "steps": done}

    def hammer_angle(self):
        """The hammer's absolute angle, rad: its joint's and those of what carries it."""
        body, angle = self.mechanism["strike"]["body"], 0.0
        while body >= 0:
            angle += self.data.qpos[body]
            body = self.action.parent[body]
        return angle

    def time_callback(self, samples):
        """Seconds of one evaluation of felts and finger, at the states of a blow: what the callback costs, machine code as it is."""
        angles = np.array([self.relative(sample["angles_rad"]) for sample in samples])
        rates = np.array([self.relative(sample["rates_rad_per_s"]) for sample in samples])
        torques, force, count = self.joint_torques, self.action.force, self.action.count

        @njit
        def all_of_them(rounds):
            torque, total = np.empty(count), 0.0
            for _ in range(rounds):
                for i in range(len(angles)):
                    torques(angles[i], rates[i], force(1e-3 * i), 0.01, torque)
                    total += torque[0]
            return total

        all_of_them(1)
        seconds = []
        for _ in range(9):
            start = time.perf_counter()
            all_of_them(100)
            seconds.append((time.perf_counter() - start) / (100 * len(angles)))
        self.callback_seconds = min(seconds)

    def rows(self, task, methods, steps, widths, play):
        for method in methods:
            for width in widths:
                for step in steps:
                    if METHODS[method][1] > 1 and step < SHORTEST_OF_RK4_S:
                        continue
                    action.say(f"MuJoCo: {task}, {method}, width {width:g} rad/s, step {step * 1e6:g} us")
                    row = {"task": task, "peer": "MuJoCo", "method": method, "step_s": step, "width_rad_per_s": width}
                    try:
                        row |= play(method, step, width)
                    except RuntimeError as error:
                        row["failed"] = str(error)
                    print(json.dumps(row), flush=True)

    def agreement(self, document):
        """Accelerations of MuJoCo's own mechanics; all friction as tanh, since its own law for dry friction is another one."""
        parent, found = self.action.parent, []
        self.prepare("implicitfast, tanh pivots", 1e-5, document["width_rad_per_s"], 1.0, 0.0)
        for sample in document["samples"]:
            self.data.time = sample["time_s"]
            self.data.qpos[:], self.data.qvel[:] = (
                self.relative(sample["angles_rad"]),
                self.relative(sample["rates_rad_per_s"]),
            )
            mujoco.mj_forward(self.model, self.data)
            absolute = np.zeros(self.action.count)
            for i, p in enumerate(parent):
                absolute[i] = self.data.qacc[i] + (absolute[p] if p >= 0 else 0.0)
            found.append(absolute)
        difference = action.largest_difference(document["samples"], found)
        print(json.dumps({"task": "agreement", "peer": "MuJoCo", "largest_relative_difference": difference}))


def main():
    quick, words = "--quick" in sys.argv, [word for word in sys.argv[1:] if word != "--quick"]
    with open(words[2], encoding="utf-8") as file:
        document = json.load(file)
    action.say("MuJoCo: compiling")
    peer = Peer(action.read(words[0]))
    if words[1] == "agreement":
        peer.agreement(document)
    elif words[1] == "blow":
        peer.time_callback(document["samples"])
        steps, widths, repetitions = BLOW[quick]
        peer.rows("blow", METHODS, steps, widths, lambda *setting: peer.blow(*setting, repetitions))
    else:
        single = [method for method, (_, per_step, _) in METHODS.items() if per_step == 1]
        peer.rows("hold", single, *HOLD[quick], peer.hold)


if __name__ == "__main__":
    main()
