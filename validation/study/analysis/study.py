"""The study as a whole: which kept rows are a campaign, what is compared with what, and the folders of tables that the page draws."""

import os
import pathlib
import shutil
from typing import NamedTuple

from analysis.tables import write_study
from mpmtools.errors import InputError
from mpmtools.fit.runs import read_runs_or_refuse

STUDY = pathlib.Path(__file__).resolve().parent.parent
ROWS = STUDY / "rows"
# What needs the folders of the runs, which are not kept: heights over time (Fig. 3) and two last states (Fig. 5).
KEPT = {"envelopes": "envelopes", "sections": "section_heights", **{name: name for name in (
    "section_slow", "section_fast", "section_profile_slow", "section_profile_fast")}}


def rows(*names):
    return [str(ROWS / f"{name}.csv") for name in names]


class Campaign(NamedTuple):
    files: list
    friction: str  # of the mast, in words
    compared: dict  # with what: arguments of write_study()


CAMPAIGNS = {
    "reproduction": Campaign(rows("reproduction"), "half of tan φ'", {
        "coarser_files": rows("reproduction_w5"), "width_files": rows("width"),
        "sensitivity_files": rows("sensitivity", "windows"), "friction_files": rows("friction_rules", "friction_scan", "reproduction")}),
    "reproduction_w5": Campaign(rows("reproduction_w5"), "the smaller of 0.2 and half of tan φ'", {
        "prediction_files": rows("prediction_w5"), "grids_files": rows("grids")}),
    "prediction": Campaign(rows("prediction_w5"), "half of tan φ'", {}),
}


def runs_of(name):
    """Runs of a campaign with a steady run-up."""
    return read_runs_or_refuse(CAMPAIGNS[name].files).runs


def evaluate_kept(out):
    """Tables of all campaigns from the rows that are kept here, a folder each; returns the folders."""
    folders = []
    for name, campaign in CAMPAIGNS.items():
        folder = os.path.join(out, name)
        write_study(campaign.files, folder, **campaign.compared)
        folders.append(folder)
    for table, kept in KEPT.items():
        shutil.copyfile(ROWS / f"{kept}.csv", os.path.join(folders[0], f"{table}.csv"))
    return folders


def evaluate_own(inputs, out):
    """Tables of a user's campaigns, a folder each; returns (folders, cautions, lines for the terminal)."""
    folders, cautions, lines = [], [], []
    for path in inputs:
        table = os.path.join(path, "results.csv") if os.path.isdir(path) else path
        if not os.path.isfile(table):
            raise InputError(f"no table '{table}'; give the result table or the folder of a campaign")
        name = base = os.path.basename(os.path.dirname(os.path.abspath(table)))
        number = 2
        while os.path.join(out, name) in folders:
            name, number = f"{base}_{number}", number + 1
        found, more = write_study([table], os.path.join(out, name))
        folders.append(os.path.join(out, name))
        cautions += found
        lines += more
    return folders, cautions, lines
