# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
#   kernelspec:
#     name: python3
#     display_name: Python 3
# ---

# %% [markdown] # Ground truth for sensor pianos A data set with labels: what two optical sensors read, and how fast the
# hammer truly was. Two estimators are scored; neither is clever.

# %%
import tempfile

import numpy as np
import erard
from erard import dataset

plan = dataset.Plan(count=96, seed=1, keys=(16, 40, 64), chunk=48)
folder = dataset.write(plan, tempfile.mkdtemp() + "/strokes")
table = dataset.read(folder)
print((folder / "README.md").read_text()[:600])

# %% [markdown] The first estimator is that of most digital pianos: the time between two thresholds of the sensor at the
# shank, which is the mean speed on that way. The second fits a parabola to all samples between them, after turning
# counts into millimetres with the sensor's characteristic, and reads its slope at the end: the hammer still gets faster
# on its last millimetres. Neither knows the full scale of each key's sensor, which differs by some per cent.

# %%
sensor = dataset.AT_SHANK
full = 2**sensor.bits - 1
ways = np.linspace(sensor.from_m, sensor.to_m, 500)
curve = full * sensor.characteristic(ways)
low, high = np.interp([0.2, 0.9], curve / full, ways)


def estimates(counts: np.ndarray) -> tuple[float, float]:
    """Two-point and fitted speed, m/s; nan where the vane does not come so far."""
    t = np.arange(len(counts)) / sensor.rate_hz
    way = np.interp(counts, curve, ways)
    above = np.flatnonzero(way >= high)
    if not above.size:
        return np.nan, np.nan
    end = above[0]
    before = np.flatnonzero(way[:end] <= low)
    if not before.size or end == 0:
        return np.nan, np.nan
    start = before[-1]
    two_point = (way[end] - way[start]) / (t[end] - t[start])
    rows = slice(start, end + 1)
    if end - start < 3:
        return two_point, two_point
    _, slope, _ = np.polyfit(t[rows] - t[end], way[rows], 2)
    return two_point, slope


rows = table.to_pylist()
truth = np.array([row["hammer_speed_m_per_s"] or np.nan for row in rows])
found = np.array([estimates(np.array(row["shank_counts"])) for row in rows])
both = np.isfinite(truth) & np.isfinite(found).all(axis=1)
for name, own in zip(("two-point", "fit"), found[both].T, strict=True):
    error = own / truth[both] - 1
    print(f"{name}: {both.sum()} strokes, bias {100 * np.median(error):+.1f} %, spread {100 * np.std(error):.1f} %")
missed = int(np.sum(np.isfinite(truth) & ~both))
false = int(np.sum(~np.isfinite(truth) & np.isfinite(found[:, 0])))
print(f"{missed} impacts missed, {false} told that were none")
assert both.sum() > 20
