"""Figures inside a page whose points name themselves under the pointer, and which can be enlarged. No library, no network: the page holds all.

Without scripts, and in print, the figures are plain SVG; every point then has its text as a <title>.
"""

import html
import io
import re

import markupsafe

from mpmtools.figures.style import plt

STYLE = r""".figures svg { width: 100%; height: auto; display: block; }
.figures svg.zoomable { cursor: crosshair; touch-action: pan-x pan-y pinch-zoom; }
.figures svg .point:focus { outline: none; }
.tip { position: absolute; z-index: 9; max-width: min(26rem, 92vw); padding: .35rem .6rem; border-radius: 4px; background: #1c2430; color: #fff; font-size: .8rem;
  line-height: 1.4; white-space: pre-line; pointer-events: none; overflow-wrap: anywhere; }
.zoom { position: absolute; z-index: 8; border: 1px solid var(--accent); background: rgba(31, 111, 180, .12); pointer-events: none; }
@media print { .tip, .zoom, .screen { display: none; } }
"""

SCRIPT = r"""(() => {
  const reach = 22;  // px from a point at which it is named
  const element = (name) => { const e = document.createElement("div"); e.className = name; e.hidden = true; document.body.append(e); return e; };
  const tip = element("tip"), frame = element("zoom");
  const middle = (point) => { const b = point.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; };
  const show = (point) => {
    if (!point) { tip.hidden = true; return; }
    const [x, y] = middle(point);
    tip.textContent = point.dataset.text;
    tip.hidden = false;
    const left = Math.max(4, Math.min(x + 12, document.documentElement.clientWidth - tip.offsetWidth - 4));
    const above = y - tip.offsetHeight - 10;
    tip.style.left = `${left + scrollX}px`;
    tip.style.top = `${(above > 4 ? above : y + 14) + scrollY}px`;
  };
  for (const svg of document.querySelectorAll("svg.zoomable")) {
    const points = [...svg.querySelectorAll(".point")], whole = svg.getAttribute("viewBox");
    for (const p of points) {
      p.querySelector("title")?.remove();
      p.addEventListener("focus", () => show(p));
      p.addEventListener("blur", () => show(null));
    }
    const nearest = (event) => {
      let best = null, least = reach;
      for (const p of points) {
        const [x, y] = middle(p), distance = Math.hypot(x - event.clientX, y - event.clientY);
        if (distance < least) { best = p; least = distance; }
      }
      return best;
    };
    const inside = (x, y) => new DOMPoint(x, y).matrixTransform(svg.getScreenCTM().inverse());
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
        svg.setAttribute("viewBox", `${Math.min(a.x, b.x)} ${Math.min(a.y, b.y)} ${Math.abs(a.x - b.x)} ${Math.abs(a.y - b.y)}`);
      }
      start = null;
      frame.hidden = true;
    });
    svg.addEventListener("pointercancel", () => { start = null; frame.hidden = true; });
    svg.addEventListener("pointerleave", () => show(null));
    svg.addEventListener("dblclick", () => svg.setAttribute("viewBox", whole));
  }
})();
"""


def inline_svg(figure, texts, label):
    """The figure as SVG for a page.

    texts: text of every artist that was given the name (gid); label: the description for readers who cannot see it.
    """
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    plt.close(figure)
    svg = stream.getvalue()
    svg = svg[svg.index("<svg"):]
    svg = re.sub(r'<svg [^>]*?viewBox="([^"]*)"[^>]*>',
                 lambda m: f'<svg xmlns:xlink="http://www.w3.org/1999/xlink" xmlns="http://www.w3.org/2000/svg" class="zoomable" role="img" '
                           f'aria-label="{html.escape(label)}" preserveAspectRatio="xMidYMid meet" viewBox="{m.group(1)}">', svg, count=1)
    for name, text in texts.items():
        escaped = html.escape(text)
        svg = svg.replace(f'<g id="{name}">', f'<g class="point" tabindex="0" data-text="{escaped}"><title>{escaped}</title>')
    return markupsafe.Markup(svg)
