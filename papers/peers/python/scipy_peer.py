"""The same action in SciPy: `scipy_peer.py MECHANISM.json agreement|blow|hold SAMPLES.json [--quick]`.

`solve_ivp` with right-hand side, Jacobian (forward differences) and event compiled by numba; one JSON object a line.
"""

import json
import sys
import time

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

import action

# Per unit of relative tolerance: rad and rad/s, as in the Rust peer.
ANGLE_TOLERANCE, RATE_TOLERANCE = 1e-3, 1.0
METHODS = ["LSODA", "BDF", "Radau"]
# Tolerances, widths in rad/s, repetitions.
BLOW = {False: ([1e-3, 1e-4, 1e-5, 1e-6], [0.1, 0.03, 0.01, 3e-3, 1e-3], 3), True: ([1e-3, 1e-4, 1e-5], [0.1, 0.01], 2)}
HOLD = {False: ([1e-4, 1e-6], [0.1, 0.01, 1e-3]), True: ([1e-4], [0.1, 0.01])}


class Peer:
    def __init__(self, mechanism):
        self.mechanism, self.action = mechanism, action.compiled(mechanism)
        act = self.action
        count, rates, force = act.count, act.rates, act.force
        beyond_string = act.beyond_string

        @njit
        def pressed(t, y, scale, constant, width):
            return rates(y, scale * force(t) + constant, width)

        @njit
        def jacobian(t, y, scale, constant, width):
            given = scale * force(t) + constant
            base = rates(y, given, width)
            matrix, moved = np.empty((2 * count, 2 * count)), y.copy()
            for i in range(2 * count):
                # Far below a felt's compression (1e-4 rad) and a narrow friction law's width (1e-3 rad/s).
                step = 1e-9 if i < count else 1e-7
                moved[i] = y[i] + step
                step = moved[i] - y[i]
                matrix[:, i] = (rates(moved, given, width) - base) / step
                moved[i] = y[i]
            return matrix

        @njit
        def at_string(t, y, scale, constant, width):
            return beyond_string(y)

        self.pressed, self.jacobian, self.at_string = pressed, jacobian, at_string

    def run(self, method, tolerance, arguments, until, instants=None):
        """The solution and its seconds."""
        count = self.action.count
        absolute = tolerance * np.repeat([ANGLE_TOLERANCE, RATE_TOLERANCE], count)
        event = lambda t, y, *rest: self.at_string(t, y, *rest)
        event.direction = 1.0
        start = time.perf_counter()
        solution = solve_ivp(
            self.pressed,
            (0.0, until),
            self.action.rest,
            method=method,
            args=arguments,
            rtol=tolerance,
            atol=absolute,
            jac=self.jacobian,
            events=event,
            t_eval=instants if instants is not None else [until],
            first_step=1e-5,
        )
        return solution, time.perf_counter() - start

    def blow(self, method, tolerance, width, repetitions):
        blows = []
        for scale in self.mechanism["blow"]["scales"]:
            runs = [
                self.run(method, tolerance, (scale, 0.0, width), self.mechanism["blow"]["until_s"]) for _ in range(repetitions)
            ]
            solution = runs[0][0]
            if not solution.success:
                raise RuntimeError(solution.message)
            hit = len(solution.t_events[0]) > 0
            blows.append(
                {
                    "scale": scale,
                    "speed_m_per_s": self.action.speed(solution.y_events[0][0]) if hit else None,
                    "contact_s": solution.t_events[0][0] if hit else None,
                    "seconds": min(seconds for _, seconds in runs),
                    "evaluations": solution.nfev,
                }
            )
        return {"blows": blows}

    def hold(self, method, tolerance, width):
        hold = self.mechanism["hold"]
        instants = action.instants(hold)
        solution, seconds = self.run(method, tolerance, (0.0, hold["force_N"], width), hold["until_s"], instants)
        if not solution.success:
            raise RuntimeError(solution.message)
        return {
            "angles_rad": list(solution.y[self.mechanism["strike"]["body"]]),
            "seconds": seconds,
            "evaluations": solution.nfev,
        }

    def rows(self, task, tolerances, widths, play):
        for method in METHODS:
            for width in widths:
                for tolerance in tolerances:
                    action.say(f"SciPy: {task}, {method}, width {width:g} rad/s, tolerance {tolerance:g}")
                    row = {
                        "task": task,
                        "peer": "SciPy",
                        "method": method,
                        "tolerance": tolerance,
                        "width_rad_per_s": width,
                    }
                    try:
                        row |= play(method, tolerance, width)
                    except (RuntimeError, ValueError) as error:
                        row["failed"] = str(error)
                    print(json.dumps(row), flush=True)

    def agreement(self, path):
        with open(path, encoding="utf-8") as file:
            document = json.load(file)
        found = []
        for sample in document["samples"]:
            y = np.array(sample["angles_rad"] + sample["rates_rad_per_s"])
            found.append(
                self.action.rates(y, self.action.force(sample["time_s"]), document["width_rad_per_s"])[self.action.count :]
            )
        difference = action.largest_difference(document["samples"], found)
        print(json.dumps({"task": "agreement", "peer": "SciPy", "largest_relative_difference": difference}))


def main():
    quick, words = "--quick" in sys.argv, [word for word in sys.argv[1:] if word != "--quick"]
    peer = Peer(action.read(words[0]))
    if words[1] == "agreement":
        return peer.agreement(words[2])
    action.say("SciPy: compiling")
    for method in METHODS:
        # Also warms up what SciPy imports late.
        peer.run(method, 1e-3, (1.0, 0.0, 0.1), 1e-3)
    if words[1] == "blow":
        tolerances, widths, repetitions = BLOW[quick]
        peer.rows("blow", tolerances, widths, lambda *setting: peer.blow(*setting, repetitions))
    else:
        peer.rows("hold", *HOLD[quick], peer.hold)


if __name__ == "__main__":
    main()
