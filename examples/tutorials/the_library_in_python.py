#!/usr/bin/python3
# %% [markdown]
# # The library in Python
#
# How does the snow of the model fail? What do the paper's equations predict? What happens in a scene from step to
# step? You can answer such questions without files: the module `libmpm` calls the library in the Python process and
# returns arrays.
#
# `./run python` builds the module into `build/python/python`. Start this script with that folder in `PYTHONPATH`.

# %%
import pathlib
import sys

import matplotlib

if not hasattr(sys, "ps1") and "ipykernel" not in sys.modules:
    matplotlib.use("Agg")  # a script draws into files
import matplotlib.pyplot as plt
import numpy as np

try:
    from libmpm import Simulation, bernoulli_height, effective_friction, point_path, predicted_runup
except ImportError:
    sys.exit("the module libmpm was not found: build it with ./run python, and set PYTHONPATH=build/python/python")

out = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "out/library")
out.mkdir(parents=True, exist_ok=True)
examples = pathlib.Path(__file__).resolve().parent.parent

# %% [markdown]
# ## A material point
#
# `point_path` takes one material point along a strain path. Its arguments are the text of a path file (TOML, as for
# `mpm point`) and changes of single keys. Here snow is compressed, then sheared at constant volume, for three values of
# the hardening ξ.
#
# The path ends at the critical state, in which pressure p and shear stress q no longer change. Without cohesion this
# state is on the line q = M p.

# %%
text = (examples / "paths" / "compression_then_shear.toml").read_text(encoding="utf-8")
paths = {xi: point_path(text, [f"material.hardening_xi={xi}", "material.cohesion_beta=0"]) for xi in (0.5, 1.0, 2.0)}
figure, (left, right) = plt.subplots(1, 2, figsize=(13, 4.5), layout="constrained")
for xi, path in paths.items():
    left.plot(1e-3 * path["p_pa"], 1e-3 * path["q_pa"], label=f"ξ = {xi:g}")
    right.plot(path["eps_q"], 1e-3 * path["p_pa"])
    end = path["q_pa"][-1] / path["p_pa"][-1]
    print(f"xi = {xi:g}: compressed to {1e-3 * path['p_pa'].max():.1f} kPa, q/p = {end:.3f} at the end")
    assert abs(end - 0.8) < 0.01  # M
most = 1e-3 * max(path["p_pa"].max() for path in paths.values())
left.plot([0.0, most], [0.0, 0.8 * most], color="0.6", linestyle="--", label="critical state, q = M p")
left.set(xlabel="pressure $p$ (kPa)", ylabel="shear stress $q$ (kPa)", title="Sheared snow ends on q = M p")
right.set(xlabel="shear strain", ylabel="pressure $p$ (kPa)", title="The pressure falls until the critical state")
left.legend()
figure.savefig(out / "point_path.png", dpi=100)

# %% [markdown]
# ## The equations of the paper
#
# The functions take numbers or arrays. How high does a flow 1.75 m deep climb up a mast of the same width? M' combines friction
# and cohesion (Eq. 2 of the paper). A fast flow stays below Bernoulli's bound, and a larger M' lowers its run-up. A
# slow flow piles up in front of the mast, and a larger M' raises the pile.

# %%
speed = np.linspace(1.0, 20.0, 100)
figure, axes = plt.subplots(figsize=(6.5, 4.5), layout="constrained")
for slope, cohesion in ((0.1, 0.0), (0.4, 0.0), (0.4, 0.3), (1.2, 0.0)):
    friction = effective_friction(slope, cohesion)
    label = f"M = {slope:g}, β = {cohesion:g}: M' = {friction:.2f}"
    axes.plot(speed, predicted_runup(friction, speed, 1.75), label=label)
axes.plot(speed, bernoulli_height(speed, 1.75), color="0.6", linestyle="--", label="Bernoulli's bound")
axes.set(xlabel="speed of the flow (m/s)", ylabel="run-up (m)", ylim=(0.0, 16.0),
         title="Run-up of the paper's equation, flow and mast 1.75 m")
axes.legend()
figure.savefig(out / "predictions.png", dpi=100)

# %% [markdown]
# ## A scene, from step to step
#
# A `Simulation` is a case in memory. `advance` steps it up to a time, and returns the force on every wall in every
# step. `particles` returns copies of positions, velocities and stresses. Here a round column collapses; a quarter of
# it is computed.

# %%
column = Simulation((examples / "column_collapse.toml").read_text(encoding="utf-8"), ["numerics.cell_size_m=0.125"])
print(column.particle_count, "particles; the first step may take", f"{1e3 * column.stable_time_step:.2f} ms")
floor = 0  # number of the wall; the obstacle, if there is one, is column.obstacle


def state():
    """Mass (kg) and vertical momentum (kg m/s) of the quarter: the case's density is the default, 300 kg/m^3."""
    particles = column.particles()
    mass = 300.0 * particles["reference_volume_m3"]
    return mass.sum(), np.sum(mass * particles["velocity_m_s"][:, 2])


figure, (left, right) = plt.subplots(1, 2, figsize=(13, 4.5), layout="constrained")
histories = []
for time in (0.0, 0.3, 1.0):
    histories.append(column.advance(time))
    x, y, z = column.particles()["position_m"].T
    section = y < 0.125
    left.scatter(x[section], z[section], s=6, label=f"t = {time:g} s")
left.set(xlabel="distance from the axis (m)", ylabel="height (m)", aspect="equal", title="Section of the column")
left.legend()

# %% [markdown]
# The force is that of the snow on the floor, so it points down. The impulse of the floor, the impulse of the weight and
# the momentum balance to round-off.

# %%
t, dt, force = (np.concatenate([history[name] for history in histories]) for name in ("time_s", "dt_s", "force_n"))
mass, momentum = state()
weight = 9.81 * mass
print(f"{column.steps} steps, force on the floor between {-1e-3 * force[:, floor, 2].max():.1f} and "
      f"{-1e-3 * force[:, floor, 2].min():.1f} kN, weight {1e-3 * weight:.1f} kN")
lost = np.sum(force[:, floor, 2] * dt) + weight * column.time + momentum  # the column starts at rest
print(f"momentum that is lost: {lost:.1e} of {weight * column.time:.0f} N s")
assert abs(lost) < 1e-9 * weight * column.time
right.plot(t, -1e-3 * force[:, floor, 2], linewidth=0.8, label="force on the floor")
right.axhline(1e-3 * weight, color="0.6", linestyle="--", label="weight")
right.set(xlabel="time (s)", ylabel="force (kN)", title="Force on the floor, a quarter of the column")
right.legend()
figure.savefig(out / "column.png", dpi=100)

# %% [markdown]
# ## Where to go on
#
# - The module does not measure run-up, pressures or standard errors. `Case.run` of mpmtools does: `a_first_mast.py`.
# - The material laws are explained in docs/theory/law.md.
