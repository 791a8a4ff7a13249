"""`python3 -m analysis`: the commands of this study, which `./run study` calls."""

import argparse
import os
import sys

from analysis import yardstick
from mpmtools.errors import MpmError


def run_page(options):
    from analysis import study
    from analysis.page import draw_page

    if options.inputs:
        folders, cautions, lines = study.evaluate_own(options.inputs, options.out)
        print(*(f"note: {caution}" for caution in cautions), sep="\n", file=sys.stderr)
        print(*lines, sep="\n")
    else:
        folders = study.evaluate_kept(options.out)
    page = os.path.join(options.out, "index.html")
    draw_page(page, folders, None if options.inputs else str(study.ROWS))
    print(f"wrote {page} and the tables beside it", file=sys.stderr)


def run_write(options):
    from analysis import texts

    texts.write()


def run_check(options):
    from analysis import texts

    if wrong := texts.check():
        print(*wrong, sep="\n", file=sys.stderr)
        print("the texts of the study are out of date: ./run study --write", file=sys.stderr)
        return 1
    print("tables and texts of the study are those of its rows")
    return 0


def run_yardstick(options):
    from mpmtools.fit.runs import read_runs_or_refuse

    summary, statements = yardstick.yardstick(yardstick.rules(*options.constants), read_runs_or_refuse(options.tables).runs)
    print(summary.to_string(index=False, float_format="{:.3f}".format))
    if options.statements:
        for name, of in statements.groupby("rule", sort=False):
            print(f"\n{name}", of.drop(columns="rule").to_string(index=False, float_format="{:.3f}".format), sep="\n")


def parser():
    top = argparse.ArgumentParser(prog="python3 -m analysis", description=__doc__)
    commands = top.add_subparsers(dest="command", required=True)

    def command(name, text, run):
        added = commands.add_parser(name, help=text)
        added.set_defaults(run=run)
        return added

    page = command("page", "the page of the paper's figures: from the rows of this study, or from your own campaigns", run_page)
    page.add_argument("inputs", nargs="*", metavar="TABLE.csv|DIR", help="result tables or folders of campaigns; none: the rows kept here")
    page.add_argument("--out", default="out/study", metavar="DIR", help="folder for index.html and a folder of tables for each campaign (default: %(default)s)")
    command("write", "makes tables/, the figure and the texts of the study again from its rows", run_write)
    command("check", "fails where tables/ or a text is not what its rows say", run_check)
    judge = command("yardstick", "distance of rules for the friction of the mast to the paper", run_yardstick)
    judge.add_argument("tables", nargs="+", metavar="RESULTS.csv", help="rows with several frictions of the mast")
    judge.add_argument("--constants", nargs="+", type=float, default=yardstick.CONSTANTS, metavar="MU", help="default: 0.2 0.25 0.3")
    judge.add_argument("--statements", action="store_true", help="every score and sentence of every rule, too")
    return top


def main(arguments=None):
    options = parser().parse_args(arguments)
    try:
        return options.run(options) or 0
    except MpmError as error:
        print(f"analysis {options.command}: {error}", file=sys.stderr)
        return error.exit_code


if __name__ == "__main__":
    sys.exit(main())
