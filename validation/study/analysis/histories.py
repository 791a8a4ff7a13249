"""What needs the folders of the runs: time histories (Fig. 3), other choices of a run's height, longitudinal sections (Fig. 5)."""

import os

import numpy as np
import pandas as pd

from analysis.fits import inputs_text
from analysis.statistics import estimate_mean
from mpmtools.checksums import read_table_of
from mpmtools.frame import open_hdf5
from mpmtools.scores import same_input
from mpmtools.fit.fits import NARROW, fit_set
from mpmtools.fit.regression import PRESSURE_HEIGHT, RUNUP
from mpmtools.tables import numbers, read_series

ENVELOPE_FROUDE = (0.1, 1.0, 5.0)
ENVELOPE_COLUMNS = ["froude_number", "time_s", "runs", "all_runs", "runup_low", "runup_high", "pressure_height_low", "pressure_height_high"]


def series_of(run):
    """Heights over H in time: columns runup and pressure_height, index time_s. None where the folder of the run holds none."""
    if not run.folder or not os.path.exists(os.path.join(run.folder, "series.csv")):
        return None
    series = read_table_of(os.path.join(run.folder, "series.csv")).set_index("time_s")[["runup_m", "pressure_height_m"]] / run.flow_height_m
    return series.set_axis(["runup", "pressure_height"], axis=1) if len(series) else None


def envelopes(runs):
    """Lowest and highest height of all runs of a Froude number with w = H, on the times of the longest series, linear between samples.
    runs: those whose series reaches so far; all_runs: those with a series."""
    tables = [_envelope(runs[runs.at_reference_width & same_input(runs.froude_number, froude)]).assign(froude_number=froude)
              for froude in ENVELOPE_FROUDE]
    return pd.concat(tables, ignore_index=True)[ENVELOPE_COLUMNS]


def _envelope(runs):
    histories = [series for run in runs.itertuples() if (series := series_of(run)) is not None]
    if not histories:
        return pd.DataFrame(columns=ENVELOPE_COLUMNS, dtype=float)
    times = max(histories, key=lambda series: series.index[-1]).index
    table = pd.DataFrame({"time_s": times, "all_runs": len(histories)})
    for name in ("runup", "pressure_height"):
        all_runs = pd.DataFrame([np.interp(times, s.index, s[name], left=np.nan, right=np.nan) for s in histories])
        table[f"{name}_low"], table[f"{name}_high"] = all_runs.min(), all_runs.max()  # without NaN
        if name == "runup":
            table["runs"] = all_runs.count()
    return table


def height_choices(runs):
    """{choice: the runs with a series, with other heights}. The paper averages over "a time span several seconds long" that it does not
    print: `steady span`, as the table has it; `last third` of the run's series; `peak`, the run's highest, splash and all."""
    found = {index: series for index, run in zip(runs.index, runs.itertuples()) if (series := series_of(run)) is not None}
    if not found:
        return {}
    steady = runs.loc[list(found)]
    late, peak = steady.copy(), steady.copy()
    for name in ("runup", "pressure_height"):
        late[[name, f"{name}_standard_error"]] = [estimate_mean(last_third(series)[name]) for series in found.values()]
        peak[[name, f"{name}_standard_error"]] = steady[[f"{name}_peak"]].assign(error=np.nan).to_numpy()
    return {"steady span": steady, "last third": late, "peak": peak}


def last_third(series):
    first, last = series.index[0], series.index[-1]
    return series[series.index >= last - (last - first) / 3.0]


def run_folder(table, name):
    """That of a run of a campaign. @param table  its results.csv, from read_table()"""
    return os.path.join(os.path.dirname(table.attrs["path"]), "runs", name)


