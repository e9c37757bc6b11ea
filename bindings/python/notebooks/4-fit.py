# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
#   kernelspec:
#     name: python3
#     display_name: Python 3
# ---

# %% [markdown] # Fitting a recording Two strokes of an action whose hammer is heavier and whose heel is harder than the
# file says, recorded by noisy sensors. `sigma` says how noisy: also the load cell, whose force drives the model. What
# its noise does to the model is the larger part of the errors; without it they would be too small.

# %%
import numpy as np
import erard

grand = erard.load("concert-grand-rigid")
truth = {"body.hammer.mass": 1.06, "zone.capstan_heel.stiffness": 1.3, "body.key.friction": 0.8}
noise = {"force_N": 0.02, "key_m": 1e-5, "hammer_rise_m": 5e-5}
rng = np.random.default_rng(1)
recordings = []
for nuance in ("mf", "f"):
    run = grand.vary({name: f"x{factor}" for name, factor in truth.items()}).press(stroke=nuance, duration=0.1)
    rows = {name: run[name][::10] for name in ("time_s", "force_N", "key_m", "hammer_rise_m")}
    for name, sigma in noise.items():
        rows[name] = rows[name] + sigma * rng.standard_normal(len(rows[name]))
    recordings.append(rows)
fit = erard.fit(grand, recordings, parameters=list(truth), sigma=noise)
fit

# %%
fit.plot()

# %% [markdown] `x` holds the factors, `values` the values; `instrument` is the fitted instrument. What the data do not
# tell is said: a felt that this stroke never touches.

# %%
for name, true in truth.items():
    print(f"{name}: {fit.x[name]:.3f} +- {fit.std[name]:.3f}, true {true}")
    assert abs(fit.x[name] - true) < 4 * fit.std[name]
cut = {name: values[:60] for name, values in recordings[0].items()}
print(erard.fit(grand, cut, parameters=["body.hammer.mass", "zone.check.stiffness"]).unseen)
