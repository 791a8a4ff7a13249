"""The texts of the study: numbers by name from tables, wrapped Markdown, and the check of both."""

import unittest

import numpy as np
import pandas as pd

from analysis import texts
from mpmtools.errors import InputError

TABLES = {"ratios": pd.DataFrame({"key": ["flip", "aflip"], "runup": [1.04, 0.996], "runup_low": [0.98, 0.9], "runup_high": [1.09, np.nan]})}


class Numbers(unittest.TestCase):
    def test_are_written_in_the_form_that_is_asked_for(self):
        for value, form, text in ((0.0414, "+%", "+4 %"), (-0.0414, "+.1%", "−4.1 %"), (0.0004, "+%", "0 %"), (-0.0004, "+.0%", "0 %"), (0.13, ".1%", "13.0 %"),
                                  (-1.25, ".1f", "−1.2"), (np.nan, ".2f", "–"), (-0.001, ".2f", "0.00")):
            self.assertEqual(texts.number(value, form), text)

    def test_come_from_a_table_by_name(self):
        values = texts.Values(TABLES)
        self.assertEqual(values.value("ratios", "flip", "runup"), "1.04")
        self.assertEqual(values.change("ratios", "flip", "runup"), "+4 % (−2 to +9 %)")
        self.assertEqual(values.span("ratios", "flip", "runup"), "−2 to +9 %")
        for key, column in (("pic", "runup"), ("flip", "force")):
            with self.assertRaisesRegex(InputError, f"tables/ratios.csv has no {column} of '{key}'"):
                values.value("ratios", key, column)

    def test_that_are_typed_are_found(self):
        self.assertEqual(texts.typed_numbers("It is 17 % higher at Fr 3, by 1.234 and −0.07."), ["17 %", "1.234", "−0.07"])
        allowed = 'At ξ = 0.5 and Fr 7 {{ value("ratios", "flip", "runup", "+.1%") }} (Sect. 4.1, Figs. 13, "about 13 %", `0.123`, [a](b1.23.md), A3.2, commit 69d28f4b).'
        self.assertEqual(texts.typed_numbers(allowed), [])


class Tables(unittest.TestCase):
    def test_round_off_is_no_difference_and_a_changed_number_is_named(self):
        fresh = texts.rounded(TABLES["ratios"])
        self.assertEqual(texts.differences(fresh, fresh.assign(runup=fresh.runup * (1.0 + 1e-5))), [])
        self.assertEqual(texts.differences(fresh, fresh.assign(runup=[1.05, 0.996])), ["runup of 'flip' is 1.05, the rows give 1.04"])
        self.assertEqual(len(texts.differences(fresh, fresh.iloc[:1])), 1)

    def test_have_five_digits(self):
        self.assertEqual(texts.rounded(pd.DataFrame({"a": [1.23456789, np.inf], "b": [7, 123456789]})).to_dict("list"), {"a": [1.2346, np.inf], "b": [7, 123456789]})

    def test_as_markdown_have_a_line_for_the_head(self):
        self.assertEqual(texts.markdown(["a", "b"], [["1", "2"]]), "| a | b |\n|---|---|\n| 1 | 2 |")


class Wrapped(unittest.TestCase):
    def test_paragraphs_and_items_are_and_tables_are_not(self):
        word = "word " * 30
        text = texts.wrapped(f"# {word}\n{word}\n- {word}\n10. {word}\n| {word}|\n```\n{word}\n```")
        lines = text.split("\n")
        self.assertEqual(len(lines), 1 + 2 + 2 + 2 + 1 + 3)
        self.assertTrue(lines[4].startswith("  word"))
        self.assertTrue(lines[6].startswith("    word"))

    def test_no_line_begins_with_a_percent_sign(self):
        for length in range(100, 125):
            self.assertNotIn("\n%", texts.wrapped("a" * length + " 12 % of all, and so on and on"))


if __name__ == "__main__":
    unittest.main()
