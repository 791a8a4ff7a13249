"""What the pages of this project share: style sheet, colours, axes, and pictures as data addresses.

A page holds its images and needs no other file.
"""

import base64
import html
import io
import math
import re
from typing import NamedTuple

import markupsafe
import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  (after the backend is chosen)
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullFormatter  # noqa: E402

# Distinct in hue and in lightness, so that they survive colour blindness and a grey printer.
COLOURS = ["#1f6fb4", "#d1601f", "#2e8b57", "#8b4fa8", "#b3262e", "#6b6b00", "#008b9a", "#9c5b3b"]
MARKERS = ["o", "s", "^", "D", "v", "P", "X", "*"]

STYLE = r""":root { --ink: #1c2430; --soft: #5a6675; --line: #d9dee5; --tint: #f5f7fa; --good: #1c7a43; --bad: #b3262e; --accent: #1f6fb4; }
* { box-sizing: border-box; }
html { scroll-behavior: smooth; }
body { margin: 0; color: var(--ink); background: #fff; font: 16px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
.page { display: grid; grid-template-columns: 12rem minmax(0, 1fr); max-width: 1480px; margin: 0 auto; }
nav { position: sticky; top: 0; align-self: start; max-height: 100vh; overflow-y: auto; padding: 1.6rem .5rem 2rem .9rem; border-right: 1px solid var(--line); font-size: .82rem; }
nav b { display: block; margin: 0 0 .5rem; font-size: .95rem; }
nav a { display: grid; grid-template-columns: 1.1rem 1fr; padding: .14rem 0; color: var(--ink); line-height: 1.35; }
main { padding: 1.5rem 1.4rem 4rem; min-width: 0; }
h1 { font-size: 1.7rem; margin: 0 0 .3rem; line-height: 1.2; }
h2 { font-size: 1.3rem; margin: 0; line-height: 1.25; }
h3 { font-size: 1rem; margin: 1.5rem 0 .4rem; }
a { color: var(--accent); text-decoration: none; } a:hover { text-decoration: underline; }
code { font: .88em ui-monospace, "DejaVu Sans Mono", monospace; background: var(--tint); padding: .1em .3em; border-radius: 3px; overflow-wrap: anywhere; }
.lead { color: var(--soft); margin: 0 0 1rem; max-width: 80ch; }
.verdict { font-weight: 650; white-space: nowrap; } td.verdict { white-space: normal; } .ok { color: var(--good); } .failed { color: var(--bad); } .known { color: #8a5a00; }
.score { display: flex; gap: .3rem 2rem; flex-wrap: wrap; align-items: baseline; padding: .9rem 1.1rem; border: 1px solid var(--line);
  border-left: 5px solid var(--good); border-radius: 4px; margin: 1rem 0 1.2rem; background: var(--tint); }
.score.bad { border-left-color: var(--bad); } .score.missed { border-left-color: #8a5a00; }
.score b { font-size: 1.3rem; }
dl.facts { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1rem; margin: 0 0 1.5rem; font-size: .88rem; }
dl.facts dt { color: var(--soft); } dl.facts dd { margin: 0; overflow-wrap: anywhere; }
table { border-collapse: collapse; width: 100%; font-size: .78rem; font-variant-numeric: tabular-nums; line-height: 1.4; }
th { text-align: left; font-weight: 600; color: var(--soft); border-bottom: 2px solid var(--line); padding: .3rem .3rem; vertical-align: bottom; }
td { border-bottom: 1px solid var(--line); padding: .3rem .3rem; vertical-align: top; }
td.number { text-align: right; white-space: nowrap; } td.wrap { white-space: normal; } th.number { text-align: right; }
td.what { min-width: 11rem; }
tr.bad td { background: #fdf1f1; }
tr.known td { background: #fdf7e6; color: inherit; }
td.fault { color: var(--bad); overflow-wrap: anywhere; }
.used { display: inline-block; width: 1.6rem; height: .5rem; margin-left: .45rem; background: linear-gradient(var(--bar) 0 0) 0 0 / var(--share) 100% no-repeat #e6eaef; border-radius: 2px; }
sup { line-height: 0; } sup a { padding-left: .15em; }
section { border-top: 3px solid var(--line); margin-top: 2.6rem; padding-top: 1.3rem; }
.heading { display: flex; gap: .3rem 1rem; flex-wrap: wrap; align-items: baseline; }
.heading .top { margin-left: auto; font-size: .84rem; }
.tag { color: var(--soft); font-size: .9rem; }
.physics { max-width: 85ch; }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 27rem), 1fr)); gap: 1.1rem; margin: 1rem 0; align-items: start; }
figure { margin: 0; border: 1px solid var(--line); border-radius: 4px; padding: .6rem; break-inside: avoid; min-width: 0; }
figure img { width: 100%; height: auto; display: block; }
figcaption { font-size: .84rem; color: var(--soft); margin-top: .3rem; overflow-wrap: anywhere; }
ul.notes, ol.reasons { font-size: .88rem; padding-left: 1.5rem; max-width: 100ch; margin: .4rem 0; overflow-wrap: anywhere; }
ol.reasons { list-style: lower-alpha; color: var(--soft); }
.more { font-size: .88rem; margin: .5rem 0; color: var(--accent); cursor: pointer; }
.unfold { position: absolute; opacity: 0; pointer-events: none; } .unfold:focus-visible ~ .more { outline: 2px solid var(--accent); }
.unfold:not(:checked) ~ table tr.rest { display: none; }
.unfold:checked ~ .more .closed, .unfold:not(:checked) ~ .more .open { display: none; }
.legend { font-size: .84rem; color: var(--soft); max-width: 100ch; }
@media screen and (max-width: 1220px) {
  .page { display: block; } nav { display: none; } main { padding: 1.2rem 1.1rem 3rem; }
}
@media screen and (max-width: 760px) {
  main { padding: 1rem .8rem 3rem; }
  table.stack thead { display: none; }
  table.stack tr { display: grid; grid-template-columns: 1fr 1fr; gap: .1rem .8rem; border: 1px solid var(--line); border-radius: 4px; margin: 0 0 .6rem; padding: .45rem .6rem; }
  table.stack tr.bad { border-left: 4px solid var(--bad); background: #fdf1f1; }
  table.stack td { display: flex; flex-wrap: wrap; gap: 0 .5rem; border: 0; padding: 0; text-align: left; white-space: normal; overflow-wrap: anywhere; min-width: 0; background: none; }
  table.stack td::before { content: attr(data-label); color: var(--soft); }
  table.stack td.empty, table.stack td:empty { display: none; }
  table.stack td.name, table.stack td.what, table.stack td.fault { grid-column: 1 / -1; }
  table.stack td.name, table.stack td.what { font-weight: 600; } table.stack td.name::before, table.stack td.what::before, table.stack td.fault::before { content: none; }
  dl.facts { grid-template-columns: 1fr; } dl.facts dt { margin-top: .4rem; }
}
@media print {
  @page { size: A4; margin: 14mm 12mm; }
  :root { --accent: #1c2430; }
  body { font-size: 9.5pt; print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  .page { display: block; max-width: none; } nav, .top, .more { display: none !important; } main { padding: 0; }
  table { font-size: 7pt; } th, td { padding: .2rem .25rem; } td.what { min-width: 0; } .used { display: none; }
  .unfold:not(:checked) ~ table tr.rest { display: table-row; }
  thead { display: table-header-group; } tr, figure, .score, dl.facts { break-inside: avoid; }
  h2, h3, .heading, .physics { break-after: avoid; }
  section { break-before: page; margin-top: 0; border-top: 0; padding-top: 0; }
  .figures { display: block; columns: 2; column-gap: 4mm; padding-right: 1px; } figure { margin: 0 0 4mm; } figcaption, .legend, ul.notes, ol.reasons, code { font-size: 7.6pt; }
  dl.facts { font-size: 8pt; }
}
"""


