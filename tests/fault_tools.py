"""What faults.py and campaign_faults.py share."""

import csv
import os
import pathlib
import re
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
OK, FAILED, USAGE, IO = 0, 1, 2, 4  # exit codes (README)


def memory_folder(prefix, parent=None):
    """A new folder: in `parent`, or in memory if there is a file system in it, where fsync costs nothing."""
    return pathlib.Path(tempfile.mkdtemp(prefix=prefix, dir=parent or ("/dev/shm" if os.access("/dev/shm", os.W_OK) else None)))


def compile_failing_calls(folder):
    """Path of the library for LD_PRELOAD that makes file operations fail."""
    library = folder / "failing_calls.so"
    subprocess.run(["c++", "-shared", "-fPIC", "-O1", "-o", library, ROOT / "tests" / "support" / "failing_calls.cpp", "-ldl"], check=True)
    return library


def write_report(rows, command, mpm, out, seconds):
    """Writes faults.md and faults.csv, and prints the sum. Returns the exit code: 1 if any expectation failed.

    rows: dicts with the entries that are columns; "tries", "data lost" and "verdict" ("holds") among them.
    """
    failed = [row for row in rows if row["verdict"] != "holds"]
    lost = [row for row in rows if row["data lost"] not in ("none", "what was deleted")]
    commit = re.search(r"commit ([\w-]+)", subprocess.run([mpm, "--version"], capture_output=True, text=True).stdout)
    faults = sum(row["tries"] for row in rows)
    head = (f"`{command}`, commit {commit.group(1) if commit else 'unknown'}: "
            f"{faults} faults tried, {faults - sum(row['tries'] for row in failed)} survived as expected, data lost in {len(lost)}; {seconds:.0f} s.")
    out.mkdir(parents=True, exist_ok=True)
    names = list(rows[0])
    with open(out / "faults.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(rows)
    cell = lambda value: str(value).replace("|", "\\|")  # noqa: E731
    lines = [head, "", "| " + " | ".join(names) + " |", "|" + "---|" * len(names)]
    lines += ["| " + " | ".join(cell(row[name]) for name in names) + " |" for row in rows]
    (out / "faults.md").write_text("\n".join(lines) + "\n")
    print(head)
    return 1 if failed else 0
