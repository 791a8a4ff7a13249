#!/usr/bin/python3
"""The bytes of a run by any number of ranks and threads are those of one rank and one thread.

    tests/mpi/matrix.py [--ranks 1,2,3,4,8] [--threads 1,2] [--case NAME]... [--program build/mpi/bin/mpm] [--out DIR]

For every case, number of ranks and number of threads:
  plain        the run as it is
  rebalanced   new and uneven cuts every ten steps, so that most blocks move
  killed       SIGKILL to a random rank in the middle, then resumed on another number of ranks and threads
final.h5, series.csv, profile.csv, profiles.h5, frames and case.toml must have the bytes of the run on one rank. A line a way, with the largest
share of the particles that one rank held at the end; then a table. Exit code 1 if any byte differs, or if a kill came too late.
"""

import itertools
import json
import random
import shutil
import sys

import rank_runs as runs


def ways(ranks, threads):
    for r, t in itertools.product(ranks, threads):
        if (r, t) != (1, 1):
            yield "plain", r, t
        if r > 1:
            yield "rebalanced", r, t
        yield "killed", r, t


class Matrix:
    def __init__(self, options):
        self.options, self.dice = options, random.Random(options.seed)
        self.ranks, self.threads = ([int(n) for n in text.split(",")] for text in (options.ranks, options.threads))
        self.table, self.failed = [], 0

    def killed(self, case, out, r, t):
        """@returns what was done, or None if the run had ended before"""
        run = runs.Disturbed(self.options, case, out, r, t)
        run.wait_for_rows(self.dice.randint(3, 6))
        hit = run.kill(self.dice.randrange(r))
        if run.end(120) in (0, None) or not hit or run.finished():
            return None
        others = self.dice.choice([n for n in self.ranks if n != r] or [r]), self.dice.choice(self.threads)
        runs.run(self.options, case, out, *others, ["--resume"])
        return f", then {others[0]} x {others[1]}"

    def one_case(self, name):
        options = self.options
        case, one = runs.write_case(options.out, name), options.out / f"{name}_one"
        runs.run(options, case, one)
        expected, results = runs.files(one), json.loads((one / "results.json").read_text())
        counts, equal = {}, {}
        for way, r, t in ways(self.ranks, self.threads):
            out, text = options.out / f"{name}_{way}_{r}x{t}", ""
            if way == "killed":
                text = self.killed(case, out, r, t)
            else:
                runs.run(options, case, out, r, t, rebalance=10 if way == "rebalanced" else 0)
            differing = ["the kill came too late"] if text is None else runs.differences(expected, out)
            if text == "" and r > 1:
                text = f", at most {100 * runs.busiest(out):.0f} % on one rank"
            counts[way], equal[way] = counts.get(way, 0) + 1, equal.get(way, 0) + (not differing)
            print(f"{name:21} {way:11} {r} ranks x {t} threads{text}: {'DIFFER: ' + ', '.join(differing) if differing else f'{len(expected)} files equal'}",
                  flush=True)
            if not differing:
                shutil.rmtree(out)
        self.failed += sum(counts.values()) - sum(equal.values())
        self.table.append(f"| `{name}` | {results['particles_final']} | {results['steps']} | {len(expected)} | " +
                          " | ".join(f"{equal.get(way, 0)} of {counts.get(way, 0)}" for way in ("plain", "rebalanced", "killed")) + " |")


def main():
    parser = runs.arguments(__doc__)
    parser.add_argument("--ranks", default="1,2,3,4,8")
    parser.add_argument("--threads", default="1,2")
    parser.add_argument("--case", action="append", choices=runs.CASES, help="may be repeated; left out: all")
    options = parser.parse_args()
    runs.prepare(options)
    matrix = Matrix(options)
    for name in options.case or runs.CASES:
        matrix.one_case(name)
    lines = [runs.provenance(options), "", "| case | particles | steps | files | plain | rebalanced | killed and resumed |", "|---|---|---|---|---|---|---|",
             *matrix.table]
    (options.out / "matrix.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))
    return 1 if matrix.failed else 0


if __name__ == "__main__":
    sys.exit(main())
