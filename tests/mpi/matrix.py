#!/usr/bin/python3
"""The bytes of a run by any number of ranks and threads are those of one rank and one thread.

    tests/mpi/matrix.py [--program build/mpi/bin/mpm] [--ranks 1,2,3,4,8] [--threads 1,2] [--case NAME]... [--out DIR]

For every case, number of ranks and number of threads:
  plain        the run as it is
  rebalanced   new and uneven cuts every ten steps, so that most blocks move
  resumed      stopped by its duration at two thirds, then resumed on another number of ranks and threads
final.h5, series.csv, profile.csv, profiles.h5, frames and case.toml must have the bytes of the run on one rank. A line a way; the last says
how many. Exit code 1 if any byte differs. About 200 runs of some seconds each. (Kills at random moments: faults.py beside this file.)
"""

import itertools
import shutil
import sys

import rank_runs as runs


def ways(ranks, threads):
    for r, t in itertools.product(ranks, threads):
        yield "plain", r, t
        if r > 1:
            yield "rebalanced", r, t
        yield "resumed", r, t


def main():
    parser = runs.arguments(__doc__)
    parser.add_argument("--ranks", default="1,2,3,4,8")
    parser.add_argument("--threads", default="1,2")
    parser.add_argument("--case", action="append", choices=runs.CASES, help="may be repeated; left out: all")
    options = parser.parse_args()
    ranks, threads = ([int(n) for n in text.split(",")] for text in (options.ranks, options.threads))
    runs.prepare(options)
    count = bad = 0
    for name in options.case or runs.CASES:
        case = runs.write_case(options.out, name)
        runs.run(options, case, options.out / f"{name}_one")
        expected = runs.files(options.out / f"{name}_one")
        duration = {**runs.DEFAULTS, **runs.CASES[name]}["duration"]
        for k, (way, r, t) in enumerate(ways(ranks, threads)):
            if (way, r, t) == ("plain", 1, 1):
                continue
            out = options.out / f"{name}_{way}_{r}x{t}"
            if way == "resumed":
                others = ranks[(k + ranks.index(r) + 1) % len(ranks)], threads[k % len(threads)]
                runs.run(options, case, out, r, t, ["--set", f"output.duration_s={duration * 2 / 3:.2f}"])
                runs.run(options, case, out, *others, ["--resume"])
            else:
                others = None
                runs.run(options, case, out, r, t, rebalance=10 if way == "rebalanced" else 0)
            differing = runs.differences(expected, out)
            count, bad = count + 1, bad + bool(differing)
            print(f"{name:18} {way:11} {r} ranks x {t} threads{f', then {others[0]} x {others[1]}' if others else ''}: "
                  f"{', '.join(differing) + ' DIFFER' if differing else f'{len(expected)} files equal'}", flush=True)
            if not differing:
                shutil.rmtree(out)
    print(f"{count} ways, {bad} differ")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
