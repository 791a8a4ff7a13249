"""Figures inside a page whose points and curves give their values under the pointer, and which can be enlarged. No library, no network: the
page holds all.

Without scripts, and in print, the figures are plain SVG; every named point then has its text as a <title>.
"""

import dataclasses
import html
import io
import json
import math
import re

import markupsafe

from mpmtools.figures.style import plt

STYLE = r""".figures svg { width: 100%; height: auto; display: block; }
.figures svg.zoomable { cursor: crosshair; touch-action: pan-x pan-y pinch-zoom; }
.figures svg .point:focus { outline: none; }
.figures svg .mark { fill: none; stroke: #1c2430; stroke-width: 1.5; vector-effect: non-scaling-stroke; pointer-events: none; }
.tip { position: absolute; z-index: 9; max-width: min(26rem, 92vw); padding: .35rem .6rem; border-radius: 4px; background: #1c2430; color: #fff; font-size: .8rem;
  line-height: 1.4; white-space: pre-line; pointer-events: none; overflow-wrap: anywhere; }
.zoom { position: absolute; z-index: 8; border: 1px solid var(--accent); background: rgba(31, 111, 180, .12); pointer-events: none; }
@media print { .tip, .zoom, .screen, .mark { display: none; } }
"""

SCRIPT = r"""(() => {
  const reach = 22;  // px from a point at which it is named
  const element = (name) => { const e = document.createElement("div"); e.className = name; e.hidden = true; document.body.append(e); return e; };
  const tip = element("tip"), frame = element("zoom");
  const show = (place) => {  // {x, y: px in the window, text}
    if (!place) { tip.hidden = true; return; }
    const { x, y } = place;
    tip.textContent = place.text;
    tip.hidden = false;
    const left = Math.max(4, Math.min(x + 12, document.documentElement.clientWidth - tip.offsetWidth - 4));
    const above = y - tip.offsetHeight - 10;
    tip.style.left = `${left + scrollX}px`;
    tip.style.top = `${(above > 4 ? above : y + 14) + scrollY}px`;
  };
  const place = (point) => { const b = point.getBoundingClientRect(); return { x: b.x + b.width / 2, y: b.y + b.height / 2, text: point.dataset.text }; };
  for (const svg of document.querySelectorAll("svg.zoomable")) {
    const points = [...svg.querySelectorAll(".point")], whole = svg.getAttribute("viewBox"), [, , width, height] = whole.split(" ").map(Number);
    for (const p of points) {
      p.querySelector("title")?.remove();
      p.addEventListener("focus", () => show(place(p)));
      p.addEventListener("blur", () => show(null));
    }
    const curves = JSON.parse(svg.dataset.curves ?? "[]");  // name, labels, at: x, y in the figure, ten to a point, values: x, y
    const mark = curves.length ? svg.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "circle")) : null;
    mark?.setAttribute("class", "mark");
    mark?.setAttribute("r", 0);
    const inside = (x, y) => new DOMPoint(x, y).matrixTransform(svg.getScreenCTM().inverse());
    const nearest = (event) => {
      let best = null, least = reach;
      for (const p of points) {
        const there = place(p), distance = Math.hypot(there.x - event.clientX, there.y - event.clientY);
        if (distance < least) { best = there; least = distance; }
      }
      if (!mark) return best;
      const screen = svg.getScreenCTM(), here = inside(event.clientX, event.clientY);
      let found = null;
      for (const c of curves) {
        for (let i = 0; i < c.at.length; i += 2) {
          const distance = screen.a * Math.hypot(c.at[i] / 10 - here.x, c.at[i + 1] / 10 - here.y);
          if (distance < least) { found = [c, i]; least = distance; }
        }
      }
      mark.setAttribute("r", found ? 5 / screen.a : 0);
      if (!found) return best;
      const [c, i] = found, at = new DOMPoint(c.at[i] / 10, c.at[i + 1] / 10), there = at.matrixTransform(screen);
      mark.setAttribute("cx", at.x);
      mark.setAttribute("cy", at.y);
      return { x: there.x, y: there.y, text: `${c.name}\n${c.labels[0]}: ${c.values[i]}\n${c.labels[1]}: ${c.values[i + 1]}` };
    };
    const forget = () => { show(null); mark?.setAttribute("r", 0); };
    let start = null;
    svg.addEventListener("pointerdown", (event) => {
      show(nearest(event));
      if (event.pointerType !== "mouse" || event.button !== 0) return;  // fingers scroll the page
      start = [event.clientX, event.clientY];
      svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointermove", (event) => {
      if (!start) { show(nearest(event)); return; }
      event.preventDefault();
      const [x, y] = [Math.min(start[0], event.clientX), Math.min(start[1], event.clientY)];
      Object.assign(frame.style, { left: `${x + scrollX}px`, top: `${y + scrollY}px`, width: `${Math.abs(event.clientX - start[0])}px`,
                                   height: `${Math.abs(event.clientY - start[1])}px` });
      frame.hidden = false;
    });
    svg.addEventListener("pointerup", (event) => {
      if (start && Math.hypot(event.clientX - start[0], event.clientY - start[1]) > 12) {
        const a = inside(...start), b = inside(event.clientX, event.clientY);
        const wide = Math.max(Math.abs(a.x - b.x), Math.abs(a.y - b.y) * width / height);  // the figure keeps its place on the page
        svg.setAttribute("viewBox", `${(a.x + b.x - wide) / 2} ${(a.y + b.y - wide * height / width) / 2} ${wide} ${wide * height / width}`);
        forget();
      }
      start = null;
      frame.hidden = true;
    });
    svg.addEventListener("pointercancel", () => { start = null; frame.hidden = true; });
    svg.addEventListener("pointerleave", forget);
    svg.addEventListener("dblclick", () => { svg.setAttribute("viewBox", whole); forget(); });
  }
})();
"""


