"""An interactive page of a run: its particles in three dimensions, to be turned, played and coloured. One file, without a library or a network.

Positions are stored with 16 bits in the box of the run, fields with 8 bits in their range; frames are compressed. A run with many particles is
thinned: every n-th particle of the order of identity numbers, the same ones in all frames.
"""

import base64
import gzip
import json
import pathlib

import jinja2
import numpy as np

from mpmtools.figures.colours import STRESS_COLOURS, colour_range
from mpmtools.files import require_ending, write_text
from mpmtools.run import Run
from mpmtools.terrain import terrain_of

LARGEST = 6_000_000  # particles in all frames together: about 60 MB before compression
# Name, unit, array of a frame, factor.
FIELDS = {
    "speed": ("speed", "m/s", "velocity_m_s", 1.0),
    "pressure": ("pressure", "kPa", "pressure_pa", 1e-3),
    "stress_xx": ("stream-wise stress", "kPa", "stress_xx_pa", 1e-3),
    "density": ("density", "kg/m³", "density_kg_m3", 1.0),
}


def field_values(frame, name):
    """A field of a frame in the unit of FIELDS."""
    *_, array, factor = FIELDS[name]
    values = frame[array]
    return factor * (np.linalg.norm(values, axis=1) if values.ndim == 2 else values.astype(float))


def kept(frame, every):
    """Which particles of a frame are shown."""
    return frame["id"] % np.uint64(every) == 0


def packed(array):
    """A compressed array as text for the page."""
    return base64.b64encode(gzip.compress(array.tobytes(), compresslevel=6, mtime=0)).decode()


def quantized(values, low, high, top):
    """Whole numbers 0 ... top for low ... high."""
    return np.clip(np.rint((values - low) / (high - low) * top), 0, top)


def page_data(run, largest=LARGEST):
    """What the page holds, as a dict: see view_page.html.j2."""
    frames = run.require_frames()
    counts = [len(frame["id"]) for frame in frames]
    every = max(1, -(-sum(counts) // largest))
    low = np.min([frame["position_m"].min(axis=0) for frame in frames if len(frame["id"])], axis=0)
    high = np.max([frame["position_m"].max(axis=0) for frame in frames if len(frame["id"])], axis=0)
    high = np.maximum(high, low + 1e-6)
    ranges, stored, ground = {}, [], None
    for name in FIELDS:
        values = np.concatenate([field_values(frame, name)[kept(frame, every)] for frame in frames])
        ranges[name] = colour_range(values[np.isfinite(values)], name)
    for frame in frames:
        chosen = kept(frame, every)
        position = quantized(frame["position_m"][chosen], low, high, 65535).astype("<u2")
        values = np.stack([quantized(field_values(frame, name)[chosen], *ranges[name], 255) for name in FIELDS]).astype(np.uint8)
        stored.append({"time": frame.time, "count": int(chosen.sum()), "position": packed(position), "fields": packed(values)})
    attributes = frames[-1].attributes
    mirror_x, mirror_y = (bool(attributes.get(name)) for name in ("mirror_x", "mirror_y"))
    terrain = terrain_of(run)
    if terrain:  # height[j][i] at x[i], y[j], to the mm, m
        corner = -high[0] if mirror_x else low[0], -high[1] if mirror_y else low[1]
        ground = dict(zip(("x", "y", "height"), (values.round(3).tolist() for values in terrain.mesh(corner, high[:2]))))
    solids = [{"outline": [list(corner) for corner in corners], "foot": foot, "top": top}
              for corners, foot, top in run.solids(terrain.foot(run.obstacle_outline) if terrain and run.obstacle else 0.0, 1.15 * float(high[2]))]
    ramp = [[round(255 * c) for c in STRESS_COLOURS(i / 255)[:3]] for i in range(256)]  # from strong compression, a low value, to none
    return {"title": run.title, "low": low.tolist(), "high": high.tolist(), "spacing": run.particle_spacing * every ** (1.0 / 3.0),
            "every": every, "mirror_x": mirror_x, "mirror_y": mirror_y, "frames": stored,
            "fields": [{"name": name, "label": label, "unit": unit, "low": ranges[name][0], "high": ranges[name][1],
                        "colours": ramp if name == "stress_xx" else ramp[::-1]} for name, (label, unit, *_) in FIELDS.items()],
            "solids": solids, "ground": ground,
            "floor": terrain is None and (run.flow_height is not None or bool(run.case.get("wall")))}


def write_view(folder, out=None, largest=LARGEST):
    """Writes the page of a run (default: DIR/post/view.html). Returns its path."""
    run = Run(folder)
    out = pathlib.Path(out) if out else pathlib.Path(folder) / "post" / "view.html"
    template = jinja2.Environment(autoescape=True).from_string(pathlib.Path(__file__).with_name("view_page.html.j2").read_text(encoding="utf-8"))
    data = json.dumps(page_data(run, largest)).replace("<", "\\u003c")  # nothing in it is read as HTML
    text = template.render(title=run.title or "run", data=data)
    write_text(out, text)
    return out


def run_command(options):
    if options.out:
        require_ending(options.out, ".html")
    print(write_view(options.directory, options.out, options.particles))
