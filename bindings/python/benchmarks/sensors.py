"""Errors of speed and false notes, by algorithm, bits, rate and noise: the tables of docs/notes/sensors.md and the figure of the book's chapter on ground truth.

    python benchmarks/sensors.py --erard COMMAND [--quick] [--out FOLDER] [--figure FILE.svg]

`erard scan` writes data sets of two grands (`concert-grand:sample=1` and `2`) whose keys differ by what a technician leaves. The three baselines of
`erard.judge` are trained on the file's own grand with the same sensor, as a maker would train them on a piano of their own; Erard is `erard live` on
that same grand, with no fit at all. Nothing that is judged was trained on. It takes NumPy, and matplotlib for the figure.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

PACKAGE = Path(__file__).parents[1] / "python" / "erard"
PIECES = Path(__file__).parents[3] / "pieces"
# The judge is a file that needs no package: the table can be made without building one.
sys.path.insert(0, str(PACKAGE))
import judge  # noqa: E402

BITS, RATES, NOISES = (8, 12), (250, 1000, 4000), (0.02, 0.2)
QUICK = ((10,), (250, 1000), (0.05,))
#: pp. Softer hammers hardly reach the string: a little less of anything is much less of their speed.
PP_M_PER_S = 0.5
#: What is judged: two grands, each with a piece and all cases; and what the baselines are trained on.
SETS = {
    "one": ["hanon.mid", "--from", "4.5", "--to", "13", "--cases", "--keyboard", "concert-grand:sample=1", "--seed", "1"],
    "two": ["gymnopedie.mid", "--to", "14", "--cases", "--keys", "22,46,58,70", "--keyboard", "concert-grand:sample=2", "--seed", "2"],
}
TRAINING = ["hanon.mid", "--to", "8", "--cases", "stroke,staccato", "--keys", "10,16,28,40,46,52,64,76", "--keyboard", "concert-grand", "--no-scatter", "--seed", "99"]
NAMES = {"two-points": "two points", "slope": "slope at let-off", "one-degree": "one-degree hammer", "erard": "Erard"}


def scanned(erard: str, folder: Path, arguments: list[str], sensors: tuple[tuple[float, ...], ...]) -> judge.DataSet:
    """A data set, made if it is not there; the command leaves no half of one."""
    bits, rates, noises = (",".join(map(str, values)) for values in sensors)
    command = [erard, "scan", str(PIECES / arguments[0]), *arguments[1:], "--bits", bits, "--rate", rates, "--noise", noises, "--out", str(folder)]
    if not (folder / "scan.json").exists():
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return judge.DataSet(folder)


def of_erard(erard: str, scan: judge.Scan) -> judge.Notes:
    """The notes of `erard live`, which knows the file's own grand only."""
    notes = scan.path.with_suffix(".notes.csv")
    if notes.exists():
        return judge.Notes.read(notes)
    command = [erard, "live", str(scan.path), "--calibration", str(scan.profile), "--keyboard", "concert-grand", "--out-file", str(notes), "--quiet"]
    ran = subprocess.run(command, capture_output=True, text=True)
    if ran.returncode != 0:
        raise SystemExit(f"{' '.join(command)}: {ran.stderr}")
    return judge.Notes.read(notes)


def row(data: list[judge.DataSet], scores: list[judge.Score]) -> dict[str, float]:
    """Counts and errors of one cell, over both grands: errors of all notes from pp on, and of those that came from rest (strokes, staccato), also below pp."""
    counts = {name: sum(getattr(score, name) for score in scores) for name in ("matched", "missed", "false", "doubled")}
    errors = np.concatenate([score.velocity_error for score in scores])
    late = np.concatenate([score.time_error for score in scores])
    cases = np.concatenate([own.cases(score.true)[score.pairs[:, 0]] for own, score in zip(data, scores, strict=True)])
    plain = np.isin(cases, ["stroke", "staccato"])
    loud = np.concatenate([score.true.hammer_speed_m_per_s[score.pairs[:, 0]] for score in scores]) >= PP_M_PER_S

    def rms(chosen: np.ndarray) -> float:
        return float(np.sqrt(np.mean(errors[chosen] ** 2))) if chosen.any() else float("nan")

    (low, high), (early, late_most) = np.percentile(errors[loud], [5, 95]), 1e3 * np.percentile(late, [5, 95])
    return counts | {
        "plain_rms_counts": rms(plain & loud), "softer_rms_counts": rms(plain & ~loud), "rms_counts": rms(loud),
        "p5_counts": float(low), "p95_counts": float(high), "late_p5_ms": float(early), "late_p95_ms": float(late_most),
    }  # fmt: skip


