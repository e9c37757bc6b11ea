# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
#   kernelspec:
#     name: python3
#     display_name: Python 3
# ---

# %% [markdown] # A million strokes Chunks go to the workers of a cluster, and each comes back as a Parquet file. Here
# two processes of this machine do it; a client of SLURM or Kubernetes does as well. `ERARD_STROKES` says how many
# strokes; the test plays few.

# %%
import os
import tempfile
import time

import numpy as np
import erard
from erard import distributed

strokes = int(os.environ.get("ERARD_STROKES", "1000000"))
side = round(strokes ** (1 / 3))
grand = erard.load("concert-grand")
axes = {
    "let_off": np.linspace(-5e-4, 5e-4, side),
    "body.hammer.mass": grand.parameters["body.hammer.mass"].value * np.linspace(0.9, 1.1, side),
}
force = np.linspace(3.0, 12.0, side)
folder = tempfile.mkdtemp() + "/study"
start = time.perf_counter()
parts = distributed.study(grand, folder, axes, force=list(force), duration=0.12, workers=2, chunk=min(4096, side**3 // 4 + 1))
seconds = time.perf_counter() - start
print(f"{side**3} strokes, {parts.parts} files, {side**3 / seconds:.0f} strokes per second with the cluster's start")

# %% [markdown]
# Interrupted, the same call goes on where it was: what is there is not computed again.

# %%
again = distributed.study(grand, folder, axes, force=list(force), duration=0.12, workers=2, chunk=min(4096, side**3 // 4 + 1))
assert again.computed == 0
table = again.read(["let_off", "body.hammer.mass", "force_N", "hammer_speed_m_per_s"]).to_pandas()
table.groupby("force_N")["hammer_speed_m_per_s"].agg(["min", "mean", "max"]).iloc[:: max(1, side // 5)]
