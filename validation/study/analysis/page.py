"""The page of the study: the paper's figures and tables from our runs, with its values beside ours.

Every number comes from the tables of a study (analysis.tables) or of a campaign. The page holds its images and needs no other
file.
"""

import os
import re

import jinja2
import markupsafe
import pandas as pd

from analysis.axes import Drawn, number, per_cent
from analysis import evidence_figures, extension_figures, paper_figures, summary
from mpmtools.figures.style import STYLE, inline, use_style
from mpmtools.files import write_text
from analysis.summary import SETS
from mpmtools.files import read_json
from mpmtools.scores import levels
from mpmtools.tables import read_series

INPUTS = ("froude_number", "critical_state_slope", "cohesion_beta", "hardening_xi", "effective_friction", "relative_width")


class Study:
    """What one folder of a study holds: fit.json, and its tables by name."""

    def __init__(self, folder):
        self.folder = str(folder)
        self.name = re.sub(r"_w(\d+)$", r" at w/\1", os.path.basename(os.path.normpath(self.folder))).replace("_", " ")
        path = os.path.join(self.folder, "fit.json")
        self.fit = read_json(path)

    def table(self, name, text=()):
        """A table as a DataFrame whose equal inputs are equal to the bit; empty without the file. `text`: columns to leave as written."""
        path = os.path.join(self.folder, f"{name}.csv")
        if not os.path.exists(path):
            return pd.DataFrame()
        table = read_series(path, dtype={column: str for column in text})
        return table.assign(**{column: levels(table[column]) for column in INPUTS if column in table})

    def regression(self, equation, fitting_set="narrow"):
        """The part of fit.json on one equation and set; None without it."""
        return next((f for f in self.fit["fits"] if f["equation"] == equation and f["fitting_set"] == fitting_set), None)

    def is_fitted(self, equation):
        fit = self.regression(equation)
        return bool(fit and fit["coefficients"])

    def why_not(self, equation):
        fit = self.regression(equation)
        return fit["why_not"] if fit and fit["why_not"] else "not fitted"


# ---- Tables of the page -------------------------------------------------------------------------------------------------------------


def coefficient_table(studies, equation):
    """Layout of Tables A1 and A2, ours beside the paper's."""
    rows = []
    for label, fit in _fits_of(studies, equation):
        if not fit["coefficients"]:
            rows.append([label, "", fit["why_not"], *[""] * 7])
        for c in fit["coefficients"]:
            low, high = c["interval"]
            rows.append([f"{label} ({fit['runs']} runs)", c["parameter"], number(c["value"], 4), number(c["relative_standard_error"], 4),
                         number(c["t_statistic"], 2), "–" if c["p_value"] is None else f"{c['p_value']:.1e}",
                         f"{number(low)} – {number(high)}", number(c["published"], 4), number(c["published_relative_standard_error"], 4),
                         per_cent(c["relative_difference"])])
    return {"head": ["fitting set", "parameter", "value", "rel. std. error", "t", "p", "95 % interval", "paper", "paper's rel. std. error",
                     "difference"], "rows": rows}


def score_table(studies, equation):
    rows, published = [], None
    for label, fit in _fits_of(studies, equation):
        published = fit["published_scores_on_its_own_data"]
        for whose, key in (("our fit", "scores_of_fitted"), ("published equation", "scores_of_published")):
            if key in fit:
                rows.append([f"{label}: our data, {whose}", *_score_cells(fit[key])])
    if published:
        rows.append(["paper: its data, its fit", *_score_cells(published)])
    return {"head": ["data and equation", "R²", "R²_log", "NRMSE", "RMSLE", "bias", "within 10 %", "within 25 %"], "rows": rows}


def _fits_of(studies, equation):
    """(label, part of fit.json) for every study and fitting set."""
    return [(f"{study.name}, {name}" if len(studies) > 1 else name, fit) for study in studies for name in SETS
            if (fit := study.regression(equation, name))]


def _score_cells(s):
    return [number(s["r2"]), number(s["r2_log"]), per_cent(s["nrmse"]), per_cent(s["rmsle"]), number(s["bias"]), per_cent(s["fraction_10"]),
            per_cent(s["fraction_25"])]


def cautions_of(study):
    return list(study.fit["cautions"]) + [c for fit in study.fit["fits"] if fit["fitting_set"] == "narrow" for c in fit["cautions"]]


# ---- Sections -----------------------------------------------------------------------------------------------------------------------

