"""Figures that give their values under the pointer: what a page holds for them."""

import html
import json
import math
import re
import unittest

from reports import interactive
from mpmtools.figures.style import plt


def curves_of(svg):
    return json.loads(html.unescape(re.search(r"data-curves='(.*?)'", str(svg), flags=re.DOTALL)[1]))


class Curves(unittest.TestCase):
    def figure(self, scale="linear"):
        figure = plt.figure(figsize=(4.0, 2.0))
        axes = figure.add_axes((0.25, 0.5, 0.5, 0.25))  # points: x from 72 to 216, y from 36 to 72 below the upper edge
        axes.set(xlim=(0.0, 10.0), ylim=(1.0, 100.0), xlabel="time [s]", ylabel="force\n[N]", yscale=scale)
        return figure

    def test_have_their_places_in_the_figure(self):
        [curve] = curves_of(interactive.inline_svg(self.figure(), {}, "label", [interactive.Curve("ours", [0.0, 10.0], [1.0, 100.0])]))
        self.assertEqual(curve, {"name": "ours", "labels": ["time [s]", "force [N]"], "at": [720, 720, 2160, 360], "values": [0.0, 1.0, 10.0, 100.0]})

    def test_leave_out_what_has_no_place(self):
        curve = interactive.Curve("it's <ours>", [0.0, 5.0, 10.0, 10.0], [0.0, 10.0, math.nan, 100.0])
        [found] = curves_of(interactive.inline_svg(self.figure("log"), {}, "label", [curve]))
        self.assertEqual((found["name"], found["values"]), ("it's <ours>", [5.0, 10.0, 10.0, 100.0]))
        self.assertEqual(found["at"][:2], [1440, 540])

    def test_of_many_points_are_thinned(self):
        values = [0.01 * i for i in range(1001)]
        [curve] = curves_of(interactive.inline_svg(self.figure(), {}, "label", [interactive.Curve("long", values, values)]))
        self.assertLessEqual(len(curve["values"]), 2 * interactive.MOST_VALUES)
        self.assertEqual(len(curve["values"]), len(curve["at"]))

    def test_a_figure_without_curves_has_no_data(self):
        self.assertNotIn("data-curves", interactive.inline_svg(self.figure(), {}, "label"))


if __name__ == "__main__":
    unittest.main()
