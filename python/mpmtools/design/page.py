"""design.html, design.json and the tables beside them."""

import json
import math
import os

import jinja2
import markupsafe
import numpy as np
import pandas as pd

from mpmtools import __version__
from mpmtools.design import comparison, figures
from mpmtools.design.ensemble import Ensemble
from mpmtools.design.results import Results, mode_keys, quantities_of
from mpmtools.errors import InputError
from mpmtools.figures.style import STYLE, inline, use_style, write_page
from mpmtools.tables import write_text

LEVELS = {
    "quick": "quick: coarse grids, at most ten minutes on two cores. For orders of magnitude and for comparing variants.",
    "standard": "standard: at most an hour on two cores.",
}


def short(value, scale=1.0):
    """Three significant digits; a dash for what is not known."""
    if value is None or not math.isfinite(value):
        return "–"
    value *= scale
    digits = max(0, 2 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{min(digits, 4)}f}" if digits else f"{round(value, 2 - math.floor(math.log10(abs(value))) if value else 0):.0f}"


def upward(value, scale=1.0):
    """Three significant digits, rounded up: a value to design with."""
    if not math.isfinite(value):
        return "–"
    value *= scale
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 2) if value else 1.0
    return short(math.ceil(value / step - 1e-9) * step)


def error(value, scale=1.0):
    """Two significant digits."""
    if value is None or not math.isfinite(value):
        return "?"
    value *= scale
    digits = max(0, 1 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{min(digits, 5)}f}"


def with_unit(text, unit):
    return f"{text} {unit}" if unit and text != "–" else text


def design_rows(ensemble, results):
    """The box at the top: what to design with. [(what, value, why)]"""
    plan = ensemble.plan
    by_key = {q.key: q for q in quantities_of(plan)}

    def value(key, number):
        return with_unit(upward(number, by_key[key].scale), by_key[key].unit)

    ranges = results.ranges
    chosen, force = results.design_force(plan)
    steady, steady_force = results.design_force(plan, steady_only=True)
    transient = ["force_first_impact_n"] + [mode_keys(mode)[0] for mode in plan["modes"]]
    first = ""
    if chosen in transient and steady is not None and steady_force < force:
        first = ("It contains the first impact of a vertical front, the most severe there can be; a real front is inclined and loose at its top. "
                 f"While the flow is steady: {value(steady, steady_force)} ({by_key[steady].label}).")
    moment_key = max(("moment_steady_peak_n_m", "moment_first_impact_n_m"), key=lambda k: np.nan_to_num(ranges[k].high, nan=-1.0))
    moment, why_moment = ranges[moment_key].high, f"upper value of: {by_key[moment_key].label}"
    if chosen not in (None, "force_steady_peak_n", "force_first_impact_n"):
        quasi_static = max(np.nan_to_num(ranges[k].high, nan=0.0) for k in ("force_steady_peak_n", "force_first_impact_n"))
        moment *= force / quasi_static
        why_moment += f", times {force / quasi_static:.2f}, the force above over that without vibration"
    runup = ranges["runup_p99_mean_m"].high
    bounded = runup == ensemble.bound
    why_runup = "Bernoulli's bound H + v²/2g, which is below value plus uncertainty" if bounded else "upper value of the steady mean"
    return [
        ("force downstream, static load", with_unit(upward(force, 1e-3), "kN"),
         f"upper value of: {by_key[chosen].label}. {first}".strip() if chosen else "no run gives one"),
        ("overturning moment at the base", with_unit(upward(moment, 1e-3), "kN m"), why_moment),
        ("height of the pressure (distribute the force below it, as in the profile)",
         value("pressure_height_mean_m", ranges["pressure_height_mean_m"].high), "upper value of the steady mean"),
        ("run-up (keep parts that must not be struck above it)", value("runup_p99_mean_m", runup),
         f"{why_runup} of the height below which 99 % of the snow before the mast stays; its highest particle is at "
         f"{value('runup_mean_m', ranges['runup_mean_m'].highest)} in the mean, and in the first splash at "
         f"{value('runup_peak_m', ranges['runup_peak_m'].highest)}"),
    ]


def advice_rows(ensemble, results):
    """What to know before the values are used: the advice of the program about the runs, and what the runs show. [(text, snows)]"""
    plan = ensemble.plan
    rows = [(advice["text"], "" if len(advice["snows"]) == len(plan["snows"]) else ", ".join(advice["snows"]).replace("_", " "))
            for advice in plan.get("advice", [])]  # an older program wrote none
    top = plan["mast"]["height_m"]
    if top:
        for key, what in (("runup_p99_mean_m", "the steady mean of the run-up"), ("runup_mean_m", "the steady mean of the highest particle"),
                          ("runup_peak_m", "the highest particle of the first splash")):
            over = [i for i, row in enumerate(results.table) if math.isfinite(row[key].value) and row[key].value >= top]
            if over:
                highest = max(results.table[i][key].value for i in over)
                rows.append((f"The mast is overtopped: {what} reaches {short(highest)} m, and the mast is {top} m high; heights are those of a mast "
                             "that ends there; leave out mast.height_m for the run-up on a taller one",
                             "" if len(over) == len(plan["snows"]) else ", ".join(ensemble.label(i) for i in over)))
    return rows