SECTIONS = [
    ("fig1", "Figure 1: friction and cohesion in one number", paper_figures.figure_1,
     "The snow is a cohesive Cam-Clay. Its internal friction *M* and its cohesion *β* act together as an effective internal friction M' "
     "(Eq. 2), the ratio of shear to mean stress at which it flows without change of volume. All that follows is drawn over M'. This "
     "figure is a formula; nothing is simulated."),
    ("fig3", "Figure 3: how the heights come about in time", paper_figures.figure_3,
     "Run-up is the highest particle in front of the mast; pressure height is where the smoothed pressure on the mast falls below 5 % of "
     "its mean over the flow height. Each band holds all rheologies at one Froude number Fr = v/√(gH). Slow flow piles up smoothly; fast "
     "flow first shoots up a splash, which stays in the air for some 2 v/g, and only then becomes steady. In the paper the steady run-up "
     "varies with the rheology by a factor of about 3 at Fr = 0.1, 2.5 at Fr = 1 and 15 at Fr = 5 (2 to over 30 H; above 13.5 H, "
     "Bernoulli's bound, only a peak can be meant)."),
    ("fig4", "Figure 4: which property of the snow does what", paper_figures.figure_4,
     "Starting from an inviscid fluid, friction, cohesion and plastic compressibility are added one after the other. The paper: the fluid "
     "follows the velocity head added to the flow height; at low Fr friction and cohesion raise the run-up by piling up, at high Fr they "
     "lower it by dissipation; compressibility matters little. Pressure height follows the run-up to Fr ≈ 2 and then stays constant."),
    ("fig5", "Figure 5: run-up is not where the pressure is", paper_figures.figure_5,
     "The same snow (M = 0.8, β = 0.3, ξ = 0.5) in slow and in fast flow. In the slow flow pressure acts over most of the run-up; in the "
     "fast one it is confined to a small part of it, because the jet that rises along the mast no longer pushes against it."),
    ("fig6", "Figure 6: pressure height over run-up height", paper_figures.figure_6,
     "Up to Fr ≈ 2 both heights are of one size; above, the run-up grows with the square of the speed, while the pressure height stays. "
     "The paper sees it saturate at about 1.5 to 2.5 H."),
    ("fig7", "Figure 7: the equations against the simulations", paper_figures.figure_7,
     "Every run with w = H and ξ > 0.05: predicted over simulated height, by the published coefficients and by ours. In the paper 92.9 % "
     "of the run-ups and all pressure heights lie within 25 %."),
    ("fig8", "Figure 8: the two factors of the equations", paper_figures.figure_8,
     "Magnification ζ = k M' is the quasi-static pile-up over H; the velocity head is divided by the dissipation factor λ = exp(κ M'). "
     "Where our curves leave the published ones, the snow of our simulations piles up or dissipates differently."),
    ("fig9", "Figure 9: the guideline's avalanche types in terms of M'", paper_figures.figure_9,
     "The Swiss guideline divides the velocity head by λ = 1.5 for dry, loose and by 3 for dense avalanches. For each M' the distance of "
     "our run-ups at 3 ≤ Fr ≤ 7 from H + v²/(2gλ) f(w/H) is measured as an RMSLE; where it is smallest, snow and avalanche type "
     "correspond. A minimum lies between the neighbours of the lowest point; the parabola through the three is the best guess, and "
     "decides."),
    ("fig10", "Figure 10: narrow and wide masts", paper_figures.figure_10,
     "Heights at other widths of the mast over those at w = H (Eq. 11), with the guideline's width factor (Eq. 6) rescaled to 1 there. "
     "The paper: run-up depends weakly on the width, pressure height follows the guideline at high Fr, and below w = H the guideline "
     "lowers the load more than the simulations do."),
    ("figS1", "Sensitivities: what the choices do that the paper leaves open", paper_figures.figure_s1,
     "One choice at a time is changed against the base of the study, at several points of flow and snow. The paper (its supplement S1, "
     "Sect. 4.3): robust to grid and slope; more friction on the mast lowers the run-up."),
    ("height-choices", "What is taken as the height of a run", paper_figures.height_choice_table,
     "The paper averages over an interval of several seconds that it does not print. Ours is the longest that ends with the run and whose "
     "running mean stays within 5 % of its end. Slow piles still grow in it; the last third of the run gives a later, the peak the highest "
     "value."),
    ("compaction", "Compressible snow: what compaction takes", paper_figures.figure_compaction,
     "The equations know no compressibility, and fast compressible snow climbs less than they say. A plug of snow that is compacted from "
     "ρ₀ to χρ₀ in a standing shock before the mast keeps (2χ − 1)/χ² of its velocity head (mass and momentum); plastic work takes the "
     "rest. χ is measured at the mast's front face. What lies below the line loses more than the shock takes. For cohesive snow the "
     "shock helps only where ξ is small (table); the run-up of such snow may also fall from a high to a low plateau late in a run. The exact "
     "shock is the case compaction_shock of the validation; against it, APIC, the transfer of these runs, compacts snow "
     "by 1.0 to 3.8 % too much, and AFLIP by 1.8 to 9.1 %."),
]
APPENDIX = [
    ("figA2", "Figure A2: run-up height over M'", "runup", paper_figures.heights_over_friction,
     "Simulated run-up for three compressibilities, with both equations. At low Fr it rises with M' (pile-up), at high Fr it falls "
     "(dissipation)."),
    ("figA3", "Figure A3: where the run-up equation errs", "runup", paper_figures.error_breakdown,
     "RMSLE of the runs of one Froude number, and of one M'. The paper: for ξ = 5 below 10 % for Fr < 3 and 10 to 15 % above; for ξ = 0.5 "
     "7 to 15 % and 14 to 23 %; for ξ = 0.05, outside the fit, below 20 % for Fr < 3 only; best for M' from 0.4 to 1.5. Full lines: our "
     "fit; dashed: the published coefficients."),
    ("figA4", "Figure A4: pressure height over M'", "pressure_height", paper_figures.heights_over_friction,
     "As Figure A2, for the pressure height, whose velocity head is limited at the saturation Froude number."),
    ("figA5", "Figure A5: where the pressure-height equation errs", "pressure_height", paper_figures.error_breakdown,
     "NRMSE of the runs of one Froude number, and of one M'. The paper: 4 to 8 % for ξ = 5; up to 14 % at high Fr for ξ = 0.5; above 20 % "
     "for ξ = 0.05 at Fr > 3 and M' < 0.4."),
]
FIT_TABLES = [
    ("tableA1", "Table A1: run-up height", "runup", "h_r/H = 1 + k_r M' + Fr²/2 exp(-κ_r M'), fitted to log(h_r/H)."),
    ("tableA2", "Table A2: pressure height", "pressure_height",
     "h_p/H = 1 + k_p M' + min(Fr, Fr_sat)²/2 exp(-κ_p M'), fitted to h_p/H."),
]


