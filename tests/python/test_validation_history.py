"""What counts as a change for the worse in the history of the validation suite, and the page that shows it."""

import pathlib
import tempfile
import unittest

from reports.validation_history import draw_history_page, read_history

HEADER = "date,commit,version,machine,threads,level,case,kind,quantity,value,error,verdict\n"
DATES = ("2026-01-01T00:00:00Z", "2026-01-02T00:00:00Z")


class ValidationHistory(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.file = pathlib.Path(self.folder.name) / "history.csv"

    def history(self, *rows, machine=("m", "m")):
        """Rows (case, kind, quantity, (value, verdict) of the first recording, the same of the second)."""
        text = HEADER
        for i, date in enumerate(DATES):
            for case, kind, quantity, *pairs in rows:
                value, verdict = pairs[i]
                text += f'{date},c{i},1,{machine[i]},2,standard,{case},{kind},"{quantity}",{value},,{verdict}\n'
        self.file.write_text(text, encoding="utf-8")
        return self.file

    def worse(self, *rows, **options):
        table = read_history(self.history(*rows, **options))
        return list(table[table.worse].quantity)

    def test_a_check_that_fails_now_is_worse(self):
        self.assertEqual(self.worse(("a", "check", "x", (0.99, "ok"), (1.01, "FAILED"))), ["x"])

    def test_a_verdict_between_ok_and_failed_is_worse_than_ok_and_better_than_failed(self):
        self.assertEqual(self.worse(("a", "check", "now not met", (0.99, "ok"), (1.01, "not met")), ("a", "check", "now fails", (1.1, "not met"), (1.1, "FAILED")),
                                    ("a", "check", "known now", (1.1, "FAILED"), (1.4, "not met")), ("a", "check", "as it was", (1.1, "not met"), (1.1, "not met"))),
                         ["now not met", "now fails"])
        table = read_history(self.file)
        self.assertEqual(list(table[table.better].quantity), ["known now"])

    def test_an_error_that_grows_is_worse_only_where_it_matters(self):
        self.assertEqual(self.worse(("a", "check", "large", (0.3, "ok"), (0.4, "ok")), ("a", "check", "round-off", (1e-9, "ok"), (1e-3, "ok")),
                                    ("a", "check", "a little", (0.80, "ok"), (0.85, "ok"))), ["large"])

    def test_a_smaller_error_is_better(self):
        table = read_history(self.history(("a", "check", "x", (0.4, "ok"), (0.3, "ok")), ("a", "check", "y", (1.4, "FAILED"), (0.9, "ok"))))
        self.assertEqual(list(table[table.better].quantity), ["x", "y"])
        self.assertFalse(table.worse.any())

    def test_orders_biases_and_spreads(self):
        rows = [("a", "order", "falls", (2.0, ""), (1.8, "")), ("a", "order", "rises", (1.8, ""), (2.0, "")),
                ("", "bias", "force", (1.01, ""), (0.97, "")), ("", "bias", "run-up", (0.9, ""), (1.05, "")),
                ("", "spread", "force", (0.05, ""), (0.06, "")), ("", "spread", "speed", (0.001, ""), (0.002, ""))]
        self.assertEqual(sorted(self.worse(*rows)), ["falls", "force", "force"])

    def test_times_of_one_machine_are_compared(self):
        row = ("a", "time", "wall time", (10.0, "ok"), (20.0, "ok"))
        self.assertEqual(self.worse(row), ["wall time"])
        self.assertEqual(self.worse(row, machine=("m", "another")), [])

    def test_checks_of_one_name_are_kept_apart(self):
        rows = [("a", "check", "same name", (0.2, "ok"), (0.2, "ok")), ("a", "check", "same name", (0.8, "ok"), (0.8, "ok"))]
        self.assertEqual(self.worse(*rows), [])

    def test_the_page_names_what_became_worse(self):
        page = pathlib.Path(self.folder.name) / "history.html"
        file = self.history(("a", "check", "pressure & force", (0.3, "ok"), (1.4, "FAILED")), ("a", "time", "wall time", (1.0, "ok"), (1.0, "ok")))
        self.assertEqual(draw_history_page(file, page), 1)
        text = page.read_text(encoding="utf-8")
        self.assertIn("1 change for the worse", text)
        self.assertIn("pressure &amp; force", text)
        self.assertNotIn("http://", text.replace("http://www.w3.org", ""))

    def test_the_page_tells_not_met_from_failed(self):
        page = pathlib.Path(self.folder.name) / "history.html"
        draw_history_page(self.history(("a", "check", "x", (0.9, "ok"), (1.4, "not met")), ("a", "check", "y", (1.2, "not met"), (1.4, "FAILED"))), page)
        text = page.read_text(encoding="utf-8")
        self.assertIn("1.4 (not met)", text)
        self.assertIn("1.2 (not met)", text)
        self.assertIn("1.4 (FAILED)", text)

    def test_a_level_without_recordings_is_an_error(self):
        with self.assertRaises(ValueError):
            draw_history_page(self.history(("a", "check", "x", (0.1, "ok"), (0.1, "ok"))), "unused.html", "full")


if __name__ == "__main__":
    unittest.main()
