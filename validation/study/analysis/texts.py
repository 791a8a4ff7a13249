"""The texts of this study (README.md, choices.md, ...): templates in texts/ in which every number comes from a table of tables/ by name.

A template is Markdown with a paragraph a line, `{{ value("coefficients", "reproduction", "k_r", ".2f") }}` for a number, and blocks of tables.
write() makes tables/ from the rows, the figure and the pages from tables/; check() says where they differ, and which number was typed.
"""

import re
import textwrap

import jinja2
import numpy as np
import pandas as pd

from analysis import facts, figures, loads
from analysis.study import STUDY
from mpmtools.design.factors import FILE
from mpmtools.errors import InputError
from mpmtools.files import write_text
from mpmtools.tables import csv_text

TABLES, TEMPLATES = STUDY / "tables", STUDY / "analysis" / "texts"
ELSEWHERE = {"load_factors": FILE}  # tables of mpmtools, which is installed without the study
DIGITS = 5  # of a number in tables/
NAMES = {"k_r": "k_r", "kappa_r": "κ_r", "k_p": "k_p", "Fr_sat": "Fr_sat", "kappa_p": "κ_p"}
# Numbers that are inputs of the study or bounds that it set itself; all others come from a table.
TYPED = re.compile(r"(?<![\w./^])[-+−±]?\d+(?:\.\d+)?(?:\s?%)?")
INPUTS = {"0", "0.05", "0.1", "0.15", "0.2", "0.25", "0.3", "0.35", "0.4", "0.5", "0.59", "0.8", "0.9", "0.95", "1", "1.2", "1.42", "1.5", "1.75",
          "1.76", "2", "2.1", "2.3", "3", "4", "4.2", "5", "5.25", "6", "7", "8", "8.4", "9", "10", "12", "12.6", "15", "20", "30", "35", "45",
          "90", "189", "371", "2007", "10 %", "15 %", "25 %", "90 %", "99 %"}


def rounded(table):
    """With DIGITS digits, so that round-off of another machine changes nothing."""
    def cell(value):
        return value if not isinstance(value, (float, np.floating)) or not np.isfinite(value) else float(f"{value:.{DIGITS}g}")
    return table.map(cell) if hasattr(table, "map") else table.applymap(cell)


def made_tables():
    return {name: rounded(make()) for name, make in facts.TABLES.items()}


def place_of(name):
    return ELSEWHERE.get(name, TABLES / f"{name}.csv")


def kept_tables():
    return {name: pd.read_csv(place_of(name), dtype={"key": str}, keep_default_na=True, comment="#") for name in facts.TABLES}


# ---- Pages ------------------------------------------------------------------------------------------------------------------------------


def number(value, form):
    """'+%' a signed percentage, '%' one without a sign, '.1%' with a digit; else a format of Python; a minus is a minus."""
    if not np.isfinite(value):
        return "–"
    if form.endswith("%"):
        sign, digits = ("+" if "+" in form else ""), (form.strip("+%").lstrip(".") or "0")
        text = f"{100.0 * value:{sign}.{digits}f}"
        return (text.lstrip("+-") if float(text) == 0.0 else text).replace("-", "−") + " %"
    text = f"{value:{form}}"
    return (text.lstrip("-") if float(text) == 0.0 else text).replace("-", "−")


class Values:
    """What a template may ask of the tables."""

    def __init__(self, tables):
        self.tables = {name: table.set_index("key") for name, table in tables.items()}

    def value(self, table, key, column, form=".2f"):
        try:
            return number(float(self.tables[table].loc[key, column]), form)
        except KeyError:
            raise InputError(f"tables/{table}.csv has no {column} of '{key}'") from None

    def raw(self, table, key, column):
        """The number itself, to compute with."""
        return float(self.tables[table].loc[key, column])

    def change(self, table, key, quantity):
        """A ratio as its change: '+4 % (−2 to +9 %)'."""
        ends = [number(self.raw(table, key, quantity + end) - 1.0, "+%") for end in ("", "_low", "_high")]
        return f"{ends[0]} ({ends[1].removesuffix(' %')} to {ends[2]})"

    def span(self, table, key, quantity, form="+%"):
        """Lowest to highest of a ratio, as changes: '−2 to +9 %'."""
        low, high = (number(self.raw(table, key, f"{quantity}_{end}") - 1.0, form) for end in ("low", "high"))
        return f"{low.removesuffix(' %')} to {high}"

    def largest(self, table, column):
        return float(self.tables[table][column].max())

    def keys_with(self, table, column):
        """The names of the rows in which a column is 1."""
        of = self.tables[table]
        return ", ".join(of.index[of[column] == 1]).replace("phi", "φ")

    def nearest_friction(self):
        """The rule for the friction of the mast with the least distance."""
        return self.tables["friction"].distance.idxmin().replace("phi", "φ")

    def block(self, name, *arguments):
        return BLOCKS[name](self, *arguments)

    def loads_spread(self, kind, quantity):
        """How far the factors of single kinds of snow are from their mean, at the most and over it: '−23 to +40 %'."""
        of = self.tables["load_factors_over_snow"]
        of = of[of.index.str.startswith(f"{kind} ") & of.index.str.contains(f" {quantity} ")]
        low, high = (of.factor_low / of.factor).min() - 1.0, (of.factor_high / of.factor).max() - 1.0
        return f"{number(low, '+%').removesuffix(' %')} to {number(high, '+%')}"

    def loads_uncertainty(self, kind, quantity):
        """The largest uncertainty of a factor, over the factor."""
        of = self.tables["load_factors"]
        of = of[(of.kind == kind) & (of.quantity == quantity)]
        return float((of.uncertainty / of.factor.abs()).max())


