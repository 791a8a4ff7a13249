"""`python3 -m mpmtools study`: the tables of the study, and its page."""

import os
import sys

from mpmtools.errors import ConfigError, InputError
from mpmtools.study.runs import RowFilter, number_of
from mpmtools.study.tables import write_study


def run(options):
    last_link = tuple(number_of(cell) for cell in options.decomposition.split(","))
    if len(last_link) != 3 or None in last_link:
        raise ConfigError(f"--decomposition {options.decomposition}: three numbers M,BETA,XI are needed, such as 0.8,0.3,0.5")
    evaluation = {"filters": [RowFilter(text) for text in options.filter], "notes": options.note, "last_link": last_link,
                  "finest": options.finest, "replace": options.replace}
    if options.name and not options.join:
        raise ConfigError("--name names the study of joined tables; give --join, too")
    if options.replace and not options.join:
        raise ConfigError("--replace is about rows of joined tables; give --join, too")
    others = {"width_files": options.width, "section_files": options.sections, "sensitivity_files": options.sensitivity,
              "friction_file": options.friction, "friction_scan_files": options.friction_scan, "prediction_files": options.prediction,
              "grids_files": options.grids, "coarser_files": options.coarser}
    folders = []
    for name, tables in studies_of(options.inputs, options.join, options.name):
        if not tables:
            folders.append(name)  # evaluated before
            continue
        folder = os.path.join(options.out, name)
        cautions, lines = write_study(tables, folder, **evaluation, **others)
        others = {}  # they belong to the first
        for caution in cautions:
            print(f"note: {caution}", file=sys.stderr)
        print(*lines, sep="\n")
        print(f"wrote the tables in {folder}", file=sys.stderr)
        folders.append(folder)
    if options.no_page:
        return
    from mpmtools.figures.study_page import draw_page

    page = os.path.join(options.out, "index.html")
    draw_page(page, folders, options.extensions)
    print(f"wrote {page}", file=sys.stderr)


def studies_of(inputs, join, name=None):
    """[(name, its tables)]; for a folder that was evaluated before, (folder, [])."""
    if join:
        tables = [table_of(path) for path in inputs]
        return [(name or name_of(tables[0]), tables)]
    studies, names = [], set()
    for path in inputs:
        if os.path.isfile(os.path.join(path, "fit.json")):
            studies.append((path, []))
            continue
        table = table_of(path)
        name = base = name_of(table)
        number = 2
        while name in names:
            name, number = f"{base}_{number}", number + 1
        names.add(name)
        studies.append((name, [table]))
    return studies


def table_of(path):
    table = os.path.join(path, "results.csv") if os.path.isdir(path) else path
    if not os.path.isfile(table):
        raise InputError(f"no table '{table}'; give the result table or the folder of a campaign")
    return table


def name_of(table):
    """That of the folder of the campaign."""
    return os.path.basename(os.path.dirname(os.path.abspath(table)))
