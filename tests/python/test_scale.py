"""`python3 -m mpmtools scale`: the model against a case computed by hand, and what it must do at its limits."""

import json
import os

from mpmtools import scale
from mpmtools.errors import MpmError
from study_samples import InFolder

STEPS = 100
RANK = {"steps": STEPS, "particle_steps": STEPS * 27000, "block_steps": STEPS * 64, "border_block_steps": STEPS * 32,
        "neighbour_steps": STEPS, "messages": STEPS * 5,
        "part_bytes": STEPS * 60000, "node_bytes": STEPS * 30000, "migrant_bytes": STEPS * 6000, "exchanges": 10, "reductions": STEPS * 5,
        "reduced_bytes": STEPS * 2000, "gathers": STEPS, "gathered_bytes": STEPS * 500}
COUNTS = {"ranks": 2, "particles": 5e5, "particles_a_block": 1000.0, "surface": 2.0, "bytes_a_border_block": 3000.0,
          "messages_a_neighbour": 5.0, "overlapping": 0.9, "reductions": 5.0, "reduced_bytes": 2000.0, "gathers": 1.0, "gathered_bytes": 500.0}


class Scale(InFolder):
    def counts(self, ranks):
        os.makedirs(os.path.join(self.folder, "run"), exist_ok=True)
        with open(os.path.join(self.folder, "run", "ranks.json"), "w", encoding="utf-8") as file:
            json.dump({"ranks": ranks}, file)
        return os.path.join(self.folder, "run")

    def test_counts_are_those_of_a_step_and_a_rank(self):
        counts = scale.read_counts(self.counts([{**RANK, "gathered_bytes": 0}, RANK]))
        self.assertEqual(counts["particles"], 27000)
        self.assertEqual(counts["particles_a_block"], 27000 / 64)
        self.assertEqual(counts["bytes"], 96000)
        self.assertEqual(counts["bytes_a_border_block"], 3000)
        self.assertAlmostEqual(counts["surface"], 2)  # 32 / 64^(2/3)
        self.assertEqual(counts["border_share"], 0.5)
        self.assertEqual((counts["messages"], counts["reductions"], counts["reduced_bytes"]), (5, 5, 2000))
        self.assertEqual((counts["neighbours"], counts["messages_a_neighbour"], counts["overlapping"]), (1, 5, 90 / 96))
        self.assertEqual((counts["gathers"], counts["gathered_bytes"]), (1, 500))
        self.assertEqual(counts["imbalance"], 1)

    def test_a_step_by_hand(self):
        network = scale.Network(latency=1e-6, bandwidth=1e10)
        t = scale.step_times(COUNTS, 8e6, 8, 1e7, network)  # 1e6 particles and 1000 blocks a rank, 200 of them at a border
        self.assertAlmostEqual(t["compute"], 0.1)
        self.assertAlmostEqual(t["neighbours"], 35e-6 + 200 * 3000 / 1e10)  # 5 messages to each of 7
        self.assertAlmostEqual(t["agreement"], 3 * (12e-6 + 4000 / 1e10) + 3 * (1e-6 + 16 / 1e10))
        self.assertAlmostEqual(t["gathers"], 3e-6 + 1000 / 1e10)  # eight times the particles: twice the rows
        self.assertAlmostEqual(scale.efficiency(t), 0.1 / (0.1 + t["neighbours"] + t["agreement"] + t["gathers"]))
        self.assertAlmostEqual(t["hidden"], 0.9 * 200 * 3000 / 1e10)
        self.assertGreater(scale.efficiency(t, overlapped=True), scale.efficiency(t))

    def test_no_more_time_is_hidden_than_inner_blocks_take(self):
        slow = scale.Network(latency=0.0, bandwidth=1e3)
        t = scale.step_times(COUNTS, 8e6, 8, 1e7, slow)
        self.assertAlmostEqual(t["hidden"], 0.8 * t["compute"])  # 200 of 1000 blocks are at a border

    def test_not_more_blocks_are_at_a_border_than_there_are(self):
        network = scale.Network(latency=0.0, bandwidth=1.0)
        self.assertAlmostEqual(scale.step_times(COUNTS, 64 * 2000, 64, 1.0, network)["neighbours"], 2 * 3000)

    def test_one_rank_loses_nothing_and_more_ranks_lose_more(self):
        network = scale.Network(1e-6, 1e10)
        values = [scale.efficiency(scale.step_times(COUNTS, 1e8, ranks, 1e7, network)) for ranks in (1, 64, 256, 1024, 4096)]
        self.assertEqual(values[0], 1.0)
        self.assertEqual(values, sorted(values, reverse=True))

    def test_a_file_that_is_no_count_is_refused(self):
        for ranks in ([RANK], [], [{"steps": 3}, {"steps": 3}]):
            with self.assertRaises(MpmError):
                scale.read_counts(self.counts(ranks))
        with self.assertRaises(MpmError):
            scale.read_counts(os.path.join(self.folder, "nowhere"))

    def test_numbers_that_are_none_are_refused(self):
        folder = self.counts([RANK, RANK])
        for option, value in (("--particles", "nan"), ("--particles", "inf"), ("--ranks", "inf"), ("--ranks", "0"), ("--speed", "nan"), ("--speed", "0"),
                              ("--latency-us", "-1"), ("--bandwidth-gb-s", "0"), ("--bandwidth-gb-s", "fast")):
            code, _, err = self.command("scale", folder, option, value)
            self.assertEqual(code, 2, (option, value, err))
