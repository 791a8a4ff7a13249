#!/usr/bin/python3
"""What may happen to the folders of campaigns and designs, and to the files that Python reads, done to them on purpose:
`./run faults --campaigns [--seed N] [--trials N]`.

A campaign of four small runs is computed once undisturbed: the reference. Then campaigns are killed, their files damaged one at a time, and
their plans and tables spoilt; the folders that `python3 -m mpmtools` reads are damaged likewise. Expected of every fault:
- the exit code of its kind (README), and never an internal error, a crash or a traceback;
- a damaged file of one run is the failure of that run alone, and named; all other rows of the table are those of the reference;
- the same command, after a damaged file is deleted, leaves the table of the reference, byte for byte;
- nothing that a user wrote is changed.

faults.md and faults.csv hold a line for each kind. Exit code 1 if any expectation failed.
"""

import argparse
import contextlib
import csv
import io
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import time

from fault_tools import FAILED, IO, OK, ROOT, USAGE, compile_failing_calls, memory_folder, write_report

sys.path[0:1] = [str(ROOT / "tests" / "python"), str(ROOT / "python"), str(ROOT / "validation" / "study"), str(ROOT / "scripts")]  # not this folder, which holds a packaging.py

PATIENCE = 300.0  # seconds after which a command hangs, on a very busy machine
CRASHES = ("internal error", "terminate called", "Traceback", "egmentation", "Sanitizer", "what():")
PLAN = """title = "blocks"
base = { material = { model = "hencky_elastic" }, body = [{ min_m = [0, 0, 0], max_m = [1, 1, 1] }], domain = { min_m = [-5, -5, -5], max_m = [5, 5, 5] }, output = { duration_s = 0.02, series_per_second = 100 } }
[parameters]
"numerics.cell_size_m" = [0.5, 0.25]
"numerics.cfl" = [0.2, 0.4]
"""
CASE = """title = "a falling block"
[material]
model = "hencky_elastic"
[[body]]
min_m = [0.0, 0.0, 0.0]
max_m = [1.0, 1.0, 1.0]
[domain]
min_m = [-5.0, -5.0, -5.0]
max_m = [5.0, 5.0, 5.0]
[output]
duration_s = 0.02
"""
SITE = """title = "Small"
[flow]
depth_m = 1.0
velocity_m_s = 3.0
[[snow]]
name = "only"
critical_state_slope = 0.4
cohesion_beta = 0.0
hardening_xi = 0.1
[mast]
width_m = 1.0
[plan]
finest_cells = 5
grids = 2
duration_s = 0.6
"""
CAMPAIGN = ("campaign", "run", "plan.toml", "--out", "out", "--jobs", "2")
WRONG = (None, 5, -1.5, "x", "\udcff", [], [1], {}, {"a": 1}, True)  # JSON of a wrong type