def markdown(head, rows):
    lines = ["| " + " | ".join(cells) + " |" for cells in (head, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])


COLUMNS = {"paper": "**paper**", "reproduction": "reproduction", "reproduction_wide": "wide set", "reproduction_fluid": "with the fluid",
           "prediction": "prediction (w/5)"}
INTERVALS = ("reproduction", "prediction")  # the columns beside which their intervals are


def block_headline(values):
    """Coefficients with their intervals, and the scatter about the own fit and about the published equation; a column for each campaign and set."""
    def row(label, cell, interval=lambda key: ""):
        cells = [label]
        for key in COLUMNS:
            cells += [cell(key), interval(key)] if key in INTERVALS else [cell(key)]
        return cells

    def get(column, form):
        return lambda key: values.value("coefficients", key, column, form)

    def coefficient(name):
        return lambda key: get(name, ".3f")(key) + ("" if key == "paper" else f" ({get(name + '_off', '+.0%')(key)})")

    rows = [row(symbol, coefficient(name), lambda key, name=name: f"{get(name + '_from', '.2f')(key)} to {get(name + '_to', '.2f')(key)}")
            for name, symbol in NAMES.items()]
    for short, score in (("r", "RMSLE of the run-up"), ("p", "NRMSE of the pressure height")):
        rows.append(row(score, lambda key, short=short: ", ".join(get(f"error_{short}{about}", ".1%")(key) for about in (("",) if key == "paper" else ("", "_published")))))
        rows.append(row("– within 10 / 25 %", lambda key, short=short: " / ".join(get(f"within_{p}_{short}", ".0%")(key).removesuffix(" %") for p in (10, 25))))
    rows.append(row("runs", lambda key: "" if key == "paper" else get("runs", ".0f")(key)))
    return markdown(row("", COLUMNS.get, lambda key: "90 %"), rows)


def block_aims(values, campaign):
    """How many aims are met, and the names of those that are missed, with what was found."""
    table = values.tables["aims"]
    names = {**NAMES, **{f"{name}_wide": f"{symbol} of the wide set" for name, symbol in NAMES.items()}, "rmsle": "RMSLE", "nrmse": "NRMSE"}
    missed = table[table[f"{campaign}_met"] == 0][campaign]
    texts = [f"{names[key]} ({number(value, '.1%' if key in ('rmsle', 'nrmse') else '+.0%')})" for key, value in missed.items()]
    return f"{len(table) - len(missed)} of {len(table)} are met. Missed: {', '.join(texts) or 'none'}."


def block_friction(values):
    rows = []
    for key in values.tables["friction"].index:
        def get(column, form=".2f", key=key):
            return values.value("friction", key, column, form)
        rows.append([key.replace("phi", "φ"), get("scores"), get("Fr"), get("M'"), f"**{get('distance')}**", f"{get('behind')} ± {get('behind_error')}",
                     get("fluid_rmsle", ".0%"), f"{get('k_r')}, {get('kappa_r')}"])
    return markdown(["friction of the mast", "scores", "Fr", "M'", "**distance**", "behind the nearest", "fluid", "k_r, κ_r"], rows)


CHOICE_NAMES = {"flip": "FLIP 0.95 for APIC, 0.25 m", "aflip": "AFLIP for APIC, 0.25 m", "aligned": "aligned lattice for staggered, Fr ≤ 1, 0.25 m",
                "particles_27": "27 particles a cell for 8, w/5",
                "cfl_02": "CFL number 0.2 for 0.4 (nodes, APIC)", "cfl_08_reproduction": "CFL number 0.8 for 0.4 (nodes, APIC)",
                "cfl_08_prediction": "CFL number 0.8 for 0.4 (surface, AFLIP)",
                "cfl_1_prediction": "CFL number 1 for 0.8 (surface, AFLIP)", "window_long": "window 1.5 times as long",
                "walls_slip": "side walls without friction", "slope_30": "slope of 30°"}


