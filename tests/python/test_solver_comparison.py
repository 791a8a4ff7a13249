"""The page that puts several solvers side by side."""

import json

from reports.solver_comparison import draw_comparison
from study_samples import InFolder


def check(quantity, value, used, verdict=None):
    return {"quantity": quantity, "unit": "m", "measure": "relative", "passed": used <= 1.0, "tolerance_used": used,
            "verdict": verdict or ("ok" if used <= 1.0 else "FAILED"),
            "text": {"value": value, "reference": "1", "error": f"{used} %", "tolerance": "1 %"}}


class SolverComparison(InFolder):
    def report(self, name, solver, *checks, case="block", level="quick"):
        (self.folder / name).mkdir()
        failed = sum(not k["passed"] for k in checks)
        results = {"solver": solver, "level": level, "version": "1", "commit": "c",
                   "cases": [{"name": case, "title": "A & B", "checks": checks, "checks_passed": len(checks) - failed, "checks_failed": failed}]}
        (self.folder / name / "results.json").write_text(json.dumps(results), encoding="utf-8")
        return self.folder / name

    def test_a_check_that_one_solver_fails_is_marked(self):
        page = self.folder / "page.html"
        draw_comparison([self.report("a", "", check("rise", "1.001", 0.1), check("of the scheme", "2", 0.5)), self.report("b", "numpy", check("rise", "1.02", 2.0))], page)
        text = page.read_text(encoding="utf-8")
        for part in ("libmpm: result", "numpy: result", "1.001", "1.02", "2.0 % FAILED", "A &amp; B"):
            self.assertIn(part, text)
        self.assertNotIn("of the scheme", text)  # only one of the two has it

    def test_a_target_that_is_known_not_to_be_met_is_no_failure(self):
        page = self.folder / "page.html"
        draw_comparison([self.report("a", "", check("rise", "1.02", 2.0, "not met")), self.report("b", "numpy", check("rise", "1.01", 0.9))], page)
        text = page.read_text(encoding="utf-8")
        self.assertIn("2.0 % not met", text)
        self.assertNotIn("FAILED", text)

    def test_reports_of_two_levels_are_refused(self):
        with self.assertRaises(ValueError):
            draw_comparison([self.report("a", "", check("rise", "1", 0.1)), self.report("b", "numpy", check("rise", "1", 0.1), level="full")], self.folder / "page.html")

    def test_a_shared_case_is_needed(self):
        with self.assertRaises(ValueError):
            draw_comparison([self.report("a", "", check("rise", "1", 0.1)), self.report("b", "numpy", check("rise", "1", 0.1), case="other")], self.folder / "page.html")
