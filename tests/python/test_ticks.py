"""Ticks of the reports' figures: round numbers whose labels do not overlap."""

import unittest

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from mpmtools.figures.style import nice_ticks, plain_ticks, short, tick_label


def labels(low, high):
    """Boxes of the visible tick labels of a logarithmic axis, in pixels."""
    figure, axes = plt.subplots(figsize=(6.2, 4.3))
    axes.plot([low, high], [1.0, 2.0])
    axes.set_xscale("log")
    plain_ticks(axes.xaxis, [low, high])
    figure.canvas.draw()
    left, right = axes.get_xlim()
    boxes = [t.label1.get_window_extent() for t in axes.xaxis.get_major_ticks() if left <= t.get_loc() <= right and t.label1.get_text()]
    plt.close(figure)
    return boxes


class Ticks(unittest.TestCase):
    def test_labels_do_not_overlap(self):
        for low in (5.67e-5, 3.3e-4, 1.0, 41.0):
            for ratio in (1.2, 1.5, 3.0, 8.0, 40.0, 99.0):
                with self.subTest(low=low, ratio=ratio):
                    boxes = labels(low, low * ratio)
                    self.assertGreaterEqual(len(boxes), 2)
                    for a, b in zip(boxes, boxes[1:]):
                        self.assertLess(a.x1, b.x0)

    def test_ticks_are_inside_and_few(self):
        self.assertEqual(nice_ticks(1.0, 10.0), [1.0, 3.0, 10.0])
        for ratio in (1.1, 2.5, 7.0, 99.0):
            ticks = nice_ticks(0.03, 0.03 * ratio)
            self.assertTrue(2 <= len(ticks) <= 6, ticks)
            self.assertTrue(all(0.03 <= t <= 0.03 * ratio for t in ticks), ticks)

    def test_numbers(self):
        self.assertEqual(tick_label(0.002), "0.002")
        self.assertEqual(tick_label(6e-5), r"$6\cdot10^{-5}$")
        self.assertEqual(short(-0.0), "0")


if __name__ == "__main__":
    unittest.main()
