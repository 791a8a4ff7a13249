"""A case: read, change, check and run it."""

import contextlib
import copy
import os
import pathlib
import re
import tempfile
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass

from mpmtools.errors import ConfigError, MpmError
from mpmtools.files import MissingEntry, read_toml, write_text
from mpmtools.program import run_program, run_with_bar
from mpmtools.toml_text import toml_text, with_lists

STEP = re.compile(r"([A-Za-z0-9_-]+)(?:\[(\d+)\])?")  # of the name of a key: a table, or an entry of an array of tables
COST = re.compile(r"^# (particles|occupied cells|wave speed|time step|steps|samples|frames|memory|disk|time)\s+([-+.\de]+)", re.MULTILINE)
UNITS = {"wave speed": "_m_s", "time step": "_s", "memory": "_gb", "disk": "_gb", "time": "_s"}


@dataclass(frozen=True)
class Check:
    """What `mpm check` says of a case.

    case      with every key that it will use, defaults included
    warnings  what may spoil the result, each with its reason and a remedy
    cost      particles, steps, time_step_s, memory_gb, time_s (estimated elapsed time), ...
    """

    case: "Case"
    warnings: list
    cost: dict

    def __str__(self):
        return "\n".join(["{particles:.0f} particles, {steps:.0f} steps, about {time_s:.3g} s on two cores, {memory_gb:.3g} GB".format(**self.cost),
                          *(f"warning: {text}" for text in self.warnings)])


class Case(Mapping):
    """A case as a mapping from the names of its keys to their values. A case does not change: `changed` returns another one.

        case = Case.read("examples/avalanche_fr3.toml").changed({"numerics.cell_size_m": 0.35})
        print(case.check())
        run = case.run("out/fr3")

    Keys have the names of the case file, `table.key`: "obstacle.width_m", "body[0].velocity_m_s", "title"; dict(case) has all of them. The name
    of a table, case["obstacle"], gives the table as a dict.
    The program judges them, in `check` and in `run`; a wrong one raises ConfigError with its name, the reason and a remedy.

    tables  the case as dicts, lists and values
    folder  where the files are that the case names (inflow_csv, terrain.file); the folder of the case file
    """

    def __init__(self, tables, folder="."):
        self.tables, self.folder, self.path = with_lists(copy.deepcopy(dict(tables))), pathlib.Path(folder), "case"

    @classmethod
    def read(cls, path):
        """Reads a case file. Raises InputError where it cannot be read or is no TOML."""
        case = cls(read_toml(path), pathlib.Path(path).parent)
        case.path = path
        return case

    def __repr__(self):
        return f"Case({self.tables.get('title', '')!r})"

    def __eq__(self, other):
        return isinstance(other, Case) and self.tables == other.tables and self._files() == other._files()

    __hash__ = None

    def __getitem__(self, key):
        """The value of a key, or a table. Raises MissingEntry where the case leaves it out; `check().case` has every default."""
        found = self.tables
        for name, index in _steps(key):
            try:
                found = found[name] if index is None else found[name][index]
            except (KeyError, IndexError, TypeError):
                raise MissingEntry(f"{self.path}: {key}: the case does not give it; check().case holds the defaults") from None
        return found

    def __iter__(self):
        return _keys(self.tables)

    def __len__(self):
        return sum(1 for _ in self)

    def changed(self, changes):
        """A case with other values: a dict from the names of keys to values; None leaves a key (or a table) out."""
        case = Case(self.tables, self.folder)
        for key, value in dict(changes).items():
            *path, (last, index) = _steps(key)
            table = case.tables
            for name, at in path:
                table = table.setdefault(name, {}) if at is None else _entry(table, name, at, key)
                if not isinstance(table, dict):
                    raise ConfigError(f"{key}: '{name}' is no table of this case")
            if index is not None:
                _entry(table, last, index, key)  # it exists
                table, last = table[last], index
            if value is None:
                table.pop(last) if isinstance(table, list) else table.pop(last, None)
            else:
                table[last] = with_lists(copy.deepcopy(value))
        return case

    def text(self, folder=None):
        """The case as TOML, for a file in `folder` (default: the case's own)."""
        if folder is None or pathlib.Path(folder).resolve() == self.folder.resolve():
            return toml_text(self.tables)
        return toml_text(self.changed({key: str(path) for key, path in self._files().items()}).tables)

    def write(self, path):
        """Writes the case file; names of files in it keep their meaning."""
        path = pathlib.Path(path)
        write_text(path, self.text(path.parent))
        return path

    def check(self):
        """Lets the program check the case; computes nothing. Returns a Check."""
        with self.as_file() as path:
            _, resolved, messages = run_program("check", path)
        cost = {name.replace(" ", "_") + UNITS.get(name, ""): float(number) for name, number in COST.findall(resolved)}
        warnings = [line.removeprefix("warning: ") for line in messages.splitlines() if line.startswith("warning: ")]
        return Check(Case(tomllib.loads(resolved), self.folder), warnings, cost)

    def run(self, out, threads=None, resume=False, force=False, progress=True):
        """Computes the case into the folder `out`. Returns the Run.

        resume    continue an interrupted run, or extend a finished one
        force     overwrite the results of an earlier run
        progress  True: a bar on the standard error; or a function of a Progress; or False
        """
        options = ["--out", out, *(["--threads", threads] if threads else []), *["--resume"] * resume, *["--force"] * force]
        with self.as_file() as path:
            from mpmtools.run import Run  # which has a case, too

            run_with_bar(self.tables.get("title") or "run", progress, "run", path, *options)
        return Run(out)

    def _files(self):
        """Files that the case names, by key, as absolute paths."""
        keys = ("conveyor.inflow_csv", "terrain.file")
        return {key: (self.folder / self[key]).resolve() for key in keys if key in self}

    @contextlib.contextmanager
    def as_file(self):
        """The case as a file that exists inside `with case.as_file() as path`, for a command of your own."""
        with tempfile.TemporaryDirectory() as folder:
            path = self.write(os.path.join(folder, "case.toml"))
            try:
                yield path
            except MpmError as error:  # the file is a temporary one
                error.args = (re.sub(re.escape(str(path)) + r"(:\d+:\d+)?", "case", str(error)),)
                raise


def _steps(key):
    """[(table, index or None), ...] of "body[0].velocity_m_s"."""
    steps = [STEP.fullmatch(step) for step in str(key).split(".")]
    if not all(steps):
        raise ConfigError(f"'{key}' is no name of a key; such are obstacle.width_m, body[0].velocity_m_s and title")
    return [(step[1], int(step[2]) if step[2] else None) for step in steps]


def _keys(tables, before=""):
    """Names of all keys of nested tables and arrays of tables."""
    for name, value in tables.items():
        parts = [(f"[{i}]", part) for i, part in enumerate(value)] if isinstance(value, list) else [("", value)]
        if parts and all(isinstance(part, dict) and part for _, part in parts):
            for index, part in parts:
                yield from _keys(part, f"{before}{name}{index}.")
        else:
            yield before + name


def _entry(table, name, index, key):
    entries = table.get(name)
    if not isinstance(entries, list) or index >= len(entries):
        raise ConfigError(f"{key}: the case has {len(entries) if isinstance(entries, list) else 'no'} [[{name}]]")
    return entries[index]
