"""What the snow does to the heights: decomposition (Fig. 4), spreads of the means (Fig. 3), compaction (not in the paper)."""

import numpy as np
import pandas as pd

from analysis.statistics import ratio_of_means
from mpmtools.equations import bernoulli_height
from mpmtools.scores import levels, same_input

INCOMPRESSIBLE_XI = 5.0
LAST_LINK = (0.8, 0.3, 0.5)  # M, beta, xi at the end of the paper's chain
INERTIAL_FROUDE = 3.0  # below, the run-up is a pile


def decomposition(runs, last=LAST_LINK):
    """Heights of the links of a chain at every Froude number: M = beta = 0, xi = 5; then M; then beta; then xi. NaN: no such run."""
    slope, beta, xi = last
    chain = [(0.0, 0.0, INCOMPRESSIBLE_XI), (slope, 0.0, INCOMPRESSIBLE_XI), (slope, beta, INCOMPRESSIBLE_XI), last]
    froude = levels(runs.froude_number)
    links = pd.DataFrame([(f, bernoulli_height(f), link, *rheology) for f in sorted(froude.unique()) for link, rheology in enumerate(chain)],
                         columns=["froude_number", "bernoulli", "link", "critical_state_slope", "cohesion_beta", "hardening_xi"])
    used = runs[runs.at_reference_width]
    means = [used[_has(used, rheology)].groupby(froude)[["runup", "pressure_height"]].mean().assign(link=link)
             for link, rheology in enumerate(chain)]
    return links.merge(pd.concat(means).rename_axis("froude_number").reset_index(), "left", on=["froude_number", "link"])


def _has(runs, rheology):
    return np.logical_and.reduce([same_input(runs[name], value) for name, value in
                                  zip(("critical_state_slope", "cohesion_beta", "hardening_xi"), rheology)])


def spreads(runs):
    """Lowest and highest steady mean of all rheologies at each Froude number, over H; runs with w = H only."""
    used = runs[runs.at_reference_width]
    table = used.groupby(levels(used.froude_number)).agg(
        runs=("runup", "size"), runup_low=("runup", "min"), runup_high=("runup", "max"),
        pressure_height_low=("pressure_height", "min"), pressure_height_high=("pressure_height", "max"))
    table.insert(3, "runup_ratio", table.runup_high / table.runup_low)
    table["pressure_height_ratio"] = table.pressure_height_high / table.pressure_height_low
    return table.rename_axis("froude_number").reset_index()


def head_behind_shock(density_ratio):
    """Part of the velocity head v^2/(2g) that is left behind a standing normal shock which compacts the snow from rho_0 to chi rho_0:
    (2 chi - 1) / chi^2.

    Mass, v_1 = v / chi, and momentum, p_1 = rho_0 v^2 (1 - 1/chi), give the total head behind it, p_1 / (chi rho_0 g) + v_1^2 / (2 g).
    Plastic compaction takes the rest, (1 - 1/chi)^2, and the dense snow does not give it back.
    """
    return (2.0 * density_ratio - 1.0) / density_ratio**2


COMPACTION_COLUMNS = ["froude_number", "critical_state_slope", "cohesion_beta", "effective_friction", "hardening_xi", "compaction",
                      "stiff_compaction", "head", "head_standard_error", "behind_shock", "share", "share_standard_error"]


def compaction_losses(runs):
    """Runs against those of the least compressible snow of the same flow and strength (w = H).

    head: run-up above H over the other's, with its standard error. behind_shock: the same by head_behind_shock() of both. share: head
    times what the shock leaves of the other's.
    """
    usable = runs[runs.at_reference_width & np.isfinite(runs.runup) & np.isfinite(runs.compaction)].copy()
    keys = [levels(usable[name]) for name in ("froude_number", "critical_state_slope", "cohesion_beta")]
    stiffest = usable.loc[usable.groupby(keys).hardening_xi.transform("idxmax")].set_index(usable.index)
    usable["stiff_compaction"] = stiffest.compaction
    usable["head"], usable["head_standard_error"] = ratio_of_means(usable.runup - 1.0, usable.runup_standard_error, stiffest.runup - 1.0,
                                                                   stiffest.runup_standard_error)
    kept = head_behind_shock(stiffest.compaction)
    usable["behind_shock"] = head_behind_shock(usable.compaction) / kept
    usable["share"], usable["share_standard_error"] = usable["head"] * kept, usable.head_standard_error * kept
    return usable.loc[~same_input(stiffest.hardening_xi, usable.hardening_xi), COMPACTION_COLUMNS]


def compaction_curve(losses, steps=100):
    """head_behind_shock() up to the densest snow of the table."""
    chi = np.linspace(1.0, max(2.0, losses.compaction.max()) if len(losses) else 2.0, steps + 1)
    return pd.DataFrame({"compaction": chi, "share": head_behind_shock(chi)})


def compaction_summary(losses):
    """How well the shock explains the run-ups at Fr >= 3, without and with cohesion, for all xi (hardening_xi NaN) and for each: arithmetic
    means, rms of head - behind_shock, and rms_without_loss, that of head - 1: the shock explains something where the first is smaller."""
    fast = losses[losses.froude_number >= INERTIAL_FROUDE * (1.0 - 1e-6)]
    fast = fast.assign(cohesive=(fast.critical_state_slope * fast.cohesion_beta > 0.0).astype(int), hardening_xi=levels(fast.hardening_xi),
                       square=(fast["head"] - fast.behind_shock) ** 2, square_without_loss=(fast["head"] - 1.0) ** 2)
    parts = []
    for keys in (["cohesive"], ["cohesive", "hardening_xi"]):
        of = fast.groupby(keys).agg(runs=("head", "size"), mean_head=("head", "mean"), mean_behind_shock=("behind_shock", "mean"),
                                    rms=("square", "mean"), rms_without_loss=("square_without_loss", "mean")).reset_index()
        parts.append(of.assign(rms=np.sqrt(of.rms), rms_without_loss=np.sqrt(of.rms_without_loss)))
    whole, by_hardening = parts
    return pd.concat([whole.assign(hardening_xi=np.nan)[by_hardening.columns], by_hardening], ignore_index=True)


def compaction_lines(summary):
    """What was found, for the terminal."""
    return [f"compaction, Fr >= 3, {'with' if s.cohesive else 'without'} cohesion: {s.runs} runs keep {s.mean_head:.2f} of the head of the "
            f"least compressible snow; behind the shock {s.mean_behind_shock:.2f}, rms difference {s.rms:.2f}, without any loss "
            f"{s.rms_without_loss:.2f}" for s in summary[summary.hardening_xi.isna()].itertuples()]
