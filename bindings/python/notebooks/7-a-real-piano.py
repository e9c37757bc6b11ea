# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
#   kernelspec:
#     name: python3
#     display_name: Python 3
# ---

# %% [markdown] # A real piano Greg Zweigle recorded a key and its hammer on a Kawai KG-3C action with optical sensors
# (Piano-Data, 2023, MIT licence). Three strokes are in the project's folder `recordings`; its README says what is
# measured, and what is guessed: above all the scale of the hammer's head.

# %%
import os
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd
import erard

folder = Path(os.environ.get("ERARD_RECORDINGS", "../../../recordings"))
strokes = {name: pd.read_csv(folder / f"kawai-kg-3c-{name}.csv") for name in ("slow", "medium", "fast")}
figure, axes = plt.subplots(1, 3, figsize=(12, 3))
for (name, frame), axis in zip(strokes.items(), axes, strict=True):
    axis.plot(frame.time_s, frame.hammer_head_mm, frame.time_s, frame.key_mm)
    axis.set(title=name, xlabel="time (s)", ylabel="hammer, key (mm)")

# %% [markdown] The slow press shows let-off and drop as a technician reads them; the built-in action with published
# arms of a Steinway is turned to that.

# %%
slow = strokes["slow"]
top = slow.hammer_head_mm[: len(slow) // 2].idxmax()
blow = max(frame.hammer_head_mm.max() for frame in strokes.values())
after = slow.hammer_head_mm[top + 60 : top + 160].median()
print(f"let-off {blow - slow.hammer_head_mm[top]:.1f} mm, drop {slow.hammer_head_mm[top] - after:.1f} mm, dip {slow.key_mm.max():.1f} mm")
like = erard.load("steinway-o").regulate(blow="50.8 mm", dip="11.7 mm", let_off="3.8 mm", drop="2.2 mm", check="18 mm")

# %% [markdown]
# The recorded key leads the model's. What the hammer does is then the model's answer.

# %%
for name, low_pass in (("slow", 20.0), ("medium", 250.0), ("fast", 250.0)):
    compared = like.compare(erard.Recording(strokes[name], low_pass=low_pass), drives=["rigid"], models=["action"])
    found = pd.DataFrame(compared.errors).set_index("quantity").loc["hammer"]
    print(f"{name}: {100 * found.explained:.1f} % of the hammer's variance, {1e3 * found.rms:.2f} mm rms, {1e3 * found.delay_s:+.1f} ms")
    assert found.explained > 0.97

# %% [markdown] Good, but not perfect. A fit of the fast stroke will turn whatever it is given. Here that is let-off
# and the hammer's mass. Let-off ends at its bound, the mass a sixth above the model's, and the misfit is three
# times what noise explains: the model is wrong somewhere else (that action stood in a frame of its own, its masses are
# not known). The fit says so itself, and its errors are too small.

# %%
fast = strokes["fast"]
rise = fast[(fast.time_s > 0.2) & (fast.time_s < 0.34)].assign(time_s=lambda rows: rows.time_s - 0.2)
fit = erard.fit(like, rise, parameters=["let_off", "body.hammer.mass"], restarts=1)
print(f"misfit {fit.chi2_reduced:.1f}, explained by noise {fit.chi2_expected:.1f}")
assert fit.chi2_reduced > 2.7 * fit.chi2_expected and abs(fit.x["body.hammer.mass"] - 1.16) < 0.05
assert {"misfit", "bound"} <= {doubt.kind for doubt in fit.doubts}
fit

# %%
fit.plot()
