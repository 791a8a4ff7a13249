#!/usr/bin/python3
# %% [markdown]
# # Verify your own solver
#
# The validation cases of libmpm can be solved by any program. `mpm-validate export` writes a case as plain data, your program
# solves it, and `mpm-validate grade` applies the checks of libmpm to the results.
#
# The solver of this tutorial is as small as possible: rigid bodies in free flight. The case is `free_flight`: a stiff cube that
# is thrown and spins, and a block of snow that is thrown up.

# %%
import json
import pathlib
import shutil
import subprocess
import sys

import h5py
import numpy as np

from mpmtools import find_program

out = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "out/verify_your_solver")
shutil.rmtree(out, ignore_errors=True)
validate = find_program("mpm-validate")

# %% [markdown]
# ## Export the case

# %%
subprocess.run([validate, "export", "free_flight", "--out", out / "exported"], check=True)
case = json.loads((out / "exported" / "case.json").read_text(encoding="utf-8"))
for run in case["runs"]:
    print(run["id"], "|", run["title"], "|", run["particles"]["count"], "particles, dt =", run["time_step_s"], "s")

# %% [markdown]
# ## Solve it
#
# The particles of a run are arrays: position, velocity, mass and identity number. A rigid body is described by its centre, its
# velocity and its angular velocity. The centre moves by symplectic Euler: first the velocity, then the position. After n steps
# it is at x0 + v0 t + g t (t + dt)/2.
#
# The angular velocity follows from the angular momentum. The moment of inertia of a cube is the same about every axis, so the cube
# rotates steadily about a fixed axis.


# %%
def read_particles(run):
    with h5py.File(out / "exported" / run["id"] / "particles.h5") as file:
        arrays = {name: file[name][:] for name in file}
    position = np.stack([arrays[f"{axis}_m"] for axis in "xyz"], axis=1)
    velocity = np.stack([arrays[f"v{axis}_m_s"] for axis in "xyz"], axis=1)
    return arrays["id"], arrays["mass_kg"], position, velocity


def rotation(vector):
    """Matrix of the rotation about a vector by its length (Rodrigues)."""
    angle = np.linalg.norm(vector)
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def solve(run, gravity_error=0.0):
    """States at the times of a run: (position, velocity)."""
    _, mass, position, velocity = read_particles(run)
    centre, drift = (np.average(array, axis=0, weights=mass) for array in (position, velocity))
    arm, relative = position - centre, velocity - drift
    momentum = np.sum(mass[:, None] * np.cross(arm, relative), axis=0)
    inertia = np.einsum("p,pij->ij", mass, np.sum(arm**2, axis=1)[:, None, None] * np.eye(3) - arm[:, :, None] * arm[:, None, :])
    spin = np.linalg.solve(inertia, momentum)
    gravity = np.array(run["gravity_m_s2"]) * (1.0 + gravity_error)
    for time in run["results"]["times_s"]:
        dt = run["time_step_s"]
        turned = arm @ rotation(spin * time).T
        yield centre + drift * time + 0.5 * gravity * time * (time + dt) + turned, drift + gravity * time + np.cross(spin, turned)


def write_states(folder, run, states):
    identity = read_particles(run)[0]
    (folder / run["id"]).mkdir(parents=True)
    with h5py.File(folder / run["id"] / "states.h5", "w") as file:
        for number, (position, velocity) in enumerate(states, start=1):
            group = file.create_group(f"{number:04}")
            group["id"] = identity
            for i, axis in enumerate("xyz"):
                group[f"{axis}_m"], group[f"v{axis}_m_s"] = position[:, i], velocity[:, i]


for run in case["runs"]:
    write_states(out / "solved", run, solve(run))
shutil.copy(out / "exported" / "case.json", out / "solved")  # names the case and the level
(out / "solved" / "solver.json").write_text('{"name": "rigid bodies", "version": "1"}', encoding="utf-8")


# %% [markdown]
# ## Grade the results
#
# The exit code is 0 if every check passes, 1 if one fails. `report/index.html` shows the results and the plots.


# %%
def grade(results, report):
    done = subprocess.run([validate, "grade", "free_flight", "--results", results, "--out", report], text=True, capture_output=True, check=False)
    print(done.stdout, done.stderr, sep="\n")
    return done.returncode


assert grade(out / "solved", out / "report") == 0

# %% [markdown]
# ## Would it notice an error?
#
# A check that cannot fail is of no use. With gravity 0.1 % too large, checks fail:

# %%
for run in case["runs"]:
    write_states(out / "wrong", run, solve(run, gravity_error=1e-3))
shutil.copy(out / "exported" / "case.json", out / "wrong")
assert grade(out / "wrong", out / "report_wrong") == 1

# %% [markdown]
# ## Where to go on
#
# `validation/foreign/numpy_mpm.py` is a material point method in numpy that solves harder cases.
# docs/other-solvers.md describes every file and lists the cases.
