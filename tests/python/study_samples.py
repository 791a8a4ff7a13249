"""Runs, samples and folders that the tests of the study share."""

import contextlib
import io
import os
import pathlib
import unittest.mock

import in_folder
import numpy as np
import pandas as pd

from mpmtools import equations
from mpmtools.__main__ import main
from mpmtools.equations import relative_height
from analysis import uncertainty

SOURCE = pathlib.Path(__file__).resolve().parent.parent.parent
FROUDE = (0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0)  # the paper's grid
SLOPES = (0.0, 0.4, 0.8, 1.2)
BETAS = (0.0, 0.15, 0.3, 0.45)
ALL_DRAWS = os.environ.get("MPM_LONG_TESTS") == "1"  # of each bootstrap, which takes most of the time of a study


def few_draws():
    """Less draws of each bootstrap than the kept tables have, if MPM_LONG_TESTS is not 1."""
    return unittest.mock.patch.object(uncertainty, "RESAMPLES", uncertainty.RESAMPLES if ALL_DRAWS else 10)


def paper_grid(froude=FROUDE):
    rows = [(f, m, b) for f in froude for m in SLOPES for b in BETAS]
    grid = pd.DataFrame(rows, columns=["froude_number", "critical_state_slope", "cohesion_beta"])
    return grid.assign(effective_friction=equations.effective_friction(grid.critical_state_slope, grid.cohesion_beta))


def exact_samples(coefficients):
    """Heights by Eqs. 7 to 10 on the paper's grid."""
    grid = paper_grid()
    return grid.assign(relative_height=relative_height(grid.effective_friction, grid.froude_number, coefficients))


def scattered_samples(coefficients):
    """The same with a reproducible scatter of 10 % that a few lines of any language repeat."""
    samples = exact_samples(coefficients)
    return samples.assign(relative_height=samples.relative_height * np.exp(0.1 * np.sin(7.0 * (np.arange(len(samples)) + 1.0))))


def study_run(froude, slope, beta, xi, **changes):
    """A run of the paper's set-up whose heights obey the published equations."""
    friction = float(equations.effective_friction(slope, beta))
    run = {"folder": "", "froude_number": froude, "critical_state_slope": slope, "cohesion_beta": beta, "effective_friction": friction,
           "hardening_xi": xi, "flow_height_m": 1.75, "obstacle_width_m": 1.75, "gravity_m_s2": equations.STANDARD_GRAVITY,
           "velocity_m_s": equations.flow_velocity(froude, 1.75), "runup": relative_height(friction, froude, equations.PUBLISHED_RUNUP),
           "pressure_height": relative_height(friction, froude, equations.PUBLISHED_PRESSURE_HEIGHT), "runup_standard_error": 0.02,
           "pressure_height_standard_error": 0.02, "runup_numerical_uncertainty": np.nan, "pressure_height_numerical_uncertainty": np.nan,
           "runup_peak": np.nan, "pressure_height_peak": np.nan, "compaction": np.nan, "planned_duration_s": np.nan, **changes}
    run["relative_width"] = run["obstacle_width_m"] / run["flow_height_m"]
    run["at_reference_width"] = abs(run["relative_width"] - 1.0) < 1e-6
    return run


def study_runs(*runs):
    return pd.DataFrame(list(runs))


def grid_of_runs(xis=(0.5, 5.0)):
    return study_runs(*(study_run(f, m, b, xi) for xi in xis for f in FROUDE for m in SLOPES for b in BETAS))


TRUTH = {"runup": equations.HeightCoefficients(0.8, 1.4), "pressure_height": equations.HeightCoefficients(0.6, 1.1, 1.7)}
HEAD = ("name,run,status,froude_number,critical_state_slope,cohesion_beta,hardening_xi,flow_height_m,obstacle_width_m,cell_size_m,steady,"
        "runup_mean_m,runup_standard_error_m,runup_peak_m,pressure_height_mean_m\n")


def synthetic_table(scatter, cell_size=0.25):
    """A campaign's table on the paper's grid: heights by Eqs. 7 to 10 with known coefficients and a reproducible scatter."""
    lines, i = ["# plan: synthetic\n", HEAD], 0
    for xi in (0.05, 0.5, 5.0):
        for froude in FROUDE:
            for slope in SLOPES:
                for beta in BETAS:
                    i += 1
                    friction, noise = equations.effective_friction(slope, beta), np.exp(scatter * np.sin(7.0 * i))
                    inputs = f"r{i},runs/r{i},done,{froude},{slope},{beta},{xi},1.75,1.75,{cell_size}"
                    heights = [1.75 * relative_height(friction, froude, TRUTH[name]) * noise for name in ("runup", "pressure_height")]
                    if i % 50 == 0:  # one in fifty has no steady interval
                        lines.append(f"{inputs},0,nan,nan,9,nan\n")
                    else:
                        lines.append(f"{inputs},1,{heights[0]!r},0.02,9,{heights[1]!r}\n")
    return "".join(lines)


class InFolder(in_folder.InFolder):
    """A test with a temporary folder, and the command of the package."""

    def command(self, *arguments):
        """(exit code, stdout, stderr) of `python3 -m mpmtools`."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), few_draws():
            try:
                code = main([str(argument) for argument in arguments])
            except SystemExit as stop:  # argparse
                code = stop.code
        return code, out.getvalue(), err.getvalue()
