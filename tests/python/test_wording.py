"""Counts and numbers in messages and tables."""

import unittest

import pandas as pd

from analysis import axes
from mpmtools.tables import csv_text, number_text
from mpmtools.wording import counted, verb
from reports import bench_dashboard


class Wording(unittest.TestCase):
    def test_a_noun_has_the_number_of_its_count(self):
        self.assertEqual([counted(n, "run") for n in (0, 1, 2, 1.0)], ["0 runs", "1 run", "2 runs", "1 run"])
        self.assertEqual([counted(n, "series", "series") for n in (1, 2)], ["1 series", "2 series"])
        self.assertEqual([verb(n, "is", "are") for n in (0, 1, 2)], ["are", "is", "are"])

    def test_a_large_count_keeps_its_digits(self):
        self.assertEqual(counted(1234567, "row"), "1234567 rows")

    def test_no_number_is_printed_as_negative_zero(self):
        self.assertEqual([number_text(x) for x in (-0.0, -0.5, -3.0)], ["0", "-0.5", "-3"])
        self.assertEqual(csv_text(pd.DataFrame({"force_n": [-0.0, 1.0]})), "force_n\n0\n1\n")
        for shown in (axes.number(-0.0), axes.number(-0.0004), axes.per_cent(-0.0), axes.per_cent(-0.0004), bench_dashboard.per_cent(1.0 - 1e-6)):
            self.assertNotIn("-", shown)
        self.assertEqual((axes.number(-0.5), axes.per_cent(-0.5)), ("-0.500", "-50.0 %"))


if __name__ == "__main__":
    unittest.main()