def load_table(ensemble, results):
    plan = ensemble.plan
    head = ["quantity"] + [ensemble.label(i) for i in range(len(plan["snows"]))] + ["range with uncertainty"]
    rows = []
    for q in quantities_of(plan):
        cells = [q.label + (f" ({q.unit})" if q.unit else "")]
        for row in results.table:
            e = row[q.key]
            if not math.isfinite(e.value):
                cells.append("–")
                continue
            parts = f" ± {error(e.grid, q.scale)} grid" if math.isfinite(e.grid) else ", grid unknown"
            if math.isfinite(e.standard_error):
                parts += f" ± {error(2.0 * e.standard_error, q.scale)} stat."
            cells.append(short(e.value, q.scale) + parts)
        r = results.ranges[q.key]
        cells.append(f"{short(r.low, q.scale)} to {short(r.high, q.scale)}" if math.isfinite(r.high) else "–")
        rows.append(cells)
    return {"head": head, "rows": rows}


def grid_table(ensemble, results):
    plan = ensemble.plan
    head = ["quantity and snow"] + [f"{g['cells']} cells, {g['cell_size_m']:.3g} m" for g in plan["grids"]] + ["GCI", "known", "taken", "how"]
    rows = []
    for q in quantities_of(plan):
        for snow, row in enumerate(results.table):
            e = row[q.key]
            if not math.isfinite(e.value) or e.value == 0.0:
                continue
            percent = [f"{100.0 * part / abs(e.value):.0f} %" if math.isfinite(part) else "–" for part in (e.gci, e.known, e.grid)]
            name = f"{q.label}, {ensemble.label(snow)}" + (f" ({q.unit})" if q.unit else "")
            rows.append([name, *(short(v, q.scale) for v in e.by_grid), *percent, e.method])
    return {"head": head, "rows": rows}


def snow_table(plan):
    head = ["snow", "M", "β", "ξ", "M'", "source"]
    keys = ("critical_state_slope", "cohesion_beta", "hardening_xi", "effective_friction")
    return {"head": head, "rows": [[s["name"].replace("_", " "), *(f"{s[key]:.3g}" for key in keys), s["source"] or "given in the site file"]
                                   for s in plan["snows"]]}


def comparison_table(ensemble, results):
    """Simulated heights beside the paper's equations, for each snow."""
    rows = []
    for snow, equation in enumerate(comparison.equation_rows(ensemble.plan)):
        entries = results.table[snow]
        rows.append([ensemble.label(snow), short(entries["runup_mean_m"].value), short(equation["runup_m"]),
                     short(entries["pressure_height_mean_m"].value), short(equation["pressure_height_m"])])
    by = "by Eqs. 7 to 10, extrapolated" if comparison.equation_remarks(ensemble.plan) else "by Eqs. 7 to 10"
    return {"head": ["snow", "highest particle (m), computed", by, "pressure height (m), computed", by], "rows": rows}


def accuracy(results):
    """Grid uncertainty of the three main quantities, the largest of the snows, in words."""
    parts = []
    for key, label in (("force_mean_n", "mean force"), ("runup_p99_mean_m", "run-up"), ("pressure_height_mean_m", "pressure height")):
        shares = [row[key].grid / abs(row[key].value) for row in results.table if math.isfinite(row[key].value) and math.isfinite(row[key].grid)]
        parts.append(f"{label} {100.0 * max(shares):.0f} %" if shares else f"{label} not known")
    return ", ".join(parts)


def design_json(ensemble, results):
    plan = ensemble.plan

    def plain(value):
        return value if value is not None and math.isfinite(value) else None

    chosen, force = results.design_force(plan)
    quantities = {}
    for q in quantities_of(plan):
        r = results.ranges[q.key]
        quantities[q.key] = {
            "label": q.label,
            "range": {name: plain(getattr(r, name)) for name in r._fields},
            "snows": {plan["snows"][i]["name"]: {
                "value": plain(e.value), "by_grid": [plain(v) for v in e.by_grid], "grid_uncertainty": plain(e.grid), "gci": plain(e.gci),
                "known_uncertainty": plain(e.known), "standard_error": plain(e.standard_error), "uncertainty": plain(e.total), "note": e.note}
                      for i, e in enumerate(row[q.key] for row in results.table)}}
    return {"format_version": 1, "mpmtools": __version__, "plan": plan,
            "design_force_n": plain(force), "design_force_is": chosen, "quantities": quantities,
            "guideline": [{"what": what, "value_m": value, "source": source} for what, value, source in comparison.guideline_rows(plan)],
            "equations": comparison.equation_rows(plan), "equation_remarks": comparison.equation_remarks(plan),
            "advice": [{"text": text, "snows": snows} for text, snows in advice_rows(ensemble, results)],
            "known_uncertainty_is_of": comparison.known_uncertainty_remark(plan) or None}


