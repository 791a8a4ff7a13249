"""The numbers behind every figure of the study, as one folder of tables."""

import os

import numpy as np
import pandas as pd

from analysis.fits import own_coefficients
from mpmtools import equations
from mpmtools.errors import ConfigError
from mpmtools.files import read_toml, write_text
from mpmtools.scores import levels
from analysis import campaigns, grids, guideline, histories, jams, published, refinement, rheology, sensitivity, uncertainty, width, yardstick
from mpmtools.fit.fits import coefficients_csv, evaluated_by, fit_paper_sets, fits_json, scores_csv
from mpmtools.fit.regression import EQUATIONS
from mpmtools.fit.runs import read_runs_or_refuse, read_study_table
from mpmtools.fit.text import table_lines
from mpmtools.tables import csv_text

POINT_COLUMNS = ["froude_number", "critical_state_slope", "cohesion_beta", "hardening_xi", "effective_friction", "relative_width", "runup",
                 "runup_standard_error", "runup_peak", "pressure_height", "pressure_height_standard_error", "pressure_height_peak"]
NUMERICAL_COLUMNS = ["runup_numerical_uncertainty", "pressure_height_numerical_uncertainty"]  # where the runs carry them
NO_COEFFICIENTS = equations.HeightCoefficients(np.nan, np.nan, np.nan)


def points(runs, fitted):
    """A row a run: inputs, heights over H, and both equations (Figs. 6, 7, A2, A4)."""
    numerical = [name for name in NUMERICAL_COLUMNS if name in runs and runs[name].notna().any()]
    return pd.concat([runs[[*POINT_COLUMNS, *numerical]], _both_equations(runs, fitted)], axis=1)


def _both_equations(inputs, fitted):
    columns = {}
    for equation in EQUATIONS:
        for source, coefficients in (("fitted", fitted[equation.name] or NO_COEFFICIENTS), ("published", equation.published)):
            columns[f"{equation.name}_{source}"] = equations.relative_height(inputs.effective_friction, inputs.froude_number, coefficients)
    return pd.DataFrame(columns)


def curves(runs, fitted, steps=120, greatest=2.4):
    """(heights over M' at each Froude number (Figs. A2, A4), factors zeta and lambda over M' (Fig. 8)); M' of the paper goes to 2.30."""
    friction = greatest * np.arange(steps + 1) / steps
    froude = np.sort(levels(runs.froude_number).unique())
    inputs = pd.DataFrame({"froude_number": np.tile(froude, steps + 1), "effective_friction": np.repeat(friction, len(froude))})
    factors = {"effective_friction": friction}
    for symbol, factor in (("zeta", equations.magnification_factor), ("lambda", equations.dissipation_factor)):
        for letter, equation in zip("rp", EQUATIONS):
            factors[f"{symbol}_{letter}_fitted"] = factor(friction, fitted[equation.name] or NO_COEFFICIENTS)
            factors[f"{symbol}_{letter}_published"] = factor(friction, equation.published)
    return inputs.join(_both_equations(inputs, fitted)), pd.DataFrame(factors)


def friction_curves(steps=90):
    """M' and phi' over beta for the paper's M (Fig. 1)."""
    slope, beta = np.repeat([0.0, 0.4, 0.8, 1.2], steps + 1), np.tile(0.45 * np.arange(steps + 1) / steps, 4)
    friction = equations.effective_friction(slope, beta)
    return pd.DataFrame({"critical_state_slope": slope, "cohesion_beta": beta, "effective_friction": friction,
                         "friction_angle_deg": np.degrees(equations.friction_angle(friction))})


def plan_title(table_path):
    """The title of the plan that lies beside a campaign's table; empty without one."""
    plan = os.path.join(os.path.dirname(table_path), "plan.toml")
    if not os.path.exists(plan):
        return ""
    return read_toml(plan).get("title", "")


def evidence_tables(runs, prediction_files=(), grids_files=(), friction_files=()):
    """How far the coefficients can be trusted: intervals, influence, jams, the friction of the mast, and the grid."""
    tables = {"coefficient_intervals": uncertainty.coefficient_intervals(runs), "leave_one_out": uncertainty.leave_one_out(runs),
              "influence": uncertainty.influence(runs), "runup_parts": uncertainty.runup_parts(runs),
              "published_errors": published.published_errors(), "published_variances": published.published_variances(),
              "coefficients_without_jams": jams.jam_coefficients(runs),
              "coefficients_without_unconverged": grids.coefficients_without_unconverged(runs)}
    indices = jams.jam_indices(runs)
    if len(indices):
        tables["jams"] = indices.sort_values("jam_index", ascending=False)
    if friction_files:
        tables.update(yardstick.friction_tables(read_runs_or_refuse(friction_files).runs))
    if prediction_files:
        prediction = read_runs_or_refuse(prediction_files).runs
        tables.update(campaigns.campaign_tables(runs, prediction, tables["coefficient_intervals"]))
    if grids_files:
        tables.update(grids.grid_tables(grids_files))
    return tables