def inline(text):
    """The little Markdown that a paragraph uses: `code`, *emphasis*, [text](address)."""
    text = html.escape(text, quote=False)
    text = re.sub(r"`([^`]+)`", r"<code>\1</code>", text)
    text = re.sub(r"(?<![\w*])\*\*?([^*\s][^*]*)\*\*?(?!\w)", r"<em>\1</em>", text)
    text = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", text)
    return markupsafe.Markup(text)


def verdict_class(verdict):
    """Style of a verdict: "ok", "not met" (of a check), "ok, 3 not met" (of a case) or "FAILED"."""
    return "known" if verdict.endswith("not met") else {"ok": "ok"}.get(verdict, "failed")


def breakable(name):
    """A name that may break after an underscore."""
    return markupsafe.Markup("_<wbr>").join(markupsafe.escape(part) for part in name.split("_"))


def short(value):
    return "" if value is None else f"{value + 0.0:.4g}"  # + 0.0: a negative zero is 0


def finish_axes(axes):
    axes.grid(True, which="major", color="#e3e7ec", linewidth=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def new_axes(width=6.2, height=4.3):
    return plt.subplots(figsize=(width, height), layout="constrained")[1]


class Picture(NamedTuple):
    title: str
    caption: str
    data: str  # data address


def picture(axes, title, x, y, caption="", legend=True, **arguments):
    """Finishes axes and makes a picture of their figure; further arguments go to the legend."""
    axes.set_title(title, fontsize=10.5, loc="left")
    axes.set(xlabel=x, ylabel=y)
    finish_axes(axes)
    if legend and (arguments.get("handles") or axes.get_legend_handles_labels()[0]):
        axes.legend(**{"fontsize": 8.5, "frameon": True, "framealpha": 0.9, "edgecolor": "none", **arguments})
    return Picture(title, caption, _data_address(axes.figure, "svg+xml", format="svg", metadata={"Date": None}))


def png_data(figure):
    return _data_address(figure, "png", format="png", dpi=130, metadata={"Software": None})


def _data_address(figure, kind, **options):
    """The image of a figure, which is closed. @param options  of savefig"""
    stream = io.BytesIO()
    figure.savefig(stream, **options)
    plt.close(figure)
    return f"data:image/{kind};base64," + base64.b64encode(stream.getvalue()).decode()


def nice_ticks(low, high):
    """Round numbers from low to high, at most six: 1, 2, 5 of each decade, or equal steps where fewer than three of those are inside."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for leading in ((1,), (1, 3), (1, 2, 5)):
        ticks = [float(f"{digit}e{power}") for power in decades for digit in leading if low <= float(f"{digit}e{power}") <= high]
        if 3 <= len(ticks) <= 6:
            return ticks
    for intervals in range(4, 10):
        ticks = [float(t) for t in MaxNLocator(nbins=intervals, steps=[1, 2, 5, 10]).tick_values(low, high) if low <= t <= high]
        if len(ticks) >= 2:
            break
    return ticks


def tick_label(value):
    """A number as a tick shows it: 0.002, 6·10⁻⁵."""
    if value == 0.0 or 1e-3 <= abs(value) < 1e5:
        return f"{value + 0.0:.5g}"
    digits, power = f"{value:.3e}".split("e")
    return rf"${float(digits):g}\cdot10^{{{int(power)}}}$"


def plain_ticks(axis, values):
    """A few round ticks on a logarithmic axis that spans less than two decades."""
    values = [v for v in values if math.isfinite(v) and v > 0]
    if values and max(values) / min(values) < 100:
        margin = (max(values) / min(values)) ** 0.04  # a little less than that of the axes
        axis.set_major_locator(FixedLocator(nice_ticks(min(values) / margin, max(values) * margin)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: tick_label(value)))
        axis.set_minor_formatter(NullFormatter())


def use_style():
    """Sets what all figures have in common."""
    matplotlib.rcParams.update({"font.size": 10, "svg.hashsalt": "libmpm", "axes.edgecolor": "#5a6675"})