def draw_page(target, folders, extensions=None):
    """Writes the page of one or more studies: figures are drawn from the first that has their tables, the others are beside it in the tables.

    `extensions` is a folder with the tables of the runs beyond the paper (extension_figures.py); without it they are left out.
    """
    use_style()
    studies = [Study(folder) for folder in folders]
    study = studies[0]
    sections = [_section(identity, title, text, *_first_drawn(studies, draw)) for identity, title, draw, text in evidence_figures.SECTIONS]
    sections += [_section(identity, title, text, drawn_of_each(studies, draw)) for identity, title, draw, text in evidence_figures.OF_EACH_STUDY]
    sections += [_section(identity, title, text, *_first_drawn(studies, draw)) for identity, title, draw, text in SECTIONS]
    sections += [_section(identity, title, text, draw(study, key)) for identity, title, key, draw, text in APPENDIX]
    if extensions:
        sections += [_section(identity, title, text, draw(extensions)) for identity, title, draw, text in extension_figures.SECTIONS]
    tables = [{"id": identity, "title": title, "text": text, "coefficients": coefficient_table(studies, equation),
               "scores": score_table(studies, equation)} for identity, title, equation, text in FIT_TABLES]
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(os.path.dirname(__file__)), autoescape=True, trim_blocks=True)
    environment.filters["inline"] = inline
    page = environment.get_template("page.html.j2").render(
        style=markupsafe.Markup(STYLE), study=study.fit, name=study.name, sections=sections, tables=tables,
        headline=summary.headline(studies), matrix=summary.matrix(studies),
        others=studies[1:], cautions=cautions_of(study))
    write_text(target, page)


def _first_drawn(studies, draw):
    """(what the first study draws that has the tables, the name of that study where it is not the page's first)."""
    for study in studies:
        drawn = draw(study)
        if drawn.pictures or drawn.tables:
            return drawn, "" if study is studies[0] else study.name
    return draw(studies[0]), ""  # what is missing


def drawn_of_each(studies, draw):
    """What all studies draw that have the tables; what is missing where none has."""
    drawn = [d for study in studies if (d := draw(study)).pictures]
    if not drawn:
        return draw(studies[0])
    return Drawn([picture for d in drawn for picture in d.pictures], [], [table for d in drawn for table in d.tables])


def _section(identity, title, text, drawn, source=""):
    return {"id": identity, "title": title, "text": text, "missing": drawn.missing, "tables": drawn.tables, "images": drawn.pictures,
            "source": source}
