"""How far a run divided among ranks would scale, from what one run counted (ranks.json).

Model of a step on P ranks with N particles, n = N/P on each, m blocks with particles on each (as full as those of the run), T = ceil(log2 P):

    compute     t_c = n / speed
    neighbours  each rank sends q messages to each of at most 26 neighbours (parts, nodes and migrants; near an obstacle also nodes and parts
                for the correction of lumped masses), and b s m^(2/3) bytes; s m^(2/3) are its blocks at a border (surface over volume), b the
                bytes of a step for each; q, s and b as counted on the rank with most of them
    agreement   the first rank's word (two broadcasts), the counted reductions of a step with their bytes, each up and down a tree of T
                messages, and one exchange of who has news for whom, T messages with half of 4 P bytes each. A run counts such exchanges in
                the steps in which blocks at its borders came or went; with thousands of ranks that is every step, and is taken so
    gathers     rows that the first rank gets from a tree of ranks: T messages each, and all their bytes, one after another. These are rows
                of an obstacle's layers: their number grows as the resolution, N^(1/3)

    efficiency = t_c / (t_c + t_neighbours + t_agreement + t_gathers) if nothing overlaps
    overlapped   the same without the time in which the bytes of parts and nodes travel, as far as the blocks that are not at a border take
                 as long to compute: an upper bound, because the messages of the correction overlap only in part

Not in a step, and not in the model: frames, checkpoints, and what observers collect at samples. The load is taken as even; an imbalance divides
the efficiency by the largest load over the mean. In a flat layer wider than high the surface of parts grows as m^(1/2) and less: the exponent
2/3, fitted at the run's own m, is then high for larger parts and low for smaller ones.
"""

import math
import os
from typing import NamedTuple

from mpmtools.errors import ConfigError, InputError
from mpmtools.files import read_json

WORDS = 2  # broadcasts of the first rank
MOST_NEIGHBOURS = 26
NAMES = ("steps", "particle_steps", "block_steps", "border_block_steps", "neighbour_steps", "messages", "part_bytes", "node_bytes",
         "migrant_bytes", "exchanges", "reductions", "reduced_bytes", "gathers", "gathered_bytes")


class Network(NamedTuple):
    latency: float  # of a message, s
    bandwidth: float  # of a rank's connection, byte/s


def read_counts(folder):
    """Figures a step and rank; see the model. @throws InputError"""
    path = os.path.join(folder, "ranks.json")
    try:
        ranks = [{name: float(rank[name]) for name in NAMES} for rank in read_json(path)["ranks"]]
        if len(ranks) < 2 or ranks[0]["steps"] < 1:
            raise InputError(f"{path}: a run of several ranks and at least one step is needed")
        steps = ranks[0]["steps"]
        particles, blocks = (sum(r[name] for r in ranks) / len(ranks) / steps for name in ("particle_steps", "block_steps"))
        busy = [r for r in ranks if r["neighbour_steps"] > 0]  # with more ranks than blocks some have none
        exchanged = [r["part_bytes"] + r["node_bytes"] + r["migrant_bytes"] for r in busy]
        return {"ranks": len(ranks), "particles": particles, "blocks": blocks, "particles_a_block": particles / blocks,
                "imbalance": max(r["particle_steps"] for r in ranks) / steps / particles,
                "border_share": max(r["border_block_steps"] / r["block_steps"] for r in busy),
                "surface": max(r["border_block_steps"] / steps / (r["block_steps"] / steps) ** (2.0 / 3.0) for r in busy),
                "bytes": max(exchanged) / steps, "messages": max(r["messages"] for r in ranks) / steps,
                "neighbours": max(r["neighbour_steps"] for r in ranks) / steps,
                "messages_a_neighbour": max(r["messages"] / r["neighbour_steps"] for r in busy),
                "overlapping": min((r["part_bytes"] + r["node_bytes"]) / b for b, r in zip(exchanged, busy)),
                "bytes_a_border_block": max(b / r["border_block_steps"] for b, r in zip(exchanged, busy)),
                "exchanges": ranks[0]["exchanges"] / steps,
                "reductions": ranks[0]["reductions"] / steps, "reduced_bytes": ranks[0]["reduced_bytes"] / steps,
                "gathers": ranks[0]["gathers"] / steps, "gathered_bytes": sum(r["gathered_bytes"] for r in ranks) / steps}
    except (ValueError, IndexError, TypeError, ZeroDivisionError) as error:
        raise InputError(f"{path}: cannot be read as the counts of a run by several ranks ({error})") from error


