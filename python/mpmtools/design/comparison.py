"""What the guideline and the paper's equations give for the site."""

from mpmtools import equations

FLOOR = 0.7  # least width factor for w/H < 1 that the paper recommends (Sect. 5)
LAMBDAS = {"loose": (1.5,), "cold_dense": (2.0, 3.0), "warm_cohesive": (2.0, 3.0)}


def guideline_rows(plan):
    """[(what, value in m, source)] that do not depend on the snow's parameters."""
    flow, width = plan["flow"], plan["mast"]["width_m"]
    height, speed, gravity = flow["depth_m"], flow["velocity_m_s"], flow["gravity_m_s2"]
    head, ratio = speed**2 / (2.0 * gravity), width / flow["depth_m"]
    factor = float(equations.width_factor(ratio))
    limited = max(factor, FLOOR)
    rows = [("Bernoulli's bound of a flow without friction, H + v²/2g", height + head, "Eq. 1")]
    for dissipation in LAMBDAS.get(flow["snow_class"], (1.5, 2.0, 3.0)):
        rows.append((f"run-up by the guideline, λ = {dissipation:g}, f(w/H) = {factor:.2f}", height + head / dissipation * factor,
                     "Eqs. 5, 6, and H"))
        if limited > factor:
            rows.append((f"the same with f not below {FLOOR}, as the paper recommends for w/H < 1", height + head / dissipation * limited,
                         "Eq. 5, Sect. 5"))
    rows.append(("pressure height, conservative for all snows: 3 H", 3.0 * height, "Sect. 5"))
    return rows


def equation_rows(plan):
    """[{name, runup_m, pressure_height_m}] by Eqs. 7 to 10 for each snow."""
    flow = plan["flow"]
    height = flow["depth_m"]
    return [{"name": snow["name"],
             "runup_m": height * float(equations.relative_height(snow["effective_friction"], flow["froude_number"], equations.PUBLISHED_RUNUP)),
             "pressure_height_m": height * float(equations.relative_height(snow["effective_friction"], flow["froude_number"],
                                                                           equations.PUBLISHED_PRESSURE_HEIGHT))} for snow in plan["snows"]]


def equation_remarks(plan):
    """What of this site the equations were not fitted to; each text once."""
    flow, mast = plan["flow"], plan["mast"]
    remarks = []
    for snow in plan["snows"]:
        remarks += equations.outside_of_fit(mast["width_m"] / flow["depth_m"], flow["froude_number"], mast["shape"], snow["effective_friction"],
                                            snow["hardening_xi"])
    return list(dict.fromkeys(remarks))


def known_uncertainty_remark(plan):
    """To which mast the known uncertainties of the grid belong, where that is not this one; empty: to one like this."""
    flow, mast = plan["flow"], plan["mast"]
    ratio, different = mast["width_m"] / flow["depth_m"], []
    if mast["shape"] != "box":
        different.append("round")
    if abs(ratio - 1.0) > 0.05:
        different.append(f"w/H = {ratio:.2f}")
    if not different:
        return ""
    force = ", for the force the larger of this and that of a cylinder in a plane jet" if mast["shape"] != "box" else ""
    return (f"This mast ({', '.join(different)}) has no grid study of its own: the known uncertainty is that of a square mast as wide as the flow "
            f"is deep (w = H, Fr 3, frictionless) with as many cells{force}. It may be larger here.")
