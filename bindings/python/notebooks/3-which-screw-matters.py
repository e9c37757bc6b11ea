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
# # Which screw matters?
# Every screw is turned a tenth of a millimetre either way and the same stroke is played, all variants side by side.

# %%
import numpy as np
import pandas as pd
import erard

grand = erard.load("concert-grand")
turn = 0.1e-3
screws = [name for name, one in grand.parameters.items() if one.is_screw and one.unit == "m"]
rows = []
for screw in screws:
    study = erard.study(grand, {screw: [-turn, 0.0, turn]}, stroke="mf", progress=False)
    speed, at, off = (study[name] for name in ("hammer_speed_m_per_s", "hammer_contact_s", "let_off_s"))
    rows.append(
        {
            "screw": screw,
            "speed, % per 0.1 mm": 50 * (speed[2] - speed[0]) / speed[1],
            "contact, ms per 0.1 mm": 500 * (at[2] - at[0]),
            "let-off, ms per 0.1 mm": 500 * (off[2] - off[0]),
        }
    )
table = pd.DataFrame(rows).set_index("screw").sort_values("speed, % per 0.1 mm", key=abs, ascending=False)
table.round(3)

# %% [markdown] These are differences over the width of a turn, which is what a technician can do: derivatives at a
# point would say less where let-off or check jump from one way to another. A let-off that is nan did not happen: a
# tenth further, and the jack still pushes when the hammer is at the string.

# %%
first = table.index[0]
study = erard.study(grand, {first: np.linspace(-4e-4, 4e-4, 33)}, force=[4.0, 8.0], progress=False)
study.plot("hammer_speed_m_per_s")
