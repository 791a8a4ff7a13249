"""`python3 -m mpmtools scale`: the model against a case computed by hand, and what it must do at its limits."""

import json
import os

from mpmtools import scale
from mpmtools.errors import MpmError
from study_samples import InFolder

RANK = {"steps": 100, "particle_steps": 100 * 1000, "neighbour_steps": 100, "part_bytes": 100 * 60000, "node_bytes": 100 * 30000,
        "migrant_bytes": 100 * 10000, "sum_bytes": 100 * 500}


class Scale(InFolder):
    def counts(self, ranks):
        os.makedirs(os.path.join(self.folder, "run"), exist_ok=True)
        with open(os.path.join(self.folder, "run", "ranks.json"), "w", encoding="utf-8") as file:
            json.dump({"ranks": ranks}, file)
        return os.path.join(self.folder, "run")

    def test_counts_are_those_of_a_step_and_a_rank(self):
        counts = scale.read_counts(self.counts([{**RANK, "sum_bytes": 0}, RANK]))
        self.assertEqual(counts["particles_a_rank"], 1000)
        self.assertEqual(counts["bytes_a_rank"], 100000)
        self.assertAlmostEqual(counts["surface_bytes"], 1000)  # 100000 / 1000^(2/3)
        self.assertAlmostEqual(counts["sum_bytes"], 0.5)
        self.assertEqual(counts["imbalance"], 1)

    def test_a_step_by_hand(self):
        counts = {"surface_bytes": 1000.0, "neighbours": 1, "sum_bytes": 0.5}
        network = scale.Network(latency=1e-6, bandwidth=1e10, message=1e-6)
        t = scale.step_times(counts, 8e6, 8, 1e7, network)
        self.assertAlmostEqual(t["compute"], 0.1)
        self.assertAlmostEqual(t["neighbours"], 21e-6 + 1e3 * 1e4 / 1e10)  # 3 messages to each of 7; 1e6^(2/3) = 1e4
        self.assertAlmostEqual(t["agreement"], 2 * scale.TREE * 3e-6)
        self.assertAlmostEqual(t["sums"], scale.GATHERS * 7e-6 + 3.5e6 / 1e10)
        self.assertAlmostEqual(scale.efficiency(t), 0.1 / (0.1 + t["neighbours"] + t["agreement"] + t["sums"]))

    def test_one_rank_loses_nothing_and_more_ranks_lose_more(self):
        counts = {"surface_bytes": 1000.0, "neighbours": 1, "sum_bytes": 0.5}
        network = scale.Network(1e-6, 1e10, 1e-6)
        values = [scale.efficiency(scale.step_times(counts, 1e8, ranks, 1e7, network)) for ranks in (1, 64, 256, 1024, 4096)]
        self.assertEqual(values[0], 1.0)
        self.assertEqual(values, sorted(values, reverse=True))

    def test_a_file_that_is_no_count_is_refused(self):
        for ranks in ([RANK], [], [{"steps": 3}, {"steps": 3}]):
            with self.assertRaises(MpmError):
                scale.read_counts(self.counts(ranks))
        with self.assertRaises(MpmError):
            scale.read_counts(os.path.join(self.folder, "nowhere"))
