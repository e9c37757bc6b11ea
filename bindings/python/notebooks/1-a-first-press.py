# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
#   kernelspec:
#     name: python3
#     display_name: Python 3
# ---

# %% [markdown]
# # A first press
# Load the built-in concert grand and press the key with 5 N. The notebook shows the run as a figure.

# %%
import erard

grand = erard.load("concert-grand")
run = grand.press(force=5.0, duration=0.2)
run

# %% [markdown]
# What happened, and when (s; the hammer's speed in m/s):

# %%
dict(run.events)

# %% [markdown]
# Columns are NumPy arrays, named with their units. They are read-only views: nothing was copied.

# %%
print(run.columns)
print("deepest:", 1e3 * run["key_m"].max(), "mm;", "largest force on the string:", run["string_N"].max(), "N")
run.to_pandas().head()

# %% [markdown]
# The action where the jack lets the hammer go:

# %%
grand.draw("let_off", force=5.0, labels=True, forces=True)

# %% [markdown]
# A heavier hammer, and the let-off 0.2 mm further from the string's rest:

# %%
other = grand.vary({"body.hammer.mass": "+0.8 g"}, let_off="-0.2 mm")
heavy = other.press(force=5.0, duration=0.2)
print(f"{run.hammer_speed:.3f} m/s, heavier: {heavy.hammer_speed:.3f} m/s")
assert heavy.hammer_speed < run.hammer_speed
