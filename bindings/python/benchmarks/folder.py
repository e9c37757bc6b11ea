"""Writes the sensor benchmark as a folder for builders of keyboards: labelled streams, a hidden half, a scorer, four baselines.

    python benchmarks/folder.py --erard COMMAND --out FOLDER --truth FOLDER [--seed N] [--short]

FOLDER/training and FOLDER/labelled are data sets of `erard scan` with their truth. FOLDER/hidden has readings only: its piano,
its scatter and its noise come from a seed that is drawn anew (or given), and no file of the folder tells it. Its truth goes
into the folder of --truth, which whoever runs the benchmark keeps: `python judge.py TRUTH NOTES.csv` scores an answer. The
README holds the table of four baselines on both halves: 1/dt (two switches: distance over time), the slope at let-off, a
hammer with one degree of freedom (these three are trained on FOLDER/training), and `erard live` with the usual grand, without
any fit. It takes NumPy.
"""

from __future__ import annotations

import argparse
import json
import secrets
import shutil
import sys
from pathlib import Path

import sensors
from sensors import judge

ROOT = Path(__file__).parents[3]
SENSORS = ((10,), (500, 1000), (0.05,))
TRAINING = ["hanon.mid", "--to", "6", "--cases", "stroke,staccato", "--keys", "16,40,64", "--keyboard", "concert-grand", "--no-scatter", "--seed", "99"]
LABELLED = ["hanon.mid", "--from", "4.5", "--to", "10", "--cases", "--keys", "28,52"]
HIDDEN = ["gymnopedie.mid", "--to", "12", "--cases", "--keys", "22,46,58"]
#: For a trial of this program: a few seconds of each.
SHORT = {"--from": "0", "--to": "1.5", "--keys": "40,52"}
NAMES = sensors.NAMES | {"two-points": "1/dt (two switches)"}

README = """# A key's sensor, and the hammer behind it: a benchmark

Optical or magnetic sensors read where a piano key is. A digital keyboard must tell from these readings when a hammer would
have struck, and how fast; without false notes where none strikes. Here are readings of {keys} simulated grand keys, and the true
strikes of half of them.

| folder | content |
|---|---|
| `training` | a grand as regulated, plain strokes, with the truth: fit what you like on it |
| `labelled` | another grand, as a technician leaves one, all motions that mislead; with the truth |
| `hidden` | a third grand and another piece; readings only |
| `judge.py` | the scorer: NumPy, one file. `python judge.py labelled notes.csv` |

A `scan-*.csv` has the readings: `time_us`, `key` (1 to 88), `raw`. `profile-*.toml` has each key's readings at rest and pressed,
and the travel between them in mm. `truth.csv` has the strikes: `key`, `time_s`, `hammer_speed_m_per_s`; those with `again` 1 are
bounces, which may be found and need not. `windows.csv` tells what was played when. Your answer for each scan is a CSV file with
`key`, `time_s`, `hammer_speed_m_per_s` (or `velocity`); an answer to `hidden` is scored by who has its truth.

```python
import judge
for one in judge.DataSet("labelled").scans:          # or judge.Scan of a file of `hidden`
    for key, t, x in one.keys():                     # s, mm
        ...                                          # your algorithm
```

## Baselines

A note is found within 35 ms of its strike. Errors are counts of MIDI velocity (2.8 % of the hammer's speed each) over all notes
that were found at half a metre a second and more.

{table}

## Where it comes from

Made by Erard {version} (commit {commit}), whose book has the model, its measures against real pianos and its misses: every
strike here is simulated, and many parameters of these grands are estimates. Data and scorer are under MIT or Apache-2.0, at
your option. The seed of `hidden` is in no file of this folder.
"""