class Faults:
    def __init__(self, arguments):
        self.random, self.mpm, self.trials = random.Random(arguments.seed), str(arguments.mpm.resolve()), arguments.trials
        self.folder = memory_folder("mpm-campaign-faults-")
        self.environment = {**os.environ, "OMP_WAIT_POLICY": "passive", "MPM": self.mpm}
        self.rows, self.number = [], 0

    # --- running and judging ---
    def place(self):
        self.number += 1
        made = self.folder / f"trial{self.number}"
        made.mkdir()
        return made

    def run(self, *words, at=None, environment=None, **how):
        done = subprocess.run([self.mpm, *map(str, words)], cwd=at or self.folder, env={**self.environment, **(environment or {})},
                              stdin=subprocess.DEVNULL, capture_output=True, timeout=PATIENCE, check=False, **how)
        return done.returncode, done.stderr.decode(errors="replace")

    def campaign(self, at):
        return self.run(*CAMPAIGN, at=at)

    def trial(self, kind, expected, number, one):
        """Calls one() a number of times; it returns what was wrong, and leaves a message in self.seen."""
        wrong, self.seen, tried = [], "-", max(1, round(number * self.trials / 300))
        for i in range(tried):
            try:
                problem = one()
            except subprocess.TimeoutExpired:
                problem = "hangs"
            if problem:
                wrong.append(problem)
                print(f"FAIL  {kind}, {i + 1}: {problem}", flush=True)
        self.rows.append({"fault": kind, "tries": tried, "expected": expected, "message seen": self.shown(self.seen),
                          "data lost": self.shown("; ".join(wrong[:3])) or "none", "verdict": "holds" if not wrong else "FAILS"})
        print(f"{'ok  ' if not wrong else 'FAIL'}  {kind} (x{tried}) | {self.shown(self.seen)}", flush=True)

    def shown(self, text):
        text = " ".join(text.replace(str(self.folder), "DIR").split())
        return text if len(text) < 200 else text[:197] + "..."

    def crash(self, code, err):
        self.seen = err.strip().splitlines()[-1] if err.strip() else self.seen
        if code not in (OK, FAILED, USAGE, IO):
            return f"exit {code}: {err[-300:]}"
        return next((f"'{word}' in the messages: {err[-300:]}" for word in CRASHES if word in err), "")

    def table_differs(self, at):
        table = at / "out" / "results.csv"
        return "" if table.exists() and table.read_bytes() == self.table else "results.csv differs from the reference"

    def compute_reference(self):
        self.reference, (_, self.table), self.seconds = self.undisturbed("plan.toml", PLAN, CAMPAIGN, "results.csv")
        self.names = [row["name"] for row in csv.DictReader(io.StringIO(self.table.decode()))]

    # --- damage ---
    def damaged_json(self, path):
        """Valid JSON with something of a wrong type."""
        content = json.loads(path.read_text())
        holders = [content, *(a for a in content.get("attempts", []) if isinstance(a, dict))] if isinstance(content, dict) else [{}]
        holder = self.random.choice(holders)
        if not holder or self.random.random() < 0.2:
            return json.dumps(self.random.choice(WRONG[:-1])).encode()
        key = self.random.choice(sorted(holder))
        if self.random.random() < 0.3:
            del holder[key]
        else:
            holder[key] = self.random.choice(WRONG)
        return json.dumps(content, ensure_ascii=False).encode(errors="surrogateescape")

    def damage(self, path, kinds):
        """Damages a file. Returns how."""
        kind = self.random.choice(kinds)
        data = path.read_bytes()
        if kind == "cut off":
            path.write_bytes(data[:self.random.randrange(len(data))])
        elif kind == "bytes":
            spoilt = bytearray(data)
            for _ in range(self.random.choice((1, 8))):
                spoilt[self.random.randrange(len(spoilt))] = self.random.randrange(256)
            path.write_bytes(spoilt)
        elif kind == "not UTF-8":
            at = self.random.randrange(len(data))
            path.write_bytes(data[:at] + b"\xe4\xff" + data[at:])
        elif kind == "wrong type":
            path.write_bytes(self.damaged_json(path))
        elif kind == "nested":
            path.write_bytes(self.random.choice((b"[", b'{"a":')) * 100_000)
        elif kind == "folder":
            path.unlink()
            path.mkdir()
        elif kind == "loop of links":
            path.unlink()
            path.symlink_to(path.name)
        elif kind == "device without end":
            path.unlink()
            path.symlink_to("/dev/zero")
        elif kind == "line":
            lines = data.split(b"\n")
            del lines[self.random.randrange(len(lines))]
            path.write_bytes(b"\n".join(lines))
        elif kind == "missing":
            path.unlink()
        return kind

    # --- campaigns ---
    def killed(self, file, text, words, table, seconds, most=3):
        """A trial for trial(): a command on a file of this text is killed up to `most` times and given again. It must leave this table.
        @param words  of the command; @param seconds  that it takes"""
        def one():
            at = self.place()
            (at / file).write_text(text)
            for _ in range(self.random.randint(1, most)):
                process = subprocess.Popen([self.mpm, *words], cwd=at, env=self.environment, stdin=subprocess.DEVNULL,
                                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
                time.sleep(self.random.uniform(0.0, 1.1 * seconds))
                process.kill()
                process.wait()
            problem = self.ends_with(table, at, *words)
            left = [str(path) for path in at.rglob(".*.tmp")]
            shutil.rmtree(at)
            return problem or (f"left over: {left}" if left else "")

        return one

    def ends_with(self, table, at, *words):
        """What is wrong if a command does not end with exit code 0 and a file out/NAME of these bytes. @param table  (NAME, bytes)"""
        code, err = self.run(*words, at=at)
        name, content = table
        problem = self.crash(code, err) or ("" if code == OK else f"exit {code}: {err[-300:]}")
        return problem or ("" if (at / "out" / name).read_bytes() == content else f"{name} differs from the reference")

    def undisturbed(self, file, text, words, name):
        """(folder, (name, bytes of the table out/NAME), seconds) of a command that nothing disturbs."""
        at = self.place()
        (at / file).write_text(text)
        begin = time.monotonic()
        code, err = self.run(*words, at=at)
        if code != OK:
            raise SystemExit(f"faults: the undisturbed {words[0]} failed ({code}): {err}")
        return at, (name, (at / "out" / name).read_bytes()), time.monotonic() - begin

    def kills(self):
        self.trial("a campaign is killed (kill -9) up to three times", "the same command leaves the table of the reference", 50,
                   self.killed("plan.toml", PLAN, CAMPAIGN, ("results.csv", self.table), self.seconds))

    def copy_of_reference(self):
        at = self.place()
        shutil.rmtree(at)
        shutil.copytree(self.reference, at)
        return at

    def damaged_runs(self):
        def one_of(file, kinds):
            def one():
                at = self.copy_of_reference()
                name = self.random.choice(self.names)
                path = at / "out" / "runs" / name / file
                how = self.damage(path, kinds)
                code, err = self.campaign(at)
                problem = self.crash(code, err)
                if not problem and code not in (OK, FAILED):
                    problem = f"the campaign ended with {code}: {err[-300:]}"
                rows = (at / "out" / "results.csv").read_bytes().splitlines() if not problem else []
                if not problem and any(row != other for run, row, other in zip(["", *self.names], rows, self.table.splitlines()) if run not in ("", name)):
                    problem = "the row of another run differs"
                if not problem and code == FAILED and file not in err:
                    problem = f"{file} is not named: {err[-300:]}"
                if not problem and code == FAILED:
                    if path.is_dir() and not path.is_symlink():
                        path.rmdir()
                    else:
                        path.unlink(missing_ok=True)
                    code, err = self.campaign(at)
                    problem = self.crash(code, err) or ("" if code == OK else f"exit {code} after {file} was deleted: {err[-300:]}")
                problem = problem or self.table_differs(at)
                shutil.rmtree(at)
                return problem and f"{file}, {how}: {problem}"

            return one

        text = ("cut off", "not UTF-8", "folder", "loop of links", "nested")
        for file, number, kinds in (("attempts.json", 40, (*text, "wrong type", "wrong type", "wrong type", "missing")),
                                    ("results.json", 25, text), ("case.toml", 15, (*text, "bytes", "missing")), ("series.csv", 10, (*text, "bytes", "missing"))):
            self.trial(f"{file} of a finished run is damaged", "the failure of that run alone, which names the file; then the reference", number,
                       one_of(file, kinds))

    def damaged_plans(self):
        good = "name,numerics.cell_size_m,numerics.cfl,title\na,0.5,0.2,one\nb,0.25,0.4,two\n"

        def one():
            at = self.place()
            (at / "plan.toml").write_text(PLAN.split("[parameters]")[0].replace("base =", 'table = "rows.csv"\nbase ='))
            (at / "rows.csv").write_text(good)
            (at / "precious").write_text("precious")
            file = self.random.choice(("rows.csv", "plan.toml"))
            how = self.damage(at / file, ("cut off", "bytes", "not UTF-8", "line", "folder", "loop of links", "device without end"))
            code, err = self.run("campaign", "run", "plan.toml", "--out", "out", at=at, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30)))
            problem = self.crash(code, err) or ("the message names no file" if code in (USAGE, IO) and file not in err else "")
            outside = {path.name for path in at.iterdir()} - {"plan.toml", "rows.csv", "precious", "out"}
            problem = problem or (f"written outside of the folder: {outside}" if outside else "")
            shutil.rmtree(at)
            return problem and f"{file}, {how}: {problem}"

        self.trial("a plan or its table is damaged", "exit 2 or 4 with the file, or a campaign of what is left of it", 35, one)

        def bad_name():
            at = self.copy_of_reference()
            name = self.random.choice((".", "..", "--help", "-x", "../up", "a/b", "x" * 300, ".lock", "a\x07b"))
            (at / "rows.csv").write_text(f'name,numerics.cell_size_m\n"{name}",0.5\n')
            (at / "plan.toml").write_text(PLAN.split("[parameters]")[0].replace("base =", 'table = "rows.csv"\nbase ='))
            before = sorted(str(path) for path in at.rglob("*"))
            code, err = self.campaign(at)
            after = sorted(str(path) for path in at.rglob("*"))
            problem = "" if code == USAGE and "names no folder" in err and before == after else f"{name}: exit {code}, {err[-300:]}"
            shutil.rmtree(at)
            return problem

        self.trial("a run with a name that is none", "exit 2, nothing written", 8, bad_name)

    def other_plans(self):
        def one():
            at = self.copy_of_reference()
            (at / "plan.toml").write_text(PLAN + self.random.choice(('[set]\n"material.poisson_ratio" = 0.3\n', '[set]\n"output.duration_s" = 0.03\n')))
            code, err = self.campaign(at)
            problem = self.crash(code, err) or ("" if code == OK else f"exit {code}: {err[-300:]}")
            (at / "plan.toml").write_text(PLAN)
            code, err = self.campaign(at)
            problem = problem or self.crash(code, err) or self.table_differs(at) or ("computed again" if "started" in err else "")
            shutil.rmtree(at)
            return problem

        self.trial("a key of the plan is changed and changed back", "the finished runs are kept and found again", 8, one)

        def own_file():
            at = self.place()
            file, text, words = self.random.choice((("case.toml", CASE, ("run", "case.toml")), ("plan.toml", PLAN, ("campaign", "run", "plan.toml")),
                                                    ("site.toml", SITE, ("design", "site.toml", "--quick"))))
            (at / file).write_text(text)
            code, err = self.run(*words, "--out", ".", at=at)
            return "" if code == USAGE and (at / file).read_text() == text and len(list(at.iterdir())) == 1 else f"{file}: exit {code}, {err[-300:]}"

        self.trial("--out is the folder of the user's own file", "exit 2, the file is as it was", 6, own_file)

    def designs(self):
        words = ("design", "site.toml", "--out", "out")
        at, table, seconds = self.undisturbed("site.toml", SITE, words, "design.json")
        self.trial("a design is killed (kill -9) up to twice", "the same command leaves the design.json of the reference", 14,
                   self.killed("site.toml", SITE, words, table, seconds, most=2))

        def other_site():
            (at / "site.toml").write_text(SITE.replace(*self.random.choice((("= 3.0", "= 3.5"), ("depth_m = 1.0", "depth_m = 1.2"), ("= 0.6", "= 0.7"),
                                                                            ("slope = 0.4", "slope = 0.5")))))
            names = ("design_plan.json", "site.toml", "design.html", "design.json")
            kept = [(at / "out" / name).read_bytes() for name in names]
            code, err = self.run(*words, "--page", at=at)
            same = kept == [(at / "out" / name).read_bytes() for name in names]
            return "" if code == IO and "not finished for this site" in err and same else f"exit {code}, {err[-300:]}"

        self.trial("the page of another site than that of the runs", "exit 4, nothing written", 4, other_site)

    def studies(self):
        words = ("converge", "case.toml", "--cell-size", "0.5,0.25", "--metric", "steps", "--threads", "1", "--out", "out")
        _, table, seconds = self.undisturbed("case.toml", CASE, words, "converge.csv")
        self.trial("a grid study is killed (kill -9) up to three times", "the same command leaves the converge.csv of the reference", 20,
                   self.killed("case.toml", CASE, words, table, seconds))

    # --- locks, streams, links ---
    def without_locks(self):
        library = compile_failing_calls(self.folder)
        reasons = [38, 37, 95]  # ENOSYS, ENOLCK, EOPNOTSUPP

        def one():
            at = self.place()
            (at / "case.toml").write_text(CASE)
            no_locks = {"LD_PRELOAD": str(library), "FLOCK_FAILS": str(self.random.choice(reasons))}
            owner = at / "out" / ".lock.owner"
            other = self.random.choice(("nobody", "ended", "here", "elsewhere"))
            if other != "nobody":
                process = subprocess.Popen(["sleep", "60"])
                if other == "ended":
                    process.kill()
                    process.wait()
                owner.parent.mkdir()
                owner.write_text(f"{'far.away' if other == 'elsewhere' else os.uname().nodename} {process.pid}")
            code, err = self.run("run", "case.toml", "--threads", 1, "--out", "out", at=at, environment=no_locks)
            if other != "nobody":
                process.kill()
                process.wait()
            if other in ("here", "elsewhere"):
                return "" if code == IO and ".lock.owner" in err and not (at / "out" / "series.csv").exists() else f"{other}: exit {code}, {err[-300:]}"
            return "" if code == OK and "has no locks" in err and not owner.exists() else f"{other}: exit {code}, {err[-300:]}"

        self.trial("a file system without flock; nobody, an ended or a live process has the folder", "runs and says so, or is refused with the owner's file", 16, one)

        def race():
            at = self.place()
            (at / "case.toml").write_text(CASE)
            ended = subprocess.Popen(["true"])
            ended.wait()
            (at / "out").mkdir()
            (at / "out" / ".lock.owner").write_text(f"{os.uname().nodename} {ended.pid}")
            environment = {**self.environment, "LD_PRELOAD": str(library), "FLOCK_FAILS": str(self.random.choice(reasons))}
            command = [self.mpm, "run", "case.toml", "--threads", "1", "--set", "output.duration_s=0.2", "--out", "out", "--force"]
            together = [subprocess.Popen(command, cwd=at, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                        for _ in range(6)]
            codes = sorted(process.wait(PATIENCE) for process in together)
            starts = (at / "out" / "run.log").read_text().count("start: ")
            left = [path.name for path in (at / "out").glob(".lock.*")]
            # one after another may have it, never two together: each then begins run.log anew
            return "" if set(codes) <= {OK, IO} and OK in codes and starts == 1 and not left else f"exits {codes}, {starts} starts, left {left}"

        self.trial("six processes without flock find the lock file of a process that has ended", "one runs, the others are refused", 12, race)

        def campaign():
            at = self.place()
            (at / "plan.toml").write_text(PLAN)
            code, err = self.run("campaign", "run", "plan.toml", "--out", "out", at=at,
                                 environment={"LD_PRELOAD": str(library), "FLOCK_FAILS": str(self.random.choice(reasons))})
            return self.crash(code, err) or self.table_differs(at) or ("" if "has no locks" in err else f"says nothing: {err[-300:]}")

        self.trial("a campaign on a file system without flock", "the reference", 4, campaign)

    def streams_and_links(self):
        whole = self.place()
        (whole / "case.toml").write_text(CASE)
        self.run("run", "case.toml", "--threads", 1, "--out", "out", at=whole)

        def closed():
            at = self.place()
            (at / "case.toml").write_text(CASE)
            streams = self.random.sample(range(3), self.random.randrange(1, 4))
            code = subprocess.run(["sh", "-c", f"exec '{self.mpm}' run case.toml --threads 1 --out out " + " ".join(("<&-", ">&-", "2>&-")[i] for i in streams)],
                                  cwd=at, env=self.environment, check=False).returncode
            same = all((at / "out" / name).read_bytes() == (whole / "out" / name).read_bytes() for name in ("series.csv", "final.h5", "case.toml"))
            return "" if same and code == (IO if 1 in streams else OK) else f"closed {streams}: exit {code}, same: {same}"

        self.trial("standard streams are closed", "the same files; exit 4 if the results had nowhere to go", 8, closed)

        def link():
            at = self.place()
            (at / "case.toml").write_text(CASE)
            (at / "victim").write_text("precious")
            (at / "out").mkdir()
            name = self.random.choice(("run.log", ".lock"))
            (at / "out" / name).symlink_to(at / "victim")
            code, err = self.run("run", "case.toml", "--threads", 1, "--out", "out", at=at)
            return "" if code == IO and name in err and (at / "victim").read_text() == "precious" else f"{name}: exit {code}, {err[-300:]}"

        self.trial("a file of the folder is a link to another file", "exit 4, the other file is as it was", 4, link)

    # --- Python ---
    def mpmtools(self, *words):
        """(exit code, messages) of `python3 -m mpmtools`, in a child of this process, where all is imported already."""
        from mpmtools.__main__ import main

        messages = self.folder / "messages"
        child = os.fork()
        if child == 0:
            code = 99
            with open(messages, "w", encoding="utf-8", errors="replace") as err, contextlib.redirect_stderr(err), contextlib.redirect_stdout(io.StringIO()):
                try:
                    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
                    signal.alarm(int(PATIENCE))
                    code = main([str(word) for word in words])
                except SystemExit as end:
                    code = end.code
                except BaseException as error:  # noqa: BLE001  (what a user would see as a traceback)
                    print(f"Traceback: {type(error).__name__}: {error}", file=err)
            os._exit(code)
        status = os.waitpid(child, 0)[1]
        return os.waitstatus_to_exitcode(status), messages.read_text(encoding="utf-8")

    def python_readers(self):
        import test_avaframe
        import test_commands
        import test_design
        import test_scale
        import test_view
        from mpmtools import campaign, grid_study  # noqa: F401  (imported once, before the children)
        from mpmtools.design import page  # noqa: F401
        from mpmtools.figures import run_pictures, view_page  # noqa: F401
        from mpmtools.fit import text as fit_text  # noqa: F401

        samples = []

        def sample(made):
            made.setUp()
            samples.append(made)
            return made.folder

        design, view, avalanche = sample(test_design.DesignFolder()), sample(test_view.ViewFolder()), sample(test_avaframe.Avalanche())
        ranks = pathlib.Path(sample(test_scale.Scale()))
        samples[-1].counts([test_scale.RANK, test_scale.RANK])
        table = self.place()
        (table / "results.csv").write_text(test_commands.synthetic_table(0.08))
        text, binary = ("cut off", "bytes", "not UTF-8", "folder", "loop of links", "missing"), ("cut off", "bytes", "folder")
        json_file = (*text, "wrong type", "wrong type", "wrong type", "nested")
        readers = [("fit", table, ("{}/results.csv",), [("results.csv", (*text, "line", "device without end"))], 12),
                   ("plot", view, ("{}",), [("case.toml", (*text, "line")), ("series.csv", (*text, "line", "device without end")), ("obstacle.json", json_file),
                                            ("results.json", json_file), ("frames/00001.h5", binary)], 25),
                   ("view", view, ("{}",), [("case.toml", (*text, "line")), ("obstacle.json", json_file), ("frames/00001.h5", binary)], 20),
                   ("design", design, ("{}",), [("design_plan.json", json_file), ("runs/soft_w11/results.json", json_file), ("runs/soft_w11/case.toml", (*text, "line")),
                                                ("runs/firm_w3/series.csv", (*text, "line")), ("runs/firm_w11/profiles.h5", binary)], 25),
                   ("scale", ranks / "run", ("{}",), [("ranks.json", json_file)], 12),
                   ("import-avaframe", avalanche, ("{}", "--at", "1100,2050", "--out", "{}/case"),
                    [("Inputs/dem.asc", (*text, "line")), ("Outputs/com1DFA/peakFiles/timeSteps/rel1_null_dfa_FT_t7.00.asc", (*text, "line"))], 12)]
        for verb, folder, words, files, number in readers:
            def one():
                at = self.place()
                shutil.rmtree(at)
                shutil.copytree(folder, at)
                file, kinds = self.random.choice(files)
                if not (at / file).exists():
                    (at / file).write_text('{"steady": true, "runup_mean_m": 4.0, "pressure_height_mean_m": 3.0}')
                how = self.damage(at / file, kinds)
                code, err = self.mpmtools(verb, *(word.format(at) for word in words))
                problem = self.crash(code, err) or ("the message names no file of the folder" if code not in (OK,) and str(at) not in err else "")
                shutil.rmtree(at)
                return problem and f"{file}, {how}: {problem}"

            self.trial(f"a file that mpmtools {verb} reads is damaged", "exit 0, 2 or 4 with the file, no traceback", number, one)
        for made in samples:
            made.doCleanups()

    def everything(self):
        self.compute_reference()
        self.kills()
        self.damaged_runs()
        self.damaged_plans()
        self.other_plans()
        self.designs()
        self.studies()
        self.without_locks()
        self.streams_and_links()
        self.python_readers()


def main():
    parser = argparse.ArgumentParser(description="What may happen to folders of campaigns and to files that Python reads, done on purpose.")
    parser.add_argument("--seed", type=int, default=1, help="of everything that is random (default: %(default)s)")
    parser.add_argument("--trials", type=int, default=300, help="about so many (default: %(default)s)")
    parser.add_argument("--mpm", type=pathlib.Path, default=ROOT / "build" / "release" / "bin" / "mpm", help="program (default: %(default)s)")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / "campaign_faults", help="folder of the tables (default: %(default)s)")
    arguments = parser.parse_args()
    faults, begin = Faults(arguments), time.monotonic()
    try:
        faults.everything()
    finally:
        shutil.rmtree(faults.folder, ignore_errors=True)
    return write_report(faults.rows, f"./run faults --campaigns --seed {arguments.seed} --trials {arguments.trials}", arguments.mpm, arguments.out,
                        time.monotonic() - begin)


if __name__ == "__main__":
    sys.exit(main())