def judged(erard: str, folder: Path, sensors: tuple[tuple[float, ...], ...]) -> list[dict[str, object]]:
    """All cells."""
    trained = scanned(erard, folder / "training", TRAINING, sensors)
    sets = [scanned(erard, folder / name, arguments, sensors) for name, arguments in SETS.items()]
    strikes = [int(np.count_nonzero(~one.truth.optional & (one.truth.hammer_speed_m_per_s >= judge.FAINT_M_PER_S))) for one in sets]
    print(f"{sum(strikes)} strikes that must be found, on {' and '.join(one.about['keyboard'] for one in sets)}", file=sys.stderr)

    def cell(index: int) -> list[dict[str, object]]:
        training = trained.scans[index]
        sensor = {"bits": training.bits, "rate_hz": training.rate_hz, "noise_percent": training.noise_percent}
        found = []
        for name in NAMES:
            if name == "erard":
                scores = [judge.compare(one.truth, of_erard(erard, one.scans[index])) for one in sets]
            else:
                algorithm = judge.BASELINES[name]()
                algorithm.train(trained, training)
                scores = [judge.judge(one, one.scans[index], algorithm) for one in sets]
            by_case: dict[str, dict[str, int]] = {}
            for one, score in zip(sets, scores, strict=True):
                of_true, of_found = one.cases(score.true), one.cases(score.found)
                groups = {"matched": of_true[score.pairs[:, 0]], "missed": of_true[score.missing], "false": of_found[score.surplus], "doubled": of_found[score.double]}
                for what, cases in groups.items():
                    for case in cases:
                        own = by_case.setdefault(str(case), dict.fromkeys(groups, 0))
                        own[what] += 1
            found.append({"algorithm": name, **sensor, **row(sets, scores), "cases": by_case})
        print(f"{training.path.name} judged", file=sys.stderr, flush=True)
        return found

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return [one for cells in pool.map(cell, range(len(trained.scans))) for one in cells]


def number(value: object, digits: int) -> str:
    """A number, or a dash where there was nothing to take it from."""
    return "-" if value is None or np.isnan(float(str(value))) else f"{value:.{digits}f}"


def markdown(cells: list[dict[str, object]]) -> str:
    """The tables: by sensor, and by case for the most bits at 1 kHz. Errors are counts of velocity."""
    lines = ["| bits | Hz | noise, % | algorithm | missed | false | doubled | plain strokes, rms | below pp, rms | all notes, rms | 5 to 95 % | instant, ms |", "|---" * 12 + "|"]
    for one in cells:
        span = f"{one['p5_counts']:.1f} to {one['p95_counts']:.1f}"
        late = f"{one['late_p5_ms']:.1f} to {one['late_p95_ms']:.1f}"
        sensor = f"| {one['bits']} | {one['rate_hz']:g} | {one['noise_percent']:g} "
        lines.append(
            f"{sensor}| {NAMES[str(one['algorithm'])]} | {one['missed']} | {one['false']} | {one['doubled']} "
            f"| {one['plain_rms_counts']:.2f} | {number(one['softer_rms_counts'], 1)} | {one['rms_counts']:.2f} | {span} | {late} |"
        )
    best = max(cells, key=lambda one: (int(str(one["bits"])), one["rate_hz"] == 1000, -float(str(one["noise_percent"]))))
    same = [one for one in cells if all(one[key] == best[key] for key in ("bits", "rate_hz", "noise_percent"))]
    lines += ["", f"By case at {best['bits']} bits, {best['rate_hz']:g} Hz, {best['noise_percent']:g} % of noise (missed, false, doubled of so many strikes):", ""]
    lines += ["| case | strikes | " + " | ".join(NAMES[str(one["algorithm"])] for one in same) + " |", "|---" * (2 + len(same)) + "|"]
    names = list(dict.fromkeys(case for one in same for case in one["cases"]))  # type: ignore[attr-defined]
    for case in names:
        counts = [one["cases"].get(case, dict.fromkeys(("matched", "missed", "false", "doubled"), 0)) for one in same]  # type: ignore[attr-defined]
        strikes = max(own["matched"] + own["missed"] for own in counts)
        lines.append(f"| {case or '(between)'} | {strikes} | " + " | ".join(f"{own['missed']}, {own['false']}, {own['doubled']}" for own in counts) + " |")
    return "\n".join(lines)