@dataclasses.dataclass
class Curve:
    """A series of a plot that gives its values under the pointer."""

    name: str
    x: list
    y: list


MOST_VALUES = 400  # of a curve: more cannot be pointed at


def _curves_data(axes, curves):
    """Places in the figure (tenths of a point, from its upper left corner) and values of the curves, as JSON."""
    figure = axes.figure
    high, scale, area = figure.get_size_inches()[1] * 72.0, 72.0 / figure.dpi, axes.bbox.padded(2.0)
    labels = [" ".join(text.split()) for text in (axes.get_xlabel(), axes.get_ylabel())]
    data = []
    for curve in curves:
        finite = [(x, y) for x, y in zip(curve.x, curve.y) if math.isfinite(x) and math.isfinite(y)]
        kept = finite[::math.ceil(len(finite) / MOST_VALUES)] if finite else []
        at, values = [], []
        for (x, y), (px, py) in zip(kept, axes.transData.transform(kept) if kept else []):
            if area.contains(px, py):  # others are not seen; a logarithmic axis has no place for zero
                at += [round(10.0 * scale * px), round(10.0 * (high - scale * py))]
                values += [float(f"{x:.4g}"), float(f"{y:.4g}")]
        data.append({"name": curve.name, "labels": labels, "at": at, "values": values})
    return json.dumps(data, ensure_ascii=False, separators=(",", ":"))


def inline_svg(figure, texts, label, curves=()):
    """The figure as SVG for a page.

    texts: text of every artist that was given the name (gid); label: the description for readers who cannot see it;
    curves: Curve objects of the figure's first axes, named as in its legend.
    """
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    described = html.escape(_curves_data(figure.axes[0], curves), quote=False).replace("'", "&#39;") if curves else ""
    data = f"data-curves='{described}' " if curves else ""
    plt.close(figure)
    svg = stream.getvalue()
    svg = svg[svg.index("<svg"):]
    svg = re.sub(r'<svg [^>]*?viewBox="([^"]*)"[^>]*>',
                 lambda m: f'<svg xmlns:xlink="http://www.w3.org/1999/xlink" xmlns="http://www.w3.org/2000/svg" class="zoomable" role="img" '
                           f'aria-label="{html.escape(label)}" {data}preserveAspectRatio="xMidYMid meet" viewBox="{m.group(1)}">', svg, count=1)
    for name, text in texts.items():
        escaped = html.escape(text)
        svg = svg.replace(f'<g id="{name}">', f'<g class="point" tabindex="0" data-text="{escaped}"><title>{escaped}</title>')
    return markupsafe.Markup(svg)
