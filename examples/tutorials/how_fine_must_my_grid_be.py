#!/usr/bin/python3
# %% [markdown]
# # How fine must my grid be?
#
# A result of a simulation has an error that only finer grids can show. This tutorial finds it for the force and the pressure
# height of an avalanche on a mast, and answers the question for an accuracy of your choice.
#
# The grids are coarse and the runs short, so that it takes seconds. The procedure is that of a real study.

# %%
import math
import pathlib
import sys

import matplotlib

if not hasattr(sys, "ps1") and "ipykernel" not in sys.modules:
    matplotlib.use("Agg")  # a script draws into files
import matplotlib.pyplot as plt

from mpmtools import Case, plots, study_grids

out = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "out/how_fine")

# %% [markdown]
# ## The case
#
# The snow is slow (Froude number 1), so the flow is soon steady. The lengths of the pressure profile (bins, filter, measuring box)
# are fixed in metres. By default they are proportional to the cell size, and would add a bias that is not a grid error.

# %%
example = pathlib.Path(__file__).resolve().parent.parent / "avalanche_fr1.toml"
width = 1.75
case = Case.read(example).changed({
    "conveyor.width_m": 8.75,
    "conveyor.upstream_length_m": 7.0,
    "conveyor.downstream_length_m": 3.5,
    "output.duration_s": 4.0,
    "output.frames_per_second": 1,
    "measurement": {"bin_height_m": 0.125, "filter_length_m": 1.625, "box_upstream_m": 0.625, "box_inside_m": 0.125},
})

# %% [markdown]
# ## Three grids
#
# The mast is 2, 3 and 5 cells wide. Each grid is at least 1.3 times finer than the one before. A real study would use 5, 7, 11
# and 15 cells.

# %%
cells = [2, 3, 5]
metrics = ["force_mean_n.x", "pressure_height_mean_m"]
study = study_grids(case, [width / n for n in cells], metrics, out, threads=1)
print(study.table.round(3).to_string(index=False))

# %% [markdown]
# ## What the study reports
#
# For each metric: the observed order of convergence, the extrapolated limit, the uncertainty of the finest grid, and a verdict.
# The verdict states whether order and limit are reliable. On grids as coarse as these they are not. The study reports this and
# increases the uncertainty.

# %%
for name in metrics:
    found = study.metric(name)
    uncertainty = "unknown" if found["uncertainty"] is None else f"{found['uncertainty']:.2g}"
    print(f"{name}: {found['value'][-1]:.4g} on the finest grid, uncertainty {uncertainty}")
    print("   ", found["verdict"])

# %%
figure, axes = plt.subplots(1, 2, figsize=(12, 4.5), layout="constrained")
for name, part in zip(metrics, axes):
    plots.grid_study(study, name, part)
figure.savefig(out / "grids.png", dpi=100)

# %% [markdown]
# ## Which grid for 5 %?
#
# At order 1, the order at obstacles, half the cell size halves the error, and the run takes 16 times as long. The number of cells
# for a given accuracy then follows from the uncertainty of the finest grid. It is a statement for the next grid or two, not for one
# that is more than four times finer: there the order that was assumed decides, not the study.

# %%
goal = 0.05
for name in metrics:
    found = study.metric(name)
    if found["uncertainty"] is None:
        print(f"{name}: no uncertainty: {found['verdict']}")
        continue
    relative = abs(found["uncertainty"] / found["value"][-1])
    needed = math.ceil(cells[-1] * max(1.0, relative / goal))
    if needed > 4 * cells[-1]:
        print(f"{name}: {100 * relative:.0f} % with {cells[-1]} cells across the mast: too coarse to say what {100 * goal:.0f} % need; add finer grids")
        continue
    print(f"{name}: {100 * relative:.0f} % with {cells[-1]} cells across the mast; {100 * goal:.0f} % need about {needed} cells, "
          f"{max(1.0, needed / cells[-1]) ** 4:.0f} times the work")

# %% [markdown]
# ## Without a study
#
# The results of every run contain an estimate of the grid error. It comes from grid studies of the validation suite at the same
# resolution. It does not replace a study of your own case:

# %%
finest = study.runs[-1]
print("force:", finest.quantity("force_mean_n"))
print("run-up:", finest.quantity("runup_p99_mean_m"))
