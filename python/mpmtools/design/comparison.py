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
    """Why the equations do not quite fit this site."""
    flow, mast = plan["flow"], plan["mast"]
    ratio, remarks = mast["width_m"] / flow["depth_m"], []
    if mast["shape"] != "box":
        remarks.append("they were fitted to a box with its face against the flow")
    if abs(ratio - 1.0) > 0.05:
        outside = "" if 0.5 <= ratio <= 3.0 else ", outside the 0.5 to 3 that were simulated"
        remarks.append(f"they were fitted to w = H, and here w/H = {ratio:.2f}{outside}")
    if not 0.1 <= flow["froude_number"] <= 7.0:
        remarks.append(f"they were fitted to Fr from 0.1 to 7, and here Fr = {flow['froude_number']:.2g}")
    return remarks