def block_choices(values):
    rows = []
    for key, name in CHOICE_NAMES.items():
        rows.append([name, values.value("choices", key, "points", ".0f"), *(values.change("choices", key, q) for q in ("runup", "pressure_height", "force")),
                     f"{values.value('choices', key, 'runup_rmsle', '%')} ({values.value('choices', key, 'base_runup_rmsle', '%')})"])
    return markdown(["changed", "points", "run-up", "pressure height", "force", "RMSLE (base)"], rows)


def block_grid(values):
    rows = []
    for key in values.tables["grid"].index[:-1]:
        if not key.endswith("from Fr 1 on"):
            continue
        rows.append([key.removesuffix(", from Fr 1 on").replace("xi", "ξ").replace("<=", "≤"),
                     *(values.change("grid", key, q) for q in ("runup", "pressure_height", "force")),
                     f"{values.value('grid', key, 'covered', '.0f')} of {values.value('grid', key, 'pairs', '.0f')}"])
    return markdown(["0.25 m over w/5, Fr ≥ 1", "run-up", "pressure height", "force", "run-ups within the stated uncertainty"], rows)


def block_pile_up(values):
    columns = ("0.40", "0.59", "0.80", "1.20", "1.42", "1.76", "2.30")
    names = {"reproduction_r": "run-up", "reproduction_p": "pressure height"}
    return markdown(["(h/H − 1)/M' at M' =", *columns], [[name, *(values.value("pile_up", key, c) for c in columns)] for key, name in names.items()])


def block_windows(values):
    rows = []
    for froude in ("1", "0.3", "0.1"):
        key = f"2.30 {froude}"
        rows.append([f"Fr {froude}", *(f"{values.value('windows', key, f'force_{n}')}, {values.value('windows', key, f'runup_{n}')} H, "
                                       f"{values.value('windows', key, f'pressure_height_{n}')} H" for n in "124")])
    return markdown(["M' = 2.3, ξ = 5, w/5", "usual window", "twice as long", "four times as long"], rows)


def block_heights(values):
    keys = [key for key in values.tables["mast_heights"].index if float(key) < 5.0]  # above, nothing changes
    return markdown(["mast height over H", *keys], [[f"Fr {froude}", *(values.value("mast_heights", key, froude) for key in keys)] for froude in ("1", "3", "5")])


def _factors(values, label, rows, columns):
    """A table of factors: the mean over M' and, if it varies, its range. `rows`: label and what it puts into the keys; `columns`: head and key with a
    place for that. Without columns that no row has."""
    table = values.tables["load_factors_over_snow"]
    columns = [(head, key) for head, key in columns if any(key.format(name) in table.index for _, name in rows)]

    def cell(key):
        if key not in table.index:
            return "–"
        low, mean, high = (values.value("load_factors_over_snow", key, f"factor{end}") for end in ("_low", "", "_high"))
        return mean if low == high else f"{mean} ({low} to {high})"

    return markdown([label, *(head for head, _ in columns)], [[text, *(cell(key.format(name)) for _, key in columns)] for text, name in rows])


def _names(values, kind):
    """(label, name) of the loads of a kind."""
    names = dict.fromkeys(key.split()[1] for key in values.tables["load_factors_over_snow"].index if key.startswith(f"{kind} "))
    return [(name.replace("_", " "), name) for name in names]


SLIPS = [(slip, slip) for slip in ("1", "0.7", "0.4", "0")]


def block_shape_factors(values):
    columns = [(f"{head}, Fr {froude}", f"shape {{}} {quantity} {froude}") for head, quantity in (("force", "force"), ("run-up", "runup")) for froude in ("0.3", "1", "3", "5", "7")]
    same = {"square 45": "square 45, wedge 45", "wedge 45": None, "square": None}  # one front; all 1
    names = [(same.get(label, label), name) for label, name in _names(values, "shape")]
    return _factors(values, "over the square", [(label, name) for label, name in names if label], columns)


def _factors_by_speed(values, label, names, columns):
    """A row a slip and a column a (head, key without the slip and the Froude number); a cell has the means over M' at Fr 1, 3 and 5."""
    factors = values.tables["load_factors_over_snow"].factor

    def cell(name, key):
        return ", ".join(number(factors.get(key.format(name, froude), np.nan), ".2f") for froude in ("1", "3", "5"))

    return markdown([label, *(head for head, _ in columns)], [[text, *(cell(name, key) for _, key in columns)] for text, name in names])


def block_peaks(values):
    return _factors_by_speed(values, "slip", SLIPS, [(f"front of {front}°", f"front front_{front}_slip_{{}} peak_force {{}}") for front in ("90", "45", "20")])


