"""A campaign: many runs of one plan."""

import json
import os
import subprocess
from typing import NamedTuple

import pandas as pd

from mpmtools.errors import InputError
from mpmtools.program import find_program, raise_for
from mpmtools.run import Run
from mpmtools.tables import read_series


class CampaignStatus(NamedTuple):
    """How far a campaign is: numbers of runs, the estimated wall time that is left, and a DataFrame with a row a run, by its name: state (done,
    running, failed, to do), progress (fraction of its duration), cause of a failure."""

    done: int
    running: int
    failed: int
    to_do: int
    time_left_s: float
    runs: pd.DataFrame


class Campaign:
    """The plan of a campaign and its folder (docs/campaigns.md).

        campaign = Campaign("validation/study/quick.toml", out="out/quick")
        campaign.run(jobs=2)
        campaign.table[["name", "froude_number", "runup_p99_mean_m"]]
        campaign.runs["fr3"].series

    plan  the plan file, or the folder of a campaign that was run before
    out   folder of the campaign; default as in `mpm campaign`: out/<name of the plan>
    """

    def __init__(self, plan, out=None):
        if os.path.isdir(plan):
            plan, out = os.path.join(plan, "plan.toml"), out or plan
        if not os.path.exists(plan):
            raise InputError(f"{plan}: there is no such plan; give a plan file, or the folder of a campaign")
        self.plan = str(plan)
        self.folder = str(out or os.path.join("out", os.path.splitext(os.path.basename(plan))[0]))

    def __repr__(self):
        return f"Campaign({self.plan!r}, out={self.folder!r})"

    def run(self, jobs=None, executor="local", retry_failed=False):
        """Runs what is not done; progress goes to the standard error. Returns True if every run is complete, False if some failed.

        An interruption is resumed by the same call.
        """
        options = ["--out", self.folder, "--executor", executor, *(["--jobs", str(jobs)] if jobs else []), *(["--retry-failed"] if retry_failed else [])]
        return self._command("run", *options) == 0

    def expansion(self):
        """What the plan says, as a dict: title, base (tables of the base case), and runs: of each the name, the case_hash, whether it is stored in
        a table of earlier results, and the settings that it has over the base, {"table.key": value}. Nothing is computed."""
        return json.loads(self._command("plan", "--json", read=True))

    def status(self):
        """A CampaignStatus; brings the tables up to date."""
        found = json.loads(self._command("status", "--out", self.folder, "--json", read=True))
        return CampaignStatus(**{**found, "runs": pd.DataFrame(found["runs"]).set_index("name")})

    @property
    def table(self):
        """results.csv as a DataFrame, a row a run; empty cells are NaN. Raises InputError before the first run."""
        return read_series(os.path.join(self.folder, "results.csv"), dtype={"case_hash": str})  # a hash may look like a number

    @property
    def runs(self):
        """{name: Run} of what is complete and in the folder, in the order of the plan. Raises InputError where a folder holds another case
        than its row of the table."""
        table = self.table
        done = table[table.status == "done"]
        runs = {}
        for name, folder, case_hash in zip(done["name"], done["run"], done["case_hash"]):
            path = os.path.join(self.folder, folder)
            if os.path.isdir(path):  # rows of stored results have no folder
                runs[name] = Run(path).require(case_hash, "`mpm campaign status` brings the table up to date")
        return runs

    def _command(self, verb, *options, read=False):
        command = [find_program(), "campaign", verb, self.plan, *options]
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=read, text=True, check=False)
        if done.returncode not in (0, 1):
            raise_for(done.returncode, done.stderr or "", f"mpm campaign {verb}")
        return done.stdout if read else done.returncode