def table(erard: str, training: judge.DataSet, halves: dict[str, judge.DataSet]) -> str:
    """The four baselines on both halves."""
    lines = ["| half | Hz | algorithm | strikes | missed | false | doubled | error, rms | 5 to 95 % |", "|---" * 9 + "|"]
    for half, data in halves.items():
        for index, scan in enumerate(data.scans):
            for name, called in NAMES.items():
                if name == "erard":
                    score = judge.compare(data.truth, sensors.of_erard(erard, scan))
                else:
                    algorithm = judge.BASELINES[name]()
                    algorithm.train(training, training.scans[index])
                    score = judge.judge(data, scan, algorithm)
                true = score.true.hammer_speed_m_per_s[score.pairs[:, 0]]
                errors = score.velocity_error[true >= sensors.PP_M_PER_S]
                low, high = sensors.np.percentile(errors, [5, 95]) if len(errors) else (float("nan"),) * 2
                rms = sensors.np.sqrt(sensors.np.mean(errors**2)) if len(errors) else float("nan")
                lines.append(
                    f"| {half} | {scan.rate_hz:g} | {called} | {score.matched + score.missed} | {score.missed} | {score.false} | {score.doubled} "
                    f"| {rms:.1f} | {low:.1f} to {high:.1f} |"
                )
    return "\n".join(lines)


def hide(made: Path, to: Path) -> None:
    """Copies what a builder may see of a data set: readings and profiles, not the truth, nor how it was made."""
    about = json.loads((made / "scan.json").read_text(encoding="utf-8"))
    to.mkdir()
    for scan in about["scans"]:
        for name in (scan["file"], scan["profile"]):
            shutil.copyfile(made / name, to / name)
    seen = {"format": "erard-scan-hidden/1", "scans": about["scans"], "keys": [one["key"] for one in about["keys"]]}
    (to / "scan.json").write_text(json.dumps(seen, indent=1) + "\n", encoding="utf-8")


def told(folder: Path, words: list[str]) -> list[str]:
    """Files of a folder that hold one of the words."""
    return [f"{path}: {word}" for path in sorted(folder.rglob("*")) if path.is_file() for word in words if word in path.read_text(encoding="utf-8", errors="replace")]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--erard", default="erard", help="the command")
    parser.add_argument("--out", type=Path, required=True, help="the folder for builders; must not exist")
    parser.add_argument("--truth", type=Path, required=True, help="the folder of the hidden half's truth; must not exist, nor lie in the other one")
    parser.add_argument("--seed", type=int, help="seed of the hidden half (default: drawn)")
    parser.add_argument("--short", action="store_true", help="a few seconds of each: for a trial of this program")
    asked = parser.parse_args()
    out, truth = asked.out.resolve(), asked.truth.resolve()
    if out.exists() or truth.exists() or truth.is_relative_to(out):
        parser.error("--out and --truth name two new folders, one not in the other")
    seed = secrets.randbelow(2**31) if asked.seed is None else asked.seed

    def of(arguments: list[str]) -> list[str]:
        return [SHORT.get(before, one) if asked.short else one for before, one in zip(["", *arguments], arguments, strict=False)]

    out.mkdir(parents=True)
    training = sensors.scanned(asked.erard, out / "training", of(TRAINING), SENSORS)
    labelled = sensors.scanned(asked.erard, out / "labelled", [*of(LABELLED), "--keyboard", "concert-grand:sample=1", "--seed", "1"], SENSORS)
    hidden = sensors.scanned(asked.erard, truth, [*of(HIDDEN), "--keyboard", f"concert-grand:sample={seed}", "--seed", str(seed)], SENSORS)
    rows = table(asked.erard, training, {"labelled": labelled, "hidden": hidden})
    # What `erard live` found is in the table, not in the folder.
    for answer in out.rglob("*.notes.csv"):
        answer.unlink()
    hide(truth, out / "hidden")
    shutil.copyfile(sensors.PACKAGE / "judge.py", out / "judge.py")
    for name in ("LICENSE-MIT", "LICENSE-APACHE"):
        shutil.copyfile(ROOT / name, out / name)
    made_by = labelled.about["made_by"]
    keys = sum(len(one.about["keys"]) for one in (training, labelled, hidden))
    (out / "README.md").write_text(README.format(keys=keys, table=rows, version=made_by["version"], commit=made_by.get("commit", "unknown")), encoding="utf-8")
    if found := told(out, [f"sample={seed}", f'"seed": {seed},', *(one["digest"] for one in hidden.about["keys"])]):
        sys.exit("error: folder.py: the folder tells the hidden half:\n" + "\n".join(found))
    print(rows)
    size = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
    print(f"\n{out}: {size / 1e6:.1f} MB; seed {seed}, keep it with {truth}", file=sys.stderr)


if __name__ == "__main__":
    main()
