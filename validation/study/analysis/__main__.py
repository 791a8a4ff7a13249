"""`python3 -m analysis`: the commands of this study, which `./run study` calls."""

import argparse
import sys

from analysis import yardstick
from mpmtools.errors import MpmError
from mpmtools.study.runs import read_runs_or_refuse


def run_yardstick(options):
    runs = read_runs_or_refuse(options.tables).runs
    summary, statements = yardstick.yardstick(yardstick.rules(*options.constants), runs)
    print(summary.to_string(index=False, float_format="{:.3f}".format))
    if options.statements:
        for name, of in statements.groupby("rule", sort=False):
            print(f"\n{name}", of.drop(columns="rule").to_string(index=False, float_format="{:.3f}".format), sep="\n")


def main():
    top = argparse.ArgumentParser(prog="python3 -m analysis", description=__doc__)
    commands = top.add_subparsers(dest="command", required=True)
    judge = commands.add_parser("yardstick", help="distance of rules for the friction of the mast to the paper (yardstick.md)")
    judge.add_argument("tables", nargs="+", metavar="RESULTS.csv", help="rows with several frictions of the mast")
    judge.add_argument("--constants", nargs="+", type=float, default=[0.2, 0.25, 0.3], metavar="MU", help="default: 0.2 0.25 0.3")
    judge.add_argument("--statements", action="store_true", help="every score and sentence of every rule, too")
    judge.set_defaults(run=run_yardstick)
    options = top.parse_args()
    options.run(options)


if __name__ == "__main__":
    try:
        main()
    except MpmError as error:
        sys.exit(f"analysis: {error}")
