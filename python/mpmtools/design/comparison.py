"""What the guideline and the paper's equations give for the site."""

from typing import NamedTuple

from mpmtools import equations
from mpmtools.design.ensemble import across_flow, snow_cover
from mpmtools.design.rounding import UNKNOWN, number
from mpmtools.design.scaling import FITTED, FROUDE, GROWN, RUNS, drag_coefficient, is_fitted, unknown_snows, weight_factor

FLOOR = 0.7  # least width factor for w/H < 1 that the paper recommends (Sect. 5)
LAMBDAS = {"loose": (1.5,), "cold_dense": (2.0, 3.0), "warm_cohesive": (2.0, 3.0)}


def guideline_rows(plan):
    """[(what, value in m above the ground, source)] that do not depend on the snow's parameters."""
    flow, (width, _), base = plan["flow"], across_flow(plan), snow_cover(plan)
    height, speed, gravity = flow["depth_m"], flow["velocity_m_s"], flow["gravity_m_s2"]
    factor = float(equations.width_factor(width / height))
    limited = max(factor, FLOOR)
    rows = [("Bernoulli's bound of a flow without friction, H + v²/2g", height + speed**2 / (2.0 * gravity), "Eq. 1")]
    for dissipation in LAMBDAS.get(flow["snow_class"], (1.5, 2.0, 3.0)):
        rows.append((f"run-up by the guideline, λ = {dissipation:g}, f(w/H) = {factor:.2f}",
                     height + equations.guideline_runup(speed, dissipation, factor, gravity), "Eqs. 5, 6, and H"))
        if limited > factor:
            rows.append((f"the same with f not below {FLOOR}, as the paper recommends for w/H < 1",
                         height + equations.guideline_runup(speed, dissipation, limited, gravity), "Eq. 5, Sect. 5"))
    rows.append(("pressure height, conservative for all snows: 3 H", 3.0 * height, "Sect. 5"))
    return [(what, base + value, source) for what, value, source in rows]


DRAG_COEFFICIENTS = {"cylinder": 1.0, "box": 2.0}  # round and rectangular, as the Swiss rules of Salm, Burkard and Gubler (1990) are quoted
DRY = ("loose", "cold_dense")  # classes
HYDROSTATIC = 8.0  # times the hydrostatic pressure, measured in slow wet avalanches on a narrow pylon (Sovilla et al. 2010)


def span(low, high, digits=2):
    """With so many digits each; once where they are the same."""
    low, high = (number(value, f".{digits}g") for value in (low, high))
    return low if low == high else f"{low} to {high}"


def own_drag_source(plan):
    """(shape and regime, c_D, source, what was checked) of this program's study, a row of the page's table of drag coefficients."""
    froude, frictions = plan["flow"]["froude_number"], sorted(snow["effective_friction"] for snow in plan["snows"])
    beyond = f"this flow is beyond its Fr {FROUDE[0]:g} to {FROUDE[1]:g}" if not is_fitted(froude) else (
        f"beyond its M' {FITTED[0]:g} to {FITTED[1]:g}: {unknown}" if (unknown := unknown_snows(plan)) else "")
    ends = frictions[0], frictions[-1]
    own, weight = (UNKNOWN if beyond else span(*map(of, ends)) for of in (lambda m: drag_coefficient(m, froude), weight_factor))
    grown = f"; above its M' {FITTED[1]:g} about {GROWN:g} times that" if frictions[-1] > FITTED[1] * 1.001 else ""
    return (f"square, w = H, Fr {froude:.2g}, these M'", own, f"this program's study, {RUNS} runs: inertia and {weight} times the hydrostatic force",
            beyond or f"fitted within 12 % (root mean square){grown}")


class GuidelineLoad(NamedTuple):
    """One row of the guideline's load."""

    what: str
    extent: float  # m above ground, to which the load reaches
    force: float  # N
    moment: float  # N m, about the ground
    source: str


def guideline_drag(plan):
    """(c_D, where it comes from)"""
    given = plan["mast"].get("drag_coefficient")
    if given is not None:
        return given, "c_D of the site file"
    shape = plan["mast"]["shape"]
    return DRAG_COEFFICIENTS[shape], f"c_D = {DRAG_COEFFICIENTS[shape]:g} for a {shape}, as Salm, Burkard and Gubler (1990) are commonly quoted; check your edition"


