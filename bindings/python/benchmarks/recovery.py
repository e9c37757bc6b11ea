"""Are fits as sure of themselves as they may be? Eight parameters recovered from synthetic recordings, twenty times; coverage counted.

    python benchmarks/recovery.py [--repetitions 20] [--seed 1] [--instrument concert-grand-rigid] [--json FILE]

Each time eight parameters are drawn at random; the action with them is pressed by four built-in strokes; force, key and hammer are sampled at
4 kHz with white noise (20 mN, 10 um, 50 um: a load cell and two optical sensors), the force that then drives the model too. The fit starts from the
file's numbers. Of all intervals of one and of two standard deviations it is counted how many hold the truth; 68 and 95 % should.
"""

from __future__ import annotations

import argparse
import json
import time

import erard
import numpy as np

#: What is recovered, and how far it is drawn from the file's number: a factor's logarithm, or a turn in m, uniformly
#: either way.
TRUTHS = {
    "body.hammer.mass": 0.1,
    "body.key.mass": 0.1,
    "body.key.friction": 0.3,
    "body.hammer.friction": 0.25,
    "zone.capstan_heel.stiffness": 0.4,
    "zone.jack_knuckle.stiffness": 0.4,
    "zone.key_front.stiffness": 0.4,
    "let_off": 4e-4,
}
STROKES = (("p", "pressed"), ("mf", "pressed"), ("f", "pressed"), ("mf", "struck"))
NOISE = {"force_N": 0.02, "key_m": 10e-6, "hammer_rise_m": 50e-6}
BOUNDS = {"let_off": ("-1 mm", "+1 mm")}


def recordings(true: erard.Instrument, rng: np.random.Generator, duration: float = 0.15) -> list[dict[str, np.ndarray]]:
    """What four strokes on an instrument look like to noisy sensors, at 4 kHz."""
    found = []
    for nuance, touch in STROKES:
        run = true.press(stroke=nuance, touch=touch, duration=duration, progress=False)
        one = {"time_s": run["time_s"][::5]}
        for column, sigma in NOISE.items():
            one[column] = run[column][::5] + sigma * rng.standard_normal(len(one["time_s"]))
        found.append(one)
    return found


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--repetitions", type=int, default=20)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--instrument", default="concert-grand-rigid")
    options.add_argument("--json", help="writes the numbers there")
    asked = options.parse_args()
    grand, rng = erard.load(asked.instrument), np.random.default_rng(asked.seed)
    truths = {name: far for name, far in TRUTHS.items() if name in grand.parameters}
    pulls: list[dict[str, float]] = []
    spent = time.perf_counter()
    for repetition in range(asked.repetitions):
        true = {}
        for name, far in truths.items():
            by = rng.uniform(-far, far)
            true[name] = by if grand.parameters[name].is_screw else float(np.exp(by))
        texts = {name: f"{by:+}" if grand.parameters[name].is_screw else f"x{by}" for name, by in true.items()}
        data = recordings(grand.vary(texts), rng)
        bounds = {k: v for k, v in BOUNDS.items() if k in truths}
        fit = erard.fit(grand, data, parameters=list(truths), bounds=bounds, sigma=NOISE)
        pull = {name: (fit.x[name] - true[name]) / fit.std[name] for name in truths}
        pulls.append(pull)
        worst = max(pull, key=lambda name: abs(pull[name]))
        print(
            f"{repetition + 1:2d}: chi2 {fit.chi2_reduced:.3f} ({fit.chi2_expected:.3f} expected), worst {worst} {pull[worst]:+.1f} sigma, "
            f"differences agree to {100 * fit.jacobian_agreement:.1f} %, {time.perf_counter() - spent:.0f} s",
            flush=True,
        )
    print(f"\n{'':32}{'std':>10}{'mean pull':>11}{'rms pull':>10}{'in 1 sigma':>12}{'in 2 sigma':>12}")
    all_pulls = np.array([[pull[name] for name in truths] for pull in pulls])
    for k, name in enumerate(truths):
        own = all_pulls[:, k]
        print(
            f"{name:32}{fit.std[name]:10.2g}{own.mean():11.2f}{np.sqrt(np.mean(own**2)):10.2f}"
            f"{100 * np.mean(np.abs(own) < 1):10.0f} %{100 * np.mean(np.abs(own) < 2):10.0f} %"
        )
    one, two = (100 * np.mean(np.abs(all_pulls) < limit) for limit in (1, 2))
    print(f"{'all':32}{'':10}{all_pulls.mean():11.2f}{np.sqrt(np.mean(all_pulls**2)):10.2f}{one:10.0f} %{two:10.0f} %")
    print(f"of {all_pulls.size} intervals; 68 and 95 % are expected; {time.perf_counter() - spent:.0f} s")
    if asked.json:
        with open(asked.json, "w", encoding="utf-8") as file:
            json.dump({"in_1_sigma": one / 100, "in_2_sigma": two / 100, "intervals": int(all_pulls.size), "pulls": pulls}, file, indent=1)


if __name__ == "__main__":
    main()
