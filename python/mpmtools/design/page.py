"""design.html, from the folder of a design."""

import datetime
import hashlib
import json
import math
import os
import pathlib
import re

import jinja2
import markupsafe

from mpmtools.design import comparison, figures, page_tables, scaling, uncertainty, what_decides
from mpmtools.design.cautions import accuracy, advice_rows
from mpmtools.design.data_files import design_json, write_tables
from mpmtools.design.ensemble import Ensemble
from mpmtools.design.headlines import design_rows, longer, marked
from mpmtools.design.loads import all_modes
from mpmtools.design.results import Results, is_oblique
from mpmtools.design.rounding import short, upward, with_unit
from mpmtools.figures.style import STYLE, use_style
from mpmtools.files import write_text


def input_of(ensemble):
    """Name and hash of the site file; of the plan where it is missing."""
    files = (pathlib.Path(ensemble.folder) / name for name in ("site.toml", "design_plan.json"))
    path = next(path for path in files if path.exists())
    return f"{path.name} {hashlib.sha256(path.read_bytes()).hexdigest()[:12]}"


def cover_text(ensemble):
    """What a metre of snow cover under the flow does to the headlines, in a sentence; empty: there is one."""
    plan, compute = ensemble.plan, "compute it with <code>[flow] snow_cover_m</code>"
    if ensemble.base:
        return ""
    if "arm" in plan or any(mode["shape_at_load"] is not None for mode in plan["modes"]):
        why = "the arm is then nearer to the flow" if "arm" in plan else "the mode's shape at the load grows, too"
        return markupsafe.Markup(f"A snow cover or deposit under the flow lifts all loads, and {why}: {compute}.")
    raised = ensemble.raised(1.0)
    results = Results(raised)
    force, moment = (marked(raised, results, with_unit(upward(results.headline(load)[1], 1e-3), unit), load)
                     for load, unit in (("force", "kN"), ("moment", "kN m")))
    vibration = ", with the vibration, which grows more than the heights" if plan["modes"] else ""
    return markupsafe.Markup(f"A snow cover or deposit under the flow lifts all loads: on 1 m of it, all heights are 1 m greater, and the upper values at the foundation are "
                             f"{force} and {moment}{vibration}. Where there is one, {compute}.")


def make_page(folder):
    """Writes everything into the folder. @return (path of the page, [line for the user])"""
    use_style()
    ensemble = Ensemble(folder)
    plan, results = ensemble.plan, Results(ensemble)
    middle, loads = results.finest[ensemble.middle], results.finest
    spectrum = figures.spectra(ensemble, loads)
    sensitivity = what_decides.sensitivity_rows(ensemble, results)
    design, advice = design_rows(ensemble, results), advice_rows(ensemble, results)
    pictures = [figures.side_view(ensemble, middle), figures.view_3d(ensemble, middle),
                figures.pressure_over_height(ensemble, loads), figures.line_load(results, plan),
                figures.over_time(ensemble, loads, "force"), figures.over_time(ensemble, loads, "moment"),
                figures.shock_spectrum(ensemble, loads, spectrum), figures.runup_over_time(ensemble, loads), figures.grid_convergence(ensemble, results.table)]
    files = write_tables(ensemble, results, spectrum)
    write_text(os.path.join(folder, "design.json"), json.dumps(design_json(ensemble, results), indent=2))
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(os.path.dirname(__file__)), autoescape=True, trim_blocks=True)
    environment.filters.update(short=short, radians=math.radians, cosine=math.cos, sine=math.sin)
    environment.filters["css"] = lambda text: markupsafe.Markup(json.dumps(re.sub(r"[\\<>\n]", " ", str(text)), ensure_ascii=False))  # a string of CSS
    page = environment.get_template("design_page.html.j2").render(
        style=markupsafe.Markup(STYLE), plan=plan, ensemble=ensemble, results=results, middle=middle, today=datetime.date.today(),
        input=input_of(ensemble), cover=cover_text(ensemble), design=design, advice=advice, accuracy=accuracy(results), longer=longer(plan),
        oblique=is_oblique(plan), all_modes=all_modes(plan), pictures=pictures, tornado=figures.tornado(sensitivity), sensitivity=sensitivity,
        files=files, comparison=comparison, tables=page_tables, scaling=scaling, uncertainty=uncertainty, what_decides=what_decides)
    path = os.path.join(folder, "design.html")
    write_text(path, page)
    lines = [f"{what}: {value} ({why})" for what, value, why in design]
    lines += [f"warning: snow {snows}: {text}" if snows else f"warning: {text}" for text, snows in advice]
    lines.append(f"largest grid uncertainties of steady means: {accuracy(results)}")
    return path, lines


def run_command(options):
    path, lines = make_page(options.directory)
    print("\n".join(lines))
    print(f"wrote {path}")