def run_means(table, part):
    """A row for each run of a campaign that is done and whose folder is there: from_s, to_s, and the mean and standard error over a part of its
    series of both heights (over H) and of the force along the flow (N). The index is that of the table.

    @param table  results.csv of a campaign, from read_table(), beside its folders runs/NAME
    @param part  the part, a function of the series (index time_s) and the run's row of the table, all text; an empty part leaves the run out"""
    heights = numbers(table, "flow_height_m")
    rows = {}
    for index, run in table[table.status == "done"].iterrows():
        folder = run_folder(table, run["name"])
        if not os.path.exists(os.path.join(folder, "series.csv")):
            continue
        chosen = part(read_table_of(os.path.join(folder, "series.csv")).set_index("time_s"), run)
        if chosen.empty:
            continue
        row = {"from_s": chosen.index[0], "to_s": chosen.index[-1]}
        for column, scale, name in (("runup_m", heights[index], "runup"), ("pressure_height_m", heights[index], "pressure_height"),
                                    ("force_x_n", 1.0, "force_n")):
            mean = estimate_mean(chosen[column] / scale)
            row.update({name: mean[0], f"{name}_standard_error": mean[1]})
        rows[index] = row
    return pd.DataFrame.from_dict(rows, orient="index")


def height_choice_table(runs):
    """Coefficients of the narrow set, and scores against the published equations, for each choice."""
    rows = []
    for name, chosen in height_choices(runs).items():
        row = {"height": name}
        for equation in (RUNUP, PRESSURE_HEIGHT):
            s = fit_set(equation, NARROW, chosen)
            row.setdefault("runs", s.runs)
            row.update({parameter: s.fit.estimates[parameter].value if s.fit else np.nan for parameter in equation.parameters})
            whole = s.whole("published")
            for score in (equation.score, "fraction_25"):
                row[f"{equation.name}_{score}_published"] = np.nan if whole is None else whole[score]
        rows.append(row)
    return pd.DataFrame(rows, columns=["height", "runs", "k_r", "kappa_r", "runup_rmsle_published", "runup_fraction_25_published", "k_p",
                                       "Fr_sat", "kappa_p", "pressure_height_nrmse_published", "pressure_height_fraction_25_published"])


def sections(runs, rheology):
    """Fig. 5, the end of the decomposition's chain in a slow and in a fast flow: ({table name: table}, what is missing).

    `sections` has a row a run; `section_NAME` the particles near the axis in the last state, `section_profile_NAME` the mean profile.
    """
    tables, rows, missing = {}, [], []
    for name, froude in (("slow", 0.1), ("fast", 5.0)):
        inputs = dict(zip(("froude_number", "critical_state_slope", "cohesion_beta", "hardening_xi"), (froude, *rheology)))
        found = runs[runs.at_reference_width & np.logical_and.reduce([same_input(runs[key], value) for key, value in inputs.items()])]
        if found.empty:
            missing.append(f"no run with {inputs_text(*inputs.values())}")
            continue
        run = found.iloc[0]
        last, profile = (os.path.join(run.folder, file) for file in ("final.h5", "profile.csv"))
        if not run.folder or not os.path.exists(last) or not os.path.exists(profile):
            missing.append(f"the run with {inputs_text(*inputs.values())} did not keep its last state (final.h5) and profile")
            continue
        tables[f"section_{name}"], spacing = _section(last, run)
        tables[f"section_profile_{name}"] = read_series(profile)[["z_m", "pressure_pa", "smoothed_pressure_pa"]]
        rows.append((froude, run.flow_height_m, run.runup, run.pressure_height, spacing))
    tables["sections"] = pd.DataFrame(rows, columns=["froude_number", "flow_height_m", "runup", "pressure_height", "particle_spacing_m"])
    return tables, missing


def _section(path, run):
    """Particles in the strip of the paper's measurements (Appendix A2), and their mean spacing, m."""
    with open_hdf5(path) as file:
        position, ratio = file["position_m"][:], file["volume_ratio"][:]
        kirchhoff_xx, volume = file["kirchhoff_stress_pa"][:, 0], file["reference_volume_m3"][:]
    x, y, z = position.T
    near = (np.abs(y) <= 3.0 / 7.0 * run.obstacle_width_m) & (x >= -6.0 * run.flow_height_m) & (x <= 3.0 * run.flow_height_m)
    particles = pd.DataFrame({"x_m": x, "z_m": z, "stress_xx_pa": kirchhoff_xx / ratio})[near].reset_index(drop=True)
    return particles, float(np.mean(np.cbrt(volume * ratio)[near]))