def guideline_loads(plan):
    """F = c_D rho v^2/2 w H with three extents that are in use, and unless the snow is dry the measured multiple of the hydrostatic pressure."""
    flow, (width, _), base = plan["flow"], across_flow(plan), snow_cover(plan)
    depth, gravity = flow["depth_m"], flow["gravity_m_s2"]
    drag, source = guideline_drag(plan)
    line = drag * 0.5 * flow["density_kg_m3"] * flow["velocity_m_s"] ** 2 * width
    dissipation = LAMBDAS.get(flow["snow_class"], (1.5,))[0]
    rise = equations.guideline_runup(flow["velocity_m_s"], dissipation, max(float(equations.width_factor(width / depth)), FLOOR), gravity)
    rows = [GuidelineLoad("c_D ½ρv² w H, over the depth of the flow", depth, line * depth, 0.5 * line * depth**2, source),
            GuidelineLoad(f"the same, falling linearly to 0 over the run-up, H + v²f/(2gλ), λ = {dissipation:g}", depth + rise, line * (depth + 0.5 * rise),
                          line * (0.5 * depth**2 + 0.5 * rise * (depth + rise / 3.0)), "extent: Eqs. 5, 6; linear decrease: customary"),
            GuidelineLoad("c_D ½ρv² w over 3 H", 3.0 * depth, 3.0 * line * depth, 4.5 * line * depth**2, "extent: Sect. 5, conservative")]
    if flow["snow_class"] not in DRY:
        slow = HYDROSTATIC * flow["density_kg_m3"] * gravity * width
        rows.append(GuidelineLoad(f"slow wet snow: {HYDROSTATIC:g} times the hydrostatic pressure, whatever the speed", depth, 0.5 * slow * depth**2,
                                  slow * depth**3 / 6.0, "Sovilla et al. (2010), wet avalanches on a pylon"))
    return [row._replace(extent=base + row.extent, moment=row.moment + base * row.force) for row in rows]


def drag_remark(plan, lowest, highest):
    """What to know where the computed drag coefficient leaves the quoted range; empty: within. @param lowest, highest  of the snows"""
    drag, _ = guideline_drag(plan)
    low, high = min(drag, *DRAG_COEFFICIENTS.values()), max(drag, *DRAG_COEFFICIENTS.values())
    if not lowest < low and not highest > high:
        return ""
    which = f"above the {low:g} to {high:g}" if highest > high else f"below the {low:g} to {high:g}"
    wet = "" if plan["flow"]["snow_class"] in DRY else (
        "Wet avalanches have been measured to press considerably more than the guideline's formula gives (Sovilla et al., infoscience.epfl.ch record "
        "206442); in simulations of slow flows cohesion raises the pressure on narrow obstacles (Kyburz et al. 2022). ")
    reason = ("Part of the force acts above the flow, on snow that is dammed up, while the coefficient is over w H; cohesive and firm snow presses more. "
              f"{wet}No measurement confirms the computed value for this mast: take the larger load, or have the difference examined")
    return (f"The computed drag coefficient is {span(lowest, highest)} over the snows, {which} of the guideline (c_D = {drag:g} for this mast). "
            f"{reason if highest > high else 'Do not design with less than the guideline without a reason'}")


def equation_rows(plan):
    """[{name, runup_m, pressure_height_m}] by Eqs. 7 to 10 for each snow, above the ground."""
    flow, fits = plan["flow"], {"runup_m": equations.PUBLISHED_RUNUP, "pressure_height_m": equations.PUBLISHED_PRESSURE_HEIGHT}
    return [{"name": snow["name"], **{name: snow_cover(plan) + flow["depth_m"] * float(equations.relative_height(
        snow["effective_friction"], flow["froude_number"], fit)) for name, fit in fits.items()}} for snow in plan["snows"]]


def equation_remarks(plan):
    """What of this site the equations were not fitted to; each text once."""
    flow, (width, shape) = plan["flow"], across_flow(plan)
    remarks = []
    for snow in plan["snows"]:
        remarks += equations.outside_of_fit(width / flow["depth_m"], flow["froude_number"], shape, snow["effective_friction"],
                                            snow["hardening_xi"])
    return list(dict.fromkeys(remarks))


def known_uncertainty_remark(plan):
    """To which mast the known uncertainties of the grid belong, where that is not this one; empty: to one like this."""
    flow, (width, shape) = plan["flow"], across_flow(plan)
    ratio, different = width / flow["depth_m"], []
    if shape != "box":
        different.append("round" if shape == "cylinder" else "turned")
    if abs(ratio - 1.0) > 0.05:
        different.append(f"w/H = {ratio:.2f}")
    if not different:
        return ""
    force = ", for the force the larger of this and that of a cylinder in a plane jet" if shape == "cylinder" else ""
    return (f"This mast ({', '.join(different)}) has no grid study of its own: the known uncertainty is that of a square mast as wide as the flow "
            f"is deep (w = H, Fr 3, frictionless) with as many cells{force}. It may be larger here.")
