#!/usr/bin/python3
"""Pictures of the documents, and numbers that documents quote from a run: made by commands, and checked for age.

usage: pictures.py MPM [PICTURE...]     makes all pictures, or those of the entries that hold the named ones
       pictures.py --check              exit code 1 if an input, a picture or a quoted number changed since the pictures were made

docs/images/pictures.json has an entry for pictures that are made together:
  pictures  files below docs/images
  inputs    files of the repository from which they are made
  commands  lines of a shell, in the root of the repository; $OUT is an empty folder that becomes docs/images
  quoted    documents whose tables quote the run `run` below $OUT: a row "| `name` | ... | value |"
and what the last making left: commit of mpm, checksums, and the numbers of results.json that are quoted.
"""

import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
LIST = IMAGES / "pictures.json"
ROW = re.compile(r"^\| (?P<names>`[a-z0-9_`, ]+`) \|.*\| (?P<values>[^|]+) \|$", re.MULTILINE)


def checksum(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def quoted_numbers(document, results):
    """(name, text of the number, value) of every quantity of the results in the tables of a document; forces are quoted in kN."""
    for row in ROW.finditer((ROOT / document).read_text(encoding="utf-8")):
        texts = re.findall(r"-?\d+\.?\d*", row["values"])
        for name, text in zip(re.findall(r"\w+", row["names"]), texts):
            if name in results:
                value = results[name][0] if isinstance(results[name], list) else results[name]
                yield name, text, value * (1e-3 if "kN" in row["values"] else 1.0)


def make(entry, mpm):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder)
        environment = {**os.environ, "OUT": folder, "MPM": mpm, "PYTHONPATH": str(ROOT / "python"), "MPLBACKEND": "Agg",
                       "PATH": f"{pathlib.Path(mpm).parent}:{pathlib.Path(sys.executable).parent}:{os.environ['PATH']}"}
        for command in entry["commands"]:
            print(command, file=sys.stderr, flush=True)
            subprocess.run(["/bin/sh", "-c", command], cwd=ROOT, env=environment, check=True, stdout=subprocess.DEVNULL)
        for name in entry["pictures"]:
            shutil.copy(out / name, IMAGES / name)
        results = json.loads((out / entry["run"] / "results.json").read_text()) if "run" in entry else {}
    names = {name for document in entry.get("quoted", []) for name, _, _ in quoted_numbers(document, results)}
    version = subprocess.run([mpm, "--version"], capture_output=True, text=True, check=True).stdout
    entry["made"] = {"commit": re.search(r"commit (\w+)", version)[1], "numbers": {name: results[name] for name in sorted(names)},
                     "checksums": {name: checksum(ROOT / name) for name in files_of(entry)}}


def files_of(entry):
    return [*entry["inputs"], *(f"docs/images/{name}" for name in entry["pictures"])]


def problems(entries):
    listed = {name for entry in entries for name in entry["pictures"]}
    there = {str(path.relative_to(IMAGES)) for path in IMAGES.rglob("*") if path.suffix in (".png", ".webm")}
    for name in sorted(listed ^ there):
        yield f"docs/images/{name}: " + ("no command makes it: list it in pictures.json" if name in there else "it is missing")
    for entry in entries:
        again = f"make it again: docs/pictures.py MPM {entry['pictures'][0]}"
        for name in files_of(entry):
            if (ROOT / name).exists() and checksum(ROOT / name) != entry.get("made", {}).get("checksums", {}).get(name):
                yield f"{name} is not that of the pictures {', '.join(entry['pictures'])}; {again}"
        for document in entry.get("quoted", []):
            for name, text, value in quoted_numbers(document, entry.get("made", {}).get("numbers", {})):
                digits = len(text.partition(".")[2])
                if round(value, digits) != float(text):
                    yield f"{document}: `{name}` is {value:.{digits}f}, not {text}"


def main():
    entries = json.loads(LIST.read_text(encoding="utf-8"))
    if sys.argv[1:] == ["--check"]:
        found = list(problems(entries))
        sys.exit("\n".join(found) if found else None)
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    for entry in entries:
        if len(sys.argv) == 2 or set(entry["pictures"]) & set(sys.argv[2:]):
            make(entry, str(pathlib.Path(sys.argv[1]).resolve()))
            LIST.write_text(json.dumps(entries, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
