# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
#   kernelspec:
#     name: python3
#     display_name: Python 3
# ---

# %% [markdown] # My own recording A recording is a table with a column for the time and any of force, position and
# hammer. Here one is made, with the sensors' noise; yours may be a CSV or Parquet file, a data frame, or a mapping of
# arrays. Titles say the units: `Time (ms)`, `Force (gf)`, `Travel [mm]`.

# %%
import numpy as np
import pandas as pd
import erard

grand = erard.load("concert-grand")
true = grand.vary({"body.hammer.mass": "x1.1"})
played, rng = true.press(stroke="mf", duration=0.15), np.random.default_rng(1)
rows = slice(None, None, 10)
frame = pd.DataFrame(
    {
        "Time (ms)": 1e3 * played["time_s"][rows],
        "Force (gf)": played["force_N"][rows] / 9.80665e-3 + rng.normal(0, 2, len(played["time_s"][rows])),
        "Travel [mm]": 1e3 * played["key_m"][rows] + rng.normal(0, 0.01, len(played["time_s"][rows])),
    }
)
frame.head()

# %% [markdown]
# What the reader made of it:

# %%
mine = erard.Recording(frame)
print(mine)
for note in mine.notes:
    print("-", note)

# %% [markdown]
# Beside the model: what drives it, what comes out, what is missed.

# %%
compared = grand.compare(mine, models=["action"])
for verdict in compared.verdicts:
    print("-", verdict)
errors = pd.DataFrame(compared.errors)[["drive", "quantity", "rms", "explained", "delay_s"]]
errors

# %% [markdown] The same force on the model, as a run of its own. Our hammer is lighter than the recorded one and comes
# to the string earlier. Its speed is nearly the same: the force of this stroke swells, and what comes later finds a
# larger force and more work.

# %%
run = grand.press(stroke=mine)
run.plot("force_N", "key_m", "hammer_rise_m")
for name, one in (("recorded", played), ("model", run)):
    up_to = one["time_s"] <= one.events["hammer_contact"]
    work = np.trapezoid(one["force_N"][up_to], one["key_m"][up_to])
    print(f"{name}: {one.hammer_speed:.3f} m/s at {1e3 * one.events['hammer_contact']:.2f} ms, {1e3 * work:.1f} mJ of the finger until then")
assert run.events["hammer_contact"] < played.events["hammer_contact"] - 1e-3
