"""How far a run divided among ranks would scale, from what one run counted (ranks.json).

Model of a step on P ranks with N particles, n = N/P on each:

    compute   t_c = n / speed
    neighbours  each rank sends b = a n^(2/3) bytes in 3 k messages; a and k from the counts, k at most 26
    agreement   TREE operations of all ranks, each up and down a tree of ceil(log2 P) messages
    sums        rank 0 receives GATHERS messages of each rank and s N bytes, s from the counts; one after another, nothing overlaps

    efficiency = t_c / (t_c + t_neighbours + t_agreement + t_sums)

Surface over volume: b follows the surface of a compact part. In a flat layer parts are columns and their surface falls as n^(1/2) only once
parts are wider than high; the exponent 2/3 is then low for few ranks and right for many. Ranks are taken as even; an imbalance divides the
efficiency by the largest load over the mean.
"""

import json
import math
import os

from mpmtools.errors import ConfigError, InputError

TREE = 6       # of a step: word of the first rank (2), largest speed, borders and load (2), and one for changed borders or cuts
GATHERS = 5    # of a step: mass, impulses, contacts, particles that left, and one at samples
MOST_NEIGHBOURS = 26


class Network:
    """Latency of a message, s; bandwidth of a rank's connection, byte/s; time in which rank 0 takes one more message, s."""

    def __init__(self, latency, bandwidth, message):
        self.latency, self.bandwidth, self.message = latency, bandwidth, message


def read_counts(folder):
    """Per step and rank: particles, bytes to neighbours, neighbours; over all: bytes of sums a particle and step, imbalance."""
    path = os.path.join(folder, "ranks.json")
    try:
        with open(path, encoding="utf-8") as file:
            ranks = json.load(file)["ranks"]
        steps = ranks[0]["steps"]
        if len(ranks) < 2 or steps < 1:
            raise InputError(f"{path}: a run of several ranks and at least one step is needed")
        particle_steps = [r["particle_steps"] for r in ranks]
        exchanged = [r["part_bytes"] + r["node_bytes"] + r["migrant_bytes"] for r in ranks]
        neighbours = max(r["neighbour_steps"] for r in ranks) / steps
        sums = sum(r["sum_bytes"] for r in ranks) / sum(particle_steps[1:])
    except (OSError, ValueError, KeyError, IndexError, TypeError, ZeroDivisionError) as error:
        raise InputError(f"{path}: cannot be read as the counts of a run by several ranks ({error})") from error
    mean = sum(particle_steps) / len(ranks) / steps
    return {"ranks": len(ranks), "particles_a_rank": mean, "bytes_a_rank": sum(exchanged) / len(ranks) / steps,
            "surface_bytes": max(b / steps / max(n / steps, 1.0) ** (2.0 / 3.0) for b, n in zip(exchanged, particle_steps)),
            "neighbours": neighbours, "sum_bytes": sums, "imbalance": max(particle_steps) / steps / mean}


def step_times(counts, particles, ranks, speed, network):
    """Times of one step in s. @param speed: particle-steps a second of one rank"""
    own = particles / ranks
    sent = counts["surface_bytes"] * own ** (2.0 / 3.0) if ranks > 1 else 0.0
    messages = 3 * min(MOST_NEIGHBOURS, ranks - 1)
    tree = math.ceil(math.log2(ranks)) if ranks > 1 else 0
    return {"compute": own / speed,
            "neighbours": messages * network.latency + sent / network.bandwidth,
            "agreement": 2 * TREE * tree * network.latency,
            "sums": GATHERS * (ranks - 1) * network.message + counts["sum_bytes"] * particles * (1.0 - 1.0 / ranks) / network.bandwidth,
            "bytes": sent, "messages": messages}


def efficiency(times):
    return times["compute"] / (times["compute"] + times["neighbours"] + times["agreement"] + times["sums"])


def report(folder, particle_numbers, rank_numbers, speed, network):
    counts = read_counts(folder)
    lines = [f"counted on {counts['ranks']} ranks of {counts['particles_a_rank']:.4g} particles: {counts['bytes_a_rank']:.4g} bytes a step and "
             f"rank to {counts['neighbours']:.2g} neighbours at most,",
             f"{counts['surface_bytes']:.4g} bytes for each (particles of a rank)^(2/3), {counts['sum_bytes']:.3g} bytes of sums a particle and "
             f"step, largest load {counts['imbalance']:.3g} of the mean",
             f"assumed: {speed / 1e6:.4g} million particle-steps/s of a rank, latency {network.latency * 1e6:.3g} us, "
             f"{network.bandwidth / 1e9:.4g} GB/s a rank, {network.message * 1e6:.3g} us for each message at rank 0; even load", "",
             f"{'particles':>10} {'ranks':>6} {'compute':>10} {'neighbours':>11} {'agreement':>10} {'sums':>10} {'MB sent':>8} {'messages':>9} {'efficiency':>11}"]
    for particles in particle_numbers:
        for ranks in rank_numbers:
            t = step_times(counts, particles, ranks, speed, network)
            times = " ".join(f"{1e3 * t[name]:>{width}.4g}" for name, width in (("compute", 10), ("neighbours", 11), ("agreement", 10), ("sums", 10)))
            lines.append(f"{particles:>10.3g} {ranks:>6} {times} {t['bytes'] / 1e6:>8.3g} {t['messages']:>9} {efficiency(t):>11.3f}")
    return "\n".join([*lines, "times in ms a step"])


def run_command(options):
    def numbers(text, kind, lowest):
        try:
            values = [kind(float(part)) for part in text.split(",")]
        except ValueError as error:
            raise ConfigError(f"'{text}' is not a list of numbers") from error
        if any(v < lowest for v in values):
            raise ConfigError(f"'{text}': {lowest} is the least that makes sense")
        return values

    network = Network(1e-6 * options.latency_us, 1e9 * options.bandwidth_gb_s, 1e-6 * options.message_us)
    print(report(options.directory, numbers(options.particles, float, 1), numbers(options.ranks, int, 1), 1e6 * options.speed, network))