def write_tables(ensemble, results, spectrum):
    """design.csv, pressure_over_height.csv, loads_over_time.csv, shock_spectrum.csv. @return their names"""
    folder, plan = ensemble.folder, ensemble.plan
    rows = [{"quantity": q.key, "snow": plan["snows"][i]["name"], "value": e.value, "grid_uncertainty": e.grid, "gci": e.gci,
             "known_uncertainty": e.known, "standard_error": e.standard_error, "uncertainty": e.total}
            for q in quantities_of(plan) for i, e in enumerate(row[q.key] for row in results.table)]
    tables = {"design.csv": pd.DataFrame(rows), "pressure_over_height.csv": pd.DataFrame(results.profile_table(ensemble))}
    times = []
    for snow, loads in enumerate(results.finest):
        times.append(pd.DataFrame({"snow": plan["snows"][snow]["name"], "time_s": loads.time, "force_x_n": loads.force,
                                   "force_x_smooth_n": loads.smooth_force, "overturning_moment_n_m": loads.moment,
                                   "overturning_moment_smooth_n_m": loads.smooth_moment, "runup_p99_m": loads.runup, "runup_m": loads.highest,
                                   "pressure_height_m": loads.pressure_height}))
    tables["loads_over_time.csv"] = pd.concat(times)
    spectra = {"frequency_hz": figures.FREQUENCIES}
    spectra.update({f"{snow['name']}_n": row for snow, row in zip(plan["snows"], spectrum)})
    tables["shock_spectrum.csv"] = pd.DataFrame(spectra)
    for name, table in tables.items():
        write_text(os.path.join(folder, name), table.to_csv(index=False, float_format="%.6g"))
    return list(tables)


def make_page(folder):
    """Writes everything into the folder. @return (path of the page, [line for the user])"""
    use_style()
    ensemble = Ensemble(folder)
    plan, results = ensemble.plan, Results(ensemble)
    middle = results.finest[ensemble.middle]
    spectrum = figures.spectra(ensemble, results.finest)
    design, advice, uncertain = design_rows(ensemble, results), advice_rows(ensemble, results), accuracy(results)
    pictures = [figures.side_view(ensemble, middle), figures.view_3d(ensemble, middle), figures.pressure_over_height(ensemble, results.finest),
                figures.over_time(ensemble, results.finest, "force"), figures.over_time(ensemble, results.finest, "moment"),
                figures.shock_spectrum(ensemble, results.finest, spectrum), figures.runup_over_time(ensemble, results.finest),
                figures.grid_convergence(ensemble, results.table)]
    try:
        files = write_tables(ensemble, results, spectrum)
        write_text(os.path.join(folder, "design.json"), json.dumps(design_json(ensemble, results), indent=2))
        environment = jinja2.Environment(loader=jinja2.FileSystemLoader(os.path.dirname(__file__)), autoescape=True, trim_blocks=True)
        environment.filters["inline"] = inline
        page = environment.get_template("design_page.html.j2").render(
            style=markupsafe.Markup(STYLE), plan=plan, title=plan["title"] or "Avalanche on a mast", design=design, advice=advice,
            known_is_of=comparison.known_uncertainty_remark(plan),
            loads=load_table(ensemble, results), grids=grid_table(ensemble, results), snows=snow_table(plan), shape=plan["mast"]["shape"],
            comparison=comparison_table(ensemble, results), remarks=comparison.equation_remarks(plan),
            guideline=[(what, short(value), source) for what, value, source in comparison.guideline_rows(plan)],
            pictures=[p for p in pictures if p is not None], level=LEVELS[plan["level"]], accuracy=uncertain,
            not_steady=[os.path.basename(path) for path in results.not_steady], files=files, axis=short(middle.axis),
            duration=short(plan["duration_s"]), wall=sum(run.number("wall_time_s") or 0.0 for row in ensemble.runs for run in row) / 60.0,
            threads=middle.run.number("threads"), middle=ensemble.label(ensemble.middle),
            three_grids=len(plan["grids"]) > 2)
        path = os.path.join(folder, "design.html")
        write_page(path, page)
    except OSError as problem:
        raise InputError(f"cannot write to '{folder}': {problem.strerror}") from None
    lines = [f"{what}: {value} ({why})" for what, value, why in design]
    lines += [f"warning: snow {snows}: {text}" if snows else f"warning: {text}" for text, snows in advice]
    lines.append(f"largest grid uncertainties: {uncertain}")
    return path, lines


def run_command(options):
    path, lines = make_page(options.directory)
    print("\n".join(lines))
    print(f"wrote {path}")
