"""design.json and the tables beside the page."""

import math
import os

import pandas as pd

from mpmtools import __version__
from mpmtools.design import comparison, figures
from mpmtools.design.cautions import advice_rows
from mpmtools.design.headlines import is_run_up_determined, pressure_heights
from mpmtools.design.results import quantities_of
from mpmtools.design.what_decides import scenario_rows, sensitivity_rows
from mpmtools.files import plain, write_text


OVER_TIME = {"time_s": "time", "force_x_n": "force", "force_x_smooth_n": "smooth_force", "overturning_moment_n_m": "moment",
             "overturning_moment_smooth_n_m": "smooth_moment", "runup_p99_m": "runup", "runup_m": "highest", "pressure_height_m": "pressure_height"}  # of Loads


def _of_entry(e):
    return {"value": e.value, "by_grid": e.by_grid, "grid_uncertainty": e.grid, "gci": e.gci, "order": e.order, "known_uncertainty": e.known,
            "standard_error": e.standard_error, "statistical_uncertainty": e.statistical, "uncertainty": e.total, "note": e.note}


def design_json(ensemble, results):
    """What design.json holds, as a dict; None: not known."""
    plan = ensemble.plan
    (chosen, force), (of_moment, moment) = results.headline("force"), results.headline("moment")
    arm = {f"design_{load}_n": results.headline(load)[1] for load in ("arm_force", "arm_lift")} if "arm" in plan else {}
    quantities = {q.key: {"label": q.label, "range": results.ranges[q.key]._asdict(),
                          "snows": {snow["name"]: _of_entry(row[q.key]) for snow, row in zip(plan["snows"], results.table)}} for q in quantities_of(plan)}
    return plain({
        "format_version": 1, "mpmtools": __version__, "plan": plan,
        "design_force_n": force, "design_force_is": chosen, "design_moment_n_m": moment, "design_moment_is": of_moment,
        **arm, "pressure_heights": [{"value_m": h, "source": source} for h, source in pressure_heights(ensemble, results)],
        "quantities": quantities, "guideline_loads": [row._asdict() for row in comparison.guideline_loads(plan)],
        "scenarios": [{"name": name, **other._asdict(), "force_n": force, "moment_n_m": moment, "scaling_error": error,
                       "pressure_height_m": heights[0], "runup_m": heights[1], "runup_is_determined": is_run_up_determined(ensemble, results)}
                      for name, other, force, moment, error, heights in scenario_rows(ensemble, results)],
        "sensitivity": [{"what": what, "force": force_change, "moment": moment_change}
                        for what, force_change, moment_change in sensitivity_rows(ensemble, results)],
        "guideline": [{"what": what, "value_m": value, "source": source} for what, value, source in comparison.guideline_rows(plan)],
        "equations": comparison.equation_rows(plan), "equation_remarks": comparison.equation_remarks(plan),
        "advice": [{"text": text, "snows": snows} for text, snows in advice_rows(ensemble, results)],
        "known_uncertainty_is_of": comparison.known_uncertainty_remark(plan) or None,
    })


def write_tables(ensemble, results, spectrum):
    """design.csv, line_load.csv, arm_load.csv of a mast with an arm, pressure_over_height.csv, loads_over_time.csv, shock_spectrum.csv.
    @return their names"""
    folder, plan = ensemble.folder, ensemble.plan
    rows = [{"quantity": q.key, "snow": snow["name"], **_of_entry(row[q.key])} for q in quantities_of(plan) for snow, row in zip(plan["snows"], results.table)]
    tables = {"design.csv": pd.DataFrame(rows).drop(columns=["by_grid", "order", "note"]),
              "pressure_over_height.csv": pd.DataFrame(results.profile_table(ensemble))}
    low, high, lines, arm = results.line_loads(plan)
    tables["line_load.csv"] = pd.DataFrame({"z_from_m": low, "z_to_m": high, **{f"{name}_kn_m": 1e-3 * q for name, q in lines.items()}})
    if arm:
        upper = {f"upper_{axis}_kn": [1e-3 * results.ranges[f"{of}_{name}_n"].high if f"{of}_{name}_n" in results.ranges else math.nan for name in arm]
                 for axis, of in (("downstream", "arm_force"), ("upwards", "arm_lift"))}
        tables["arm_load.csv"] = pd.DataFrame({"with_line_load": list(arm), "downstream_kn": [1e-3 * force for force, _ in arm.values()],
                                               "height_m": [at for _, at in arm.values()], **upper})
    times = []
    for snow, loads in zip(plan["snows"], results.finest):
        of_arm = {"arm_force_x_n": loads.arm.force, "arm_force_z_n": loads.arm.vertical} if loads.has_arm else {}
        times.append(pd.DataFrame({"snow": snow["name"], **{column: getattr(loads, name) for column, name in OVER_TIME.items()}, **of_arm}))
    tables["loads_over_time.csv"] = pd.concat(times)
    of_snows = {f"{snow['name']}_n": row for snow, row in zip(plan["snows"], spectrum)}
    tables["shock_spectrum.csv"] = pd.DataFrame({"frequency_hz": figures.FREQUENCIES, **of_snows})
    for name, table in tables.items():
        write_text(os.path.join(folder, name), table.to_csv(index=False, float_format="%.6g"))
    return list(tables)