def figure(cells: list[dict[str, object]], path: Path) -> None:
    """Error of plain strokes and surplus notes, by rate, for each bits and the two noises."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams |= {"svg.hashsalt": "erard", "svg.fonttype": "path", "font.size": 9}
    import matplotlib.pyplot as plt

    bits, noises, rates = (sorted({one[key] for one in cells}) for key in ("bits", "noise_percent", "rate_hz"))  # type: ignore[type-var]
    shown = f"{bits[-1]} bits"
    drawn, axes = plt.subplots(2, len(noises), figsize=(7.2, 4.8), sharex=True, sharey="row", layout="constrained", squeeze=False)
    for index, noise in enumerate(noises):
        for name, marker in zip(NAMES, "osv^", strict=True):
            own = [one for one in cells if (one["algorithm"], one["bits"], one["noise_percent"]) == (name, bits[-1], noise)]
            axes[0, index].plot([one["rate_hz"] for one in own], [one["plain_rms_counts"] for one in own], marker=marker, label=NAMES[name])
            axes[1, index].plot([one["rate_hz"] for one in own], [one["missed"] + one["false"] + one["doubled"] for one in own], marker=marker)  # type: ignore[operator]
        axes[0, index].set_title(f"{shown}, noise {noise:g} % of the travel")
        axes[1, index].set(xscale="log", xlabel="readings a second, Hz", xticks=rates, xticklabels=[f"{rate:g}" for rate in rates])
        axes[1, index].minorticks_off()
    axes[0, 0].set_ylabel("error of plain strokes,\nrms counts of velocity")
    axes[1, 0].set_ylabel("notes missed, false or doubled")
    for axis in axes.flat:
        axis.set_ylim(bottom=0)
        axis.grid(alpha=0.3)
    drawn.legend(handles=axes[0, 0].get_lines(), loc="outside lower center", ncols=len(NAMES))
    plt.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None, dpi=150)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--erard", default="erard", help="the command")
    parser.add_argument("--quick", action="store_true", help="two sensors only")
    parser.add_argument("--out", type=Path, default=Path("erard-out-sensors"), help="folder of the data sets and of Erard's notes; those that are there are used again")
    parser.add_argument("--figure", type=Path, help="where the figure goes, .svg or .png")
    parser.add_argument("--again", action="store_true", help="do not judge: table and figure of the results that are in the folder")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    results = asked.out / "results.json"
    if not asked.again:
        began = time.perf_counter()
        cells = judged(asked.erard, asked.out, QUICK if asked.quick else (BITS, RATES, NOISES))
        part = results.with_suffix(".part")
        part.write_text(json.dumps(cells, indent=1))
        part.replace(results)
        print(f"{time.perf_counter() - began:.0f} s", file=sys.stderr)
    cells = json.loads(results.read_text())
    print(markdown(cells))
    if asked.figure:
        figure(cells, asked.figure)


if __name__ == "__main__":
    main()
