#!/usr/bin/python3
"""Single against double precision over the validation cases.

usage: compare.py DOUBLE SINGLE... [--checks]

DOUBLE and SINGLE are output folders of `mpm-validate run`, of one level, without and with `--precision single`; SINGLE may be several, each
with some of the cases. Prints a Markdown table.
For every check, the difference of the two values stands beside the numerical error of the one in double precision: how far it is from
the reference where that is exact (verification), else the tolerance that the check allows. One row a case: the check with the largest
share. With --checks: every check whose share is above a tenth.
"""

import json
import math
import sys
from pathlib import Path


def load(folder):
    data = json.loads((Path(folder) / "results.json").read_text())
    return data, {case["name"]: case for case in data["cases"]}


def scaled(check):
    """The value in the units of the check's error and tolerance."""
    if check["measure"] == "relative":
        return check["value"] / abs(check["reference"]) if check["reference"] else math.nan
    return check["value"]


def numerical_error(check):
    """In the units of `scaled`."""
    if check["label"] == "verification" and check["error"] and check["measure"] != "at_most":
        return abs(check["error"])
    return abs(check["tolerance"]) or abs(scaled({**check, "value": check["reference"]}))


def compare(double, single):
    rows = []
    for a, b in zip(double["checks"], single["checks"]):
        if a["quantity"] != b["quantity"]:
            sys.exit(f"{double['name']}: the checks differ: '{a['quantity']}' and '{b['quantity']}'")
        difference, error = abs(scaled(a) - scaled(b)), numerical_error(a)
        rows.append((difference / error if error > 0 else math.inf if difference > 0 else 0.0, a, b))
    return sorted(rows, key=lambda row: -row[0])


def main(arguments):
    every = "--checks" in arguments
    folders = [a for a in arguments if a != "--checks"]
    if len(folders) < 2:
        sys.exit(__doc__)
    info, double = load(folders[0])
    single = {}
    for folder in folders[1:]:
        other, cases = load(folder)
        if (info["precision"], other["precision"]) != ("double", "single") or info["level"] != other["level"]:
            sys.exit(f"{folder}: give a run in double and some in single precision, of one level")
        single |= cases
    print(f"Level {info['level']}; double: commit {info['commit']}, single: commit {other['commit']}; {info['instruction_set']}.\n")
    print("| case | checks | failed in double | failed in single | largest share | of the check | double | single |")
    print("|---|---:|---:|---:|---:|---|---:|---:|")
    for name in sorted(double.keys() & single.keys()):
        a, b = double[name], single[name]
        if a["fault"] or b["fault"]:
            print(f"| {name} | | {a['fault']} | {b['fault']} | | | | |")
            continue
        rows = compare(a, b)
        tenth = [row for row in rows if row[0] > 0.1]
        for share, x, y in (tenth or rows[:1]) if every else rows[:1]:
            failed = [sum(not c["passed"] and not c["miss_cause"] for c in case["checks"]) for case in (a, b)]
            print(f"| {name} | {len(rows)} | {failed[0]} | {failed[1]} | {share:.2g} | {x['quantity']} "
                  f"| {x['value']:.8g} | {y['value']:.8g} |")


if __name__ == "__main__":
    main(sys.argv[1:])