def step_times(counts, particles, ranks, speed, network):
    """Times of one step in s. @param speed: particle-steps a second of one rank"""
    own = particles / ranks
    if ranks == 1:
        return {"compute": own / speed, "neighbours": 0.0, "agreement": 0.0, "gathers": 0.0, "hidden": 0.0, "bytes": 0.0, "messages": 0}
    blocks = own / counts["particles_a_block"]
    border = min(blocks, counts["surface"] * blocks ** (2.0 / 3.0))
    sent = counts["bytes_a_border_block"] * border
    messages = counts["messages_a_neighbour"] * min(MOST_NEIGHBOURS, ranks - 1)
    tree = math.ceil(math.log2(ranks))
    exchange = tree * (network.latency + 2 * ranks / network.bandwidth)
    gathered = counts["gathered_bytes"] * (particles / (counts["particles"] * counts["ranks"])) ** (1.0 / 3.0)
    return {"compute": own / speed,
            "neighbours": messages * network.latency + sent / network.bandwidth,
            "agreement": tree * ((WORDS + 2 * counts["reductions"]) * network.latency + 2 * counts["reduced_bytes"] / network.bandwidth) + exchange,
            "gathers": counts["gathers"] * tree * network.latency + gathered / network.bandwidth,
            "hidden": min(counts["overlapping"] * sent / network.bandwidth, (1.0 - border / blocks) * own / speed),
            "bytes": sent, "messages": messages}


def efficiency(times, overlapped=False):
    whole = sum(times[name] for name in ("compute", "neighbours", "agreement", "gathers"))
    return times["compute"] / (whole - (times["hidden"] if overlapped else 0.0))


def report(folder, particle_numbers, rank_numbers, speed, network):
    c = read_counts(folder)
    lines = [f"counted on {c['ranks']} ranks of {c['particles']:.4g} particles in {c['blocks']:.4g} blocks, a step and rank (the largest of all):",
             f"{c['bytes']:.4g} bytes in {c['messages']:.3g} messages to {c['neighbours']:.3g} neighbours, {c['messages_a_neighbour']:.3g} to each; "
             f"{100 * c['border_share']:.3g} % of the blocks at a border: "
             f"{c['surface']:.3g} blocks^(2/3), {c['bytes_a_border_block']:.4g} bytes for each",
             f"{c['reductions']:.3g} reductions of {c['reduced_bytes']:.4g} bytes in all, {c['exchanges']:.2g} exchanges of borders, "
             f"{c['gathers']:.3g} gathers of {c['gathered_bytes']:.4g} bytes in all at rank 0; largest load {c['imbalance']:.3g} of the mean",
             f"assumed: {speed / 1e6:.4g} million particle-steps/s of a rank, latency {network.latency * 1e6:.3g} us, "
             f"{network.bandwidth / 1e9:.4g} GB/s a rank; even load", "",
             f"{'particles':>10} {'ranks':>6} {'compute':>10} {'neighbours':>11} {'agreement':>10} {'gathers':>10} {'MB sent':>8} {'messages':>9} "
             f"{'efficiency':>11} {'overlapped':>11}"]
    for particles in particle_numbers:
        for ranks in rank_numbers:
            t = step_times(c, particles, ranks, speed, network)
            times = " ".join(f"{1e3 * t[name]:>{width}.4g}" for name, width in (("compute", 10), ("neighbours", 11), ("agreement", 10), ("gathers", 10)))
            lines.append(f"{particles:>10.3g} {ranks:>6} {times} {t['bytes'] / 1e6:>8.3g} {t['messages']:>9.3g} {efficiency(t):>11.3f} "
                         f"{efficiency(t, overlapped=True):>11.3f}")
    return "\n".join([*lines, "times in ms a step"])


def run_command(options):
    def numbers(text, kind, lowest):
        try:
            values = [kind(float(part)) for part in text.split(",")]
        except (ValueError, OverflowError) as error:
            raise ConfigError(f"'{text}' is not a list of numbers") from error
        if not all(lowest <= v < math.inf for v in values):
            raise ConfigError(f"'{text}': {lowest} is the least that makes sense")
        return values

    network = Network(1e-6 * options.latency_us, 1e9 * options.bandwidth_gb_s)
    print(report(options.directory, numbers(options.particles, float, 1), numbers(options.ranks, int, 1), 1e6 * options.speed, network))
