#!/usr/bin/python3
# %% [markdown]
# # A first mast
#
# Loose snow, 1.75 m deep, hits a mast 1.75 m wide at 12.4 m/s. How high does it climb, up to which height does it press,
# and with what force?
#
# The grid of this tutorial is coarse (three cells across the mast), so that it takes seconds. The numbers are not for design.

# %%
import pathlib
import sys

import matplotlib

if not hasattr(sys, "ps1") and "ipykernel" not in sys.modules:
    matplotlib.use("Agg")  # a script draws into files
import matplotlib.pyplot as plt

from mpmtools import Case, compare, plots, write_vtp

out = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "out/first_mast")

# %% [markdown]
# ## The case
#
# A case is a table of keys with their units. `changed` returns another case. The example has the mast of the paper; here the
# cells are larger and the channel is narrower.

# %%
example = pathlib.Path(__file__).resolve().parent.parent / "avalanche_fr3.toml"
case = Case.read(example).changed({
    "numerics.cell_size_m": 1.75 / 3,
    "conveyor.width_m": 10.5,
    "output.duration_s": 5.0,
})
print(case["obstacle.width_m"], "m wide")

# %% [markdown]
# ## Check before you run
#
# `check` does not run the case. It estimates the cost and warns of settings that may make the result inaccurate. Here it warns of
# the coarse grid.

# %%
check = case.check()
print(check)
print("transfer between particles and grid, a default:", check.case["numerics.transfer"])

# %% [markdown]
# ## Run

# %%
run = case.run(out / "frictionless", threads=1, force=True)
for name in ("runup_p99_mean_m", "pressure_height_mean_m", "force_mean_n"):
    print(f"{name}: {run.quantity(name)}")

# %% [markdown]
# The first error is statistical: the flow fluctuates, and the mean is taken over a few seconds. The second is an estimate of the
# grid error. With three cells across the mast it is large.
#
# ## Draw figures
#
# Every function of `plots` returns matplotlib axes. The first splash stays in the air for 2v/g = 2.5 s; then the flow is steady.

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(13, 4.5), layout="constrained")
plots.runup(run, left)
plots.profile(run, right)
figure.savefig(out / "first_mast.png", dpi=100)

# %%
axes = plots.side_view(run)
axes.figure.savefig(out / "side_view.png", dpi=100)

# %% [markdown]
# The time series are a pandas DataFrame over time; the particles are numpy arrays (`last.table`: a DataFrame). `write_vtp` writes them for ParaView.

# %%
print(run.series[["runup_p99_m", "force_x_n"]].describe().loc[["mean", "max"]])
last = run.frames[-1]
print(len(last["position_m"]), "particles at t =", last.time, "s")
write_vtp(last, out / "last.vtp")

# %% [markdown]
# ## Change one thing
#
# How much does friction of the mast change the results? `compare` checks whether the difference of each quantity exceeds twice the
# combined standard error.

# %%
rough = case.changed({"obstacle.friction": 0.5}).run(out / "rough", threads=1, force=True)
table = compare(run, rough)
print(table.loc[["runup_p99_mean_m", "pressure_height_mean_m", "force_mean_n.x"], ["a", "b", "relative", "verdict"]])

# %% [markdown]
# ## Where to go on
#
# - How fine must the grid be? `how_fine_must_my_grid_be.py`
# - Loads for a report: `mpm design`, described in docs/design.md.