def write_evidence(tables, files, out):
    """Each table with its provenance in comment lines: program, tables of runs, and the seed of what was drawn."""
    sources = ", ".join("/".join(os.path.abspath(path).split(os.sep)[-2:]) for path in files)
    for name, content in tables.items():
        head = [f"computed by {evaluated_by()} from {sources}"]
        if name == "coefficient_intervals":
            head.append(f"intervals of 90 %; bootstrap: {uncertainty.RESAMPLES} resamples of whole groups, seed {uncertainty.SEED}")
        write_text(os.path.join(out, f"{name}.csv"), "".join(f"# {line}\n" for line in head) + csv_text(content))


def _refinement(runs, left_out_as_coarser, coarser_files):
    """Tables that compare the set-ups that are there on two grids."""
    coarse = [left_out_as_coarser]
    if coarser_files:
        given = read_runs_or_refuse(coarser_files).runs
        for which, of in (("given with it", given), ("of the study", runs)):
            if not np.isfinite(of.cell_size_m).all():
                raise ConfigError(f"coarser rows: in the table {which} not every run has its cell size (column cell_size_m)")
        coarse.append(given[levels(given.cell_size_m) > runs.cell_size_m.min() * (1.0 + 1e-9)])
    tables = refinement.refinement_tables(pd.concat([runs, *coarse], ignore_index=True))
    if len(left_out_as_coarser):
        tables["coefficients_with_coarser"] = refinement.coefficients_with_coarser(runs, left_out_as_coarser)
    if coarser_files and tables["refined_rows"].empty:
        raise ConfigError(f"{', '.join(coarser_files)}: no set-up of the study is there on a coarser grid with the same friction of "
                          "the mast and the same duration")
    return tables


def write_study(files, out, width_files=(), section_files=(), sensitivity_files=(), friction_files=(), prediction_files=(), grids_files=(),
                coarser_files=(), finest=False):
    """Evaluates tables of runs and writes the tables of the study into the folder `out`; returns (cautions, lines for the terminal).

    The widths and the two runs of Fig. 5 are taken from the same tables unless others are named. `friction_files` hold runs with several
    frictions of the mast; `prediction_files` the same sets with the accurate solver, to be compared with this campaign; `grids_files` runs of
    that solver on three grids, `coarser_files` the same sets on a coarser grid. `finest`: of the runs of one set-up only that on the finest grid.
    """
    table = read_runs_or_refuse(files, finest=finest)
    plans = [f"plan: {title}" for path in files if (title := plan_title(path))]
    table.provenance = [*plans, *table.provenance]
    runs = table.runs
    fits = fit_paper_sets(runs)
    fitted = own_coefficients(fits)
    correspondence = guideline.guideline_correspondence(runs)
    losses = rheology.compaction_losses(runs)
    summary = rheology.compaction_summary(losses)
    heights, factors = curves(runs, fitted)
    section_tables, missing = histories.sections(read_study_table(section_files).runs if section_files else runs, rheology.LAST_LINK)
    tables = {
        "points": points(runs, fitted), "height_curves": heights, "factor_curves": factors, "effective_friction": friction_curves(),
        "envelopes": histories.envelopes(runs), "spreads": rheology.spreads(runs),
        "guideline": correspondence.curves, "guideline_minima": correspondence.minima,
        "decomposition": rheology.decomposition(runs),
        "width_factors": width.width_factors(read_study_table(width_files).runs if width_files else runs),
        "height_choices": histories.height_choice_table(runs),
        "compaction": losses, "compaction_curve": rheology.compaction_curve(losses), "compaction_summary": summary, **section_tables,
    }
    evidence, not_compared = _refinement(runs, table.coarser, coarser_files) if finest or coarser_files else {}, []
    evidence.update(evidence_tables(runs, prediction_files, grids_files, friction_files))
    if sensitivity_files:
        compared = sensitivity.sensitivities(*sensitivity_files)
        evidence.update(sensitivity=compared.runs, sensitivity_summary=compared.summaries)
        not_compared = compared.notes
    write_evidence(evidence, [*files, *friction_files, *sensitivity_files, *prediction_files, *grids_files, *coarser_files], out)
    for name, content in tables.items():
        write_text(os.path.join(out, f"{name}.csv"), csv_text(content))
    write_text(os.path.join(out, "coefficients.csv"), coefficients_csv(fits))
    write_text(os.path.join(out, "scores.csv"), scores_csv(fits))
    write_text(os.path.join(out, "fit.json"), fits_json(fits, table))  # last: a folder with fit.json is whole
    return table.cautions, [
        *table_lines(table),
        *(f"{s.equation.name} not fitted to set '{s.fitting_set.name}': {s.why_not}" for s in fits if not s.fit),
        *guideline.guideline_lines(correspondence), *rheology.compaction_lines(summary),
        *(f"sensitivities, left out: {note}" for note in not_compared), *(f"longitudinal sections: {what}" for what in missing),
    ]
