"""The page validation/results.md from reference_data/validation_orders: every check of the suite as it was last recorded."""

import csv
import pathlib

from markdown_tables import table

ROOT = pathlib.Path(__file__).resolve().parent.parent
RECORDED = ROOT / "reference_data" / "validation_orders"
PAGE = ROOT / "validation" / "results.md"
LEVELS = ("quick", "standard")


def read(name):
    with open(RECORDED / name, encoding="utf-8") as file:
        return list(csv.DictReader(file))


def percent(fraction):
    return f"{100.0 * float(fraction):.3g} %"


def number(text, unit=""):
    return f"{float(text):.4g} {unit}".strip() if text else ""


def allowed(check):
    """What the result may be, by the measure of its error."""
    unit, tolerance = check["unit"], float(check["tolerance"])
    if check["measure"] == "at_most":
        return f"at most {float(check['reference']) + tolerance:.4g} {unit}".strip()
    return number(check["reference"], unit) + (f" ± {percent(tolerance) if check['measure'] == 'relative' else number(tolerance, unit)}" if tolerance else "")


def result(check):
    """With its deviation where that is a fraction; bold if the target is not met."""
    if check is None:
        return ""
    text = number(check["result"], check["unit"])
    if check["measure"] == "relative" and float(check["reference"]) != 0.0:
        text += f" ({100.0 * (float(check['result']) / float(check['reference']) - 1.0):+.2g} %)"
    return text if check["verdict"] == "ok" else f"**{text}**"


def by_check(checks):
    """{(quantity, how often the name was there before): {level: check}} of a case; some cases check one quantity several times under one name."""
    rows = {}
    for level in LEVELS:
        repeats = {}
        for check in checks.get(level, []):
            repeats[check["quantity"]] = repeats.get(check["quantity"], -1) + 1
            rows.setdefault((check["quantity"], repeats[check["quantity"]]), {})[level] = check
    return rows


def values(found):
    """The last three columns: what is allowed, and the results."""
    return allowed(found.get("standard") or found["quick"]), *(result(found.get(level)) for level in LEVELS)


def missed_rows(case, checks):
    """The checks of a case that are not met at a level, with bounds and cause."""
    for (quantity, _), found in by_check(checks).items():
        if missed := [check for check in found.values() if check["verdict"] != "ok"]:
            bounds = " and ".join(dict.fromkeys(check["bound"] for check in missed if check["bound"]))
            yield f"[{case}](#{case}): {quantity}", *values(found), f"{missed[-1]['cause']} (must stay {bounds})"


def recordings(runs):
    """Checks, time and origin of the recordings of each level."""
    rows = []
    for level in LEVELS:
        for commit in dict.fromkeys(run["commit"] for run in runs if run["level"] == level):
            of = [run for run in runs if run["level"] == level and run["commit"] == commit]
            rows.append((f"`{level}`", str(len(of)), f"{sum(float(run['wall_time_s']) for run in of) / 60.0:.1f} min", f"`{commit[:8]}`",
                         max(run["date"] for run in of), of[0]["machine"]))
    return table(("level", "cases", "their times, added", "commit", "date", "machine"), rows)


def page():
    checks, runs = read("data.csv"), read("runs.csv")
    by_case = {}
    for check in checks:
        by_case.setdefault(check["case"], {}).setdefault(check["level"], []).append(check)
    counts = [(f"`{level}`", *(str(sum(c["verdict"] == verdict for c in checks if c["level"] == level)) for verdict in ("ok", "not met", "FAILED")))
              for level in LEVELS]
    missed = [row for case, levels in sorted(by_case.items()) for row in missed_rows(case, levels)]
    parts = ["# Results of the validation suite",
             "Every check as `mpm-validate run --record` last stored it in `reference_data/validation_orders`. The README of each case\n"
             "explains reference, tolerance and cause. This page is generated (`docs/generate.py`).",
             recordings(runs), table(("level", "ok", "not met", "failed"), counts),
             "## Targets that are not met", table(("check", "allowed", *LEVELS, "cause"), missed),
             "## All checks", "A deviation in brackets is from the reference. Bold: the target is not met."]
    for case, levels in sorted(by_case.items()):
        rows = [(quantity, *values(found)) for (quantity, _), found in by_check(levels).items()]
        parts += [f"### {case}", f"[README](cases/{case}/README.md)", table(("check", "allowed", *LEVELS), rows)]
    return "\n\n".join(parts) + "\n"


def contradictions():
    """READMEs that say of a case with a target that is not met, or without one, the other."""
    missed = {check["case"] for check in read("data.csv") if check["verdict"] != "ok"}
    for readme in sorted((ROOT / "validation" / "cases").glob("*/README.md")):
        case, says = readme.parent.name, "not met" in readme.read_text(encoding="utf-8").lower()
        if says != (case in missed):
            yield f"{readme.relative_to(ROOT)} {'names a target that is not met, results.md has none' if says else 'does not name the targets that are not met'}"
