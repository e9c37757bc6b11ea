"""From rows to the comparison: errors against the converged reference, what each peer needs for an error, ratios, drifts."""

import math
import statistics

# Errors of the hammer speed at which the peers are compared.
EQUAL_ERRORS = [1e-2, 1e-3, 1e-4]
# What the project aims at, at a hammer-speed error of 1e-3 on one core.
TARGET_ERROR, TARGET_RATIO, TARGET_BATCH_RATIO = 1e-3, 10.0, 40.0
# Accelerations of one state by two programs may differ by rounding only.
LARGEST_DISAGREEMENT = 1e-9
# Hammer speeds with the sharpest regularised friction are this close to the reference, or it is another action.
LARGEST_DIFFERENCE_IN_THE_LIMIT = 1e-4


def name(row):
    """Peer and method."""
    if "batch_cores" in row:
        return f"{row['peer']} batch, {batch(row)}"
    return f"{row['peer']} {row['method']}" if "method" in row else row["peer"]


def batch(row):
    """What a batch is played in."""
    cores = row["batch_cores"]
    return f"{row['lanes']} lanes {row['precision']}, {cores} core" + ("s" if cores > 1 else "")


def setting(row):
    """The setting in words."""
    parts = []
    if "step_s" in row:
        parts.append(f"step {row['step_s'] * 1e6:g} us")
    if "newton_tolerance" in row:
        parts.append(f"Newton {row['newton_tolerance']:g}")
    if "tolerance" in row:
        parts.append(f"tolerance {row['tolerance']:g}")
    if "width_rad_per_s" in row:
        parts.append(f"width {row['width_rad_per_s']:g} rad/s")
    return ", ".join(parts)


def merged(rows):
    """Rows of one setting from several rounds become one, with the least time of each blow."""
    rounds = {}
    for row in rows:
        rounds.setdefault((row["task"], name(row), setting(row)), []).append(row)
    for first, *others in rounds.values():
        for other in others:
            for blow, again in zip(first.get("blows", []), other.get("blows", [])):
                blow["seconds"] = min(blow["seconds"], again["seconds"])
    return [first for first, *_ in rounds.values()]