def block_sheared(values):
    quantities = (("arm over H", "lever_arm"), ("force", "force_over_plug"), ("moment", "moment_over_plug"), ("run-up", "runup_over_plug"))
    return _factors_by_speed(values, "slip", SLIPS, [(head, f"front front_90_slip_{{}} {quantity} {{}}") for head, quantity in quantities])


def block_arms(values):
    columns = [(f"{name}, Fr {froude}", f"arm {{}} {name} {froude}") for name in ("drag", "lift") for froude in ("3", "7")]
    names = [(label.removeprefix("base ") + " H", name) for label, name in _names(values, "arm")]
    return _factors(values, "underside at", names, columns)


def block_widths(values):
    widths = ("0.5", "2", "3")
    rows = [[f"M = {slope}, {label}", *(f"{values.value('widths', f'{slope} {w}', q + '_low')} to {values.value('widths', f'{slope} {w}', q + '_high')}" for w in widths)]
            for slope in ("0.5", "0.9") for q, label in (("runup", "run-up"), ("pressure_height", "pressure height"))]
    return markdown(["width of the mast over H", *widths], [*rows, ["guideline", *(values.value("widths", f"0.5 {w}", "guideline") for w in widths)]])


BLOCKS = {name.removeprefix("block_"): block for name, block in list(globals().items()) if name.startswith("block_")}


def wrapped(text, width=120):
    """Paragraphs and items of lists wrapped; tables, headings, code and images as they are."""
    lines, code = [], False
    for line in text.split("\n"):
        code ^= line.startswith("```")
        if code or len(line) <= width or line.startswith(("|", "#", "```", "![")):
            lines.append(line)
        else:
            indent = re.match(r"\s*(?:[-*] |\d+\. )?", line).group()
            lines += textwrap.wrap(line.replace(" %", "\xa0%"), width, subsequent_indent=" " * len(indent), break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines).replace("\xa0", " ")


def made_pages(tables):
    """{name: text} of every page."""
    values = Values(tables)
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(TEMPLATES), undefined=jinja2.StrictUndefined, keep_trailing_newline=True)
    environment.globals.update(number=number, **{name: getattr(values, name) for name in ("value", "raw", "change", "span", "largest", "keys_with", "nearest_friction", "block",
                                                                                       "loads_uncertainty", "loads_spread")})
    return {path.stem: wrapped(environment.get_template(path.name).render()) for path in sorted(TEMPLATES.glob("*.md.j2"))}


def typed_numbers(template):
    """Numbers of a template that no table gives and that are no input of the study."""
    text = re.sub(r"\{\{.*?\}\}|\{%.*?%\}|```.*?```|`[^`]*`|\]\([^)]*\)|\"[^\"]*\"|\b[0-9a-f]{8,12}\b|[A-Z]\d(?:\.\d)?\b|(?:Sect|Fig|Figs|Eq|Eqs)\. [\dA]+(?:\.\d+)*",
                  " ", template, flags=re.S)
    return [found.strip() for found in TYPED.findall(text) if found.strip().lstrip("+−-±") not in INPUTS]


# ---- Commands ---------------------------------------------------------------------------------------------------------------------------


def write():
    tables = made_tables()
    for name, table in tables.items():
        source = f"# {loads.provenance()}\n" if name == "load_factors" else ""
        write_text(str(place_of(name)), source + csv_text(table, nothing=""))
    write_pages()


def write_pages():
    tables = kept_tables()
    figures.draw(STUDY / "figures")
    for name, text in made_pages(tables).items():
        write_text(str(STUDY / name.removesuffix(".md")) + ".md", text)


def check():
    """What is out of date, in sentences."""
    kept, wrong = kept_tables(), []
    for name, fresh in made_tables().items():
        wrong += [f"{place_of(name).name}: {difference}" for difference in differences(fresh, kept[name])]
    return wrong + check_pages(kept)


def check_pages(tables):
    wrong = []
    for name, text in made_pages(tables).items():
        path = STUDY / (name.removesuffix(".md") + ".md")
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            wrong.append(f"{path.name}: is not what its template and tables/ make")
    for path in sorted(TEMPLATES.glob("*.md.j2")):
        wrong += [f"texts/{path.name}: '{found}' is typed; take it from a table, or name it as an input (INPUTS)"
                  for found in typed_numbers(path.read_text(encoding="utf-8"))]
    return wrong


def differences(fresh, kept):
    """Where two tables differ by more than round-off, in words."""
    if list(fresh.columns) != list(kept.columns) or len(fresh) != len(kept):
        return ["has other columns or another number of rows than its rows give"]
    found = []
    for column in fresh:
        for key, a, b in zip(fresh.key, fresh[column], kept[column]):
            same = str(a) == str(b) or (isinstance(a, (int, float, np.number)) and np.isclose(float(a), float(b), rtol=2e-4, atol=1e-9, equal_nan=True))
            if not same:
                found.append(f"{column} of '{key}' is {b}, the rows give {a}")
    return found
