#!/usr/bin/python3
"""`pip install ./python` without a network, into a fresh environment over Debian's packages; then the installed package is used.

--no-deps: Debian's h5py has no metadata that pip would find. That everything needed is there is checked by importing it.

usage: python_install.py [MPM]    MPM: the program, to run a case with the installed package
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parent.parent
USE = """
import pathlib, re, sys, mpmtools
from mpmtools import Case, Run, equations, plots, quantities
assert pathlib.Path(mpmtools.__file__).is_relative_to(sys.prefix), mpmtools.__file__
assert len(quantities.known()) > 100  # package data
from importlib import import_module, metadata
for requirement in metadata.requires("mpmtools"):
    import_module(re.match(r"\\w+", requirement)[0])
import mpmtools.design.page, mpmtools.fit.text
assert len(mpmtools.design.factors.load_factors()) > 10
for package, name in (("design", "design_page.html"), ("figures", "view_page.html"), ("avaframe", "case.toml"), ("avaframe", "site.toml")):
    assert (pathlib.Path(mpmtools.__file__).parent / package / f"{name}.j2").exists(), name
if len(sys.argv) > 1:
    case = Case.read(sys.argv[1]).changed({"numerics.cell_size_m": 0.875, "conveyor.width_m": 8.75, "output.duration_s": 0.1})
    print(case.run(sys.argv[2], threads=1, progress=False).quantity("force_peak_n"))
"""


def run(*command, **options):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **options)
    print(done.stdout)
    if done.returncode != 0:
        sys.exit(f"exit code {done.returncode}: {' '.join(map(str, command))}")
    return done.stdout


def main():
    with tempfile.TemporaryDirectory() as folder:
        home = pathlib.Path(folder)
        # pip builds in the folder that it is given: in a copy
        shutil.copytree(SOURCE / "python", home / "python", ignore=shutil.ignore_patterns("__pycache__", "build", "*.egg-info"))
        run("/usr/bin/python3", "-m", "venv", "--system-site-packages", home / "venv")
        python = home / "venv" / "bin" / "python"
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | {"PIP_NO_INDEX": "1"}
        run(python, "-m", "pip", "install", "--no-build-isolation", "--no-deps", home / "python", env=environment)
        files = ["case", "run"] if len(sys.argv) < 2 else [SOURCE / "examples" / "avalanche_fr3.toml", home / "run"]
        if len(sys.argv) > 1:
            environment["MPM"] = os.path.abspath(sys.argv[1])
        run(python, "-c", USE, *(files if len(sys.argv) > 1 else []), env=environment, cwd=home)
        reported = run(home / "venv" / "bin" / "mpmtools", "--help", env=environment)
        assert "json-schema" in reported, reported


if __name__ == "__main__":
    main()