class Comparison:
    def __init__(self, rows, mechanism):
        rows = merged(rows)
        self.instrument, self.bodies = mechanism["instrument"], len(mechanism["bodies"])
        self.until_s = mechanism["blow"]["until_s"]
        self.hold = mechanism["hold"]
        self.radius_m = mechanism["strike"]["radius_m"]
        reference = next(row for row in rows if row["task"] == "reference")
        self.reference_step_s = reference["step_s"]
        self.reference = {blow["scale"]: blow["speed_m_per_s"] for blow in reference["blows"]}
        self.contacts = [blow["contact_s"] for blow in reference["blows"]]
        self.agreement = {row["peer"]: row["largest_relative_difference"] for row in rows if row["task"] == "agreement"}
        self.limit = [self.point(row) for row in rows if row["task"] == "limit"]
        self.points = [self.point(row) for row in rows if row["task"] == "blow"]
        self.holds = self.held([row for row in rows if row["task"] == "hold"])
        # Rows of the fastest peer and of Erard, timed right after each other, for each round.
        self.rounds = []

    def point(self, row):
        """A row with its error: the root mean square of the relative errors of the hammer speeds of all blows."""
        point = {"name": name(row), "setting": setting(row)} | {k: v for k, v in row.items() if k not in ("blows", "task")}
        blows = row.get("blows")
        if blows is not None and any(blow["speed_m_per_s"] is None for blow in blows):
            point["failed"] = "the hammer does not reach the string"
        if "failed" in point:
            return point
        errors = [blow["speed_m_per_s"] / self.reference[blow["scale"]] - 1.0 for blow in blows]
        point["error"] = math.sqrt(sum(error * error for error in errors) / len(errors))
        point["worst_error"] = max(map(abs, errors))
        point["mean_error"] = statistics.fmean(errors)
        for key in ("seconds", "callback_seconds", "steps", "evaluations"):
            if key in blows[0]:
                point[key] = statistics.median(blow[key] for blow in blows)
        point["real_time_factor"] = self.until_s / point["seconds"]
        return point

    def same_in_the_limit(self):
        """Whether the sharpest friction tried gives the reference's hammer speeds."""
        sharpest = min(self.limit, key=lambda point: point["width_rad_per_s"])
        return abs(sharpest.get("mean_error", math.inf)) <= LARGEST_DIFFERENCE_IN_THE_LIMIT

    def names(self):
        """Peers and methods in the order of the rows."""
        return list(dict.fromkeys(point["name"] for point in self.points))

    def of(self, peer):
        """The points of a peer that came to something."""
        return [point for point in self.points if point["name"] == peer and "failed" not in point]

    def front(self, peer):
        """Those of a peer's points that no other one of it beats in both error and seconds, fastest first."""
        front = []
        for point in sorted(self.of(peer), key=lambda point: (point["seconds"], point["error"])):
            if not front or point["error"] < front[-1]["error"]:
                front.append(point)
        return front

    def at_error(self, error):
        """For every peer the fastest point with at most this error (or None), and its ratio of seconds to Erard's, blow by blow."""
        fastest = {
            peer: min((p for p in self.of(peer) if p["error"] <= error), key=lambda p: p["seconds"], default=None)
            for peer in self.names()
        }
        alone = (p for p in fastest.values() if p and p["peer"] == "Erard" and "batch_cores" not in p)
        own = min(alone, key=lambda p: p["seconds"], default=None)
        ratio = lambda point: point["seconds"] / own["seconds"] if own and point else None
        return {peer: (point, ratio(point)) for peer, point in fastest.items()}

    def held(self, rows):
        """The held notes: how far the hammer turns while it should stand still, and where it is at the end."""
        finest = min((row for row in rows if row["peer"] == "Erard" and "step_s" in row), key=lambda row: row["step_s"])
        caught = finest["angles_rad"][-1]
        holds = []
        for row in rows:
            hold = {"name": name(row), "setting": setting(row)} | {
                k: v for k, v in row.items() if k not in ("angles_rad", "task")
            }
            if "failed" not in row:
                angles = row["angles_rad"]
                hold["drift_rad"] = max(abs(angle - angles[0]) for angle in angles)
                hold["drift_mm"] = hold["drift_rad"] * self.radius_m * 1e3
                hold["off_caught_rad"] = angles[-1] - caught
                hold["real_time_factor"] = self.hold["until_s"] / row["seconds"]
            holds.append(hold)
        return holds

    def contest(self):
        """Erard's fixed step and the fastest peer's setting at the target's error; None where either is missing, or where the peer is no
        program that can be asked for one setting."""
        reached = [point for point, _ in self.at_error(TARGET_ERROR).values() if point is not None]
        mine = [p for p in reached if p["peer"] == "Erard" and "step_s" in p and "batch_cores" not in p]
        theirs = [p for p in reached if p["peer"] != "Erard"]
        if not mine or not theirs:
            return None
        fastest = lambda points: min(points, key=lambda p: p["seconds"])
        return (fastest(mine), fastest(theirs)) if fastest(theirs)["peer"] == "diffsol" else None

    def turns(self):
        """By turns: how often Erard's time, alone and of each batch, fits into the peer's. Median of the rounds, the least and the largest."""
        ratios = {}
        for rows in self.rounds:
            took = {name(row): statistics.median(blow["seconds"] for blow in row["blows"]) for row in rows}
            peer = next(seconds for who, seconds in took.items() if not who.startswith("Erard"))
            for who, seconds in took.items():
                if who.startswith("Erard"):
                    ratios.setdefault(who, []).append(peer / seconds)
        return {
            who: {"ratio": statistics.median(found), "least": min(found), "largest": max(found)} for who, found in ratios.items()
        }

    def targets(self):
        """The fastest peer at the target's error, and Erard's ratios to it, alone and in batches: measured, wanted, met. Of rounds by turns
        where there are some, else of the tables."""
        found = self.at_error(TARGET_ERROR)
        reached = {peer: ratio for peer, (point, ratio) in found.items() if ratio is not None and point["peer"] != "Erard"}
        if not reached:
            return None
        peer = min(reached, key=reached.get)
        about = {"error": TARGET_ERROR, "fastest_peer": peer}
        if self.rounds:
            ratios = self.turns()
            own = ratios.pop("Erard")
            mine, theirs = self.contest()
            about |= {"fastest_peer": f"{peer}, {theirs['setting']}", "setting": mine["setting"], "rounds": len(self.rounds)}
        else:
            own = {"ratio": reached[peer]}
            batches = {who: point for who, (point, _) in found.items() if point is not None and "batch_cores" in point}
            ratios = {who: {"ratio": found[peer][0]["seconds"] / point["seconds"]} for who, point in batches.items()}
        verdict = lambda one, wanted: {**one, "ratio_wanted": wanted, "ratio_met": one["ratio"] >= wanted}
        return {
            **about,
            **verdict(own, TARGET_RATIO),
            "batches": [
                {"batch": who.removeprefix("Erard batch, "), **verdict(one, TARGET_BATCH_RATIO)} for who, one in ratios.items()
            ],
        }

    def document(self, machine):
        """Everything, for machines."""
        return {
            "machine": machine,
            "instrument": self.instrument,
            "bodies": self.bodies,
            "simulated_s": self.until_s,
            "reference": {"step_s": self.reference_step_s, "hammer_speeds_m_per_s": list(self.reference.values())},
            "agreement_of_accelerations": self.agreement,
            "sharper_friction": self.limit,
            "targets": self.targets(),
            "points": self.points,
            "held_note": self.holds,
        }
