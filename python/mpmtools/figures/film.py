"""Pictures of a run with the snow as a surface, and films of them: python3 -m mpmtools film DIR."""

import os
import shutil
import subprocess
import tempfile

import numpy as np

from mpmtools.errors import ConfigError, InputError
from mpmtools.files import require_ending, save_figure, whole_file
from mpmtools.figures.snow_surface import LevelGround, SnowDensity, UnevenGround, draw, standpoint
from mpmtools.figures.view_3d import picture_size
from mpmtools.run import Run
from mpmtools.terrain import terrain_of

FIELDS = {  # label, values of the particles of a frame, with the mirrored half, in its unit; None for white snow
    "snow": ("", None),
    "speed": ("speed (m/s)", lambda frame: np.linalg.norm(frame.whole("velocity_m_s"), axis=1)),
    "pressure": ("Cauchy pressure (kPa)", lambda frame: 1e-3 * frame.whole("pressure_pa")),
}
CODECS = {".mp4": ["libx264", "-preset", "slow", "-pix_fmt", "yuv420p", "-movflags", "+faststart"],
          ".webm": ["libvpx-vp9", "-row-mt", "1", "-pix_fmt", "yuv420p"]}


class Studio:
    """What all pictures of a run share: ground, camera, mast, range of the colours. @param frames  of the run, which hold snow"""

    def __init__(self, run, frames, field, size):
        self.run, self.size, (self.label, self.values_of) = run, size, FIELDS[field]
        terrain = terrain_of(run)
        self.ground = UnevenGround(terrain) if terrain else LevelGround()
        some = [f["position_m"] for f in frames[:: max(1, len(frames) // 8)]]
        top = max(float(np.percentile(x[:, 2] - self.ground.height(x[:, :2]), 99.9)) for x in some)
        self.camera, self.solids = standpoint(run, frames[-1].whole("position_m"), top, self.ground)
        self.most = max(1e-9, *(float(np.percentile(self.values_of(f), 99.0)) for f in frames)) if self.values_of else 1.0

    def picture(self, frame, path):
        """Draws a frame into a PNG file."""
        from matplotlib import colormaps
        from matplotlib import pyplot as plt

        run = self.run
        values = self.values_of and self.values_of(frame)
        snow = SnowDensity(frame.whole("position_m"), frame.whole("reference_volume_m3"), run.particle_spacing, values)
        colours = None if values is None else lambda v: colormaps["viridis"](np.clip(v / self.most, 0.0, 1.0))[:, :3]
        width, height = self.size
        image = draw(snow, self.camera, self.size, self.solids, colours, self.ground)
        figure = plt.figure(figsize=(width / 100.0, height / 100.0), dpi=100)
        figure.figimage(image, resize=False, zorder=-1)
        unit = height / 600.0
        figure.text(0.02, 0.955, run.title, fontsize=11 * unit, color="#1c2733", va="center")
        figure.text(0.98, 0.955, f"t = {frame.time:.2f} s", fontsize=11 * unit, color="#1c2733", va="center", ha="right", family="monospace")
        if values is not None:
            axes = figure.add_axes((0.03, 0.07, 0.26, 0.02), zorder=5)
            axes.imshow(np.linspace(0.0, 1.0, 256)[None, :], aspect="auto", cmap="viridis", extent=(0.0, self.most, 0.0, 1.0))
            axes.set_yticks([])
            axes.set_title(self.label, fontsize=9 * unit, color="#1c2733", loc="left", pad=4)
            axes.tick_params(labelsize=8 * unit, colors="#1c2733")
        save_figure(figure, path, dpi=100)


def encode(folder, frames_per_second, path, kilobits):
    """PNG files 00000.png ... of a folder into a film."""
    done = subprocess.run(["ffmpeg", "-y", "-loglevel", "error", "-framerate", f"{frames_per_second:g}", "-i", os.path.join(folder, "%05d.png"),
                           "-c:v", *CODECS[os.path.splitext(path)[1].lower()], "-b:v", f"{kilobits:d}k", path], stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, check=False)
    if done.returncode != 0:
        raise InputError(f"ffmpeg could not write the film: {done.stderr.strip()}")


def run_command(options):
    run = Run(options.directory)
    frames = [frame for frame in run.require_frames() if len(frame["position_m"])]
    if not frames:
        raise InputError(f"{options.directory}: no frame holds snow")
    size = picture_size(options.size)
    if any(n % 2 for n in size):
        raise ConfigError(f"--size {options.size}: even numbers of pixels are needed, such as 960x600")
    single = options.time is not None
    if not single and len(frames) < 2:
        raise InputError(f"{options.directory}: there is one frame, and a film needs two; take its picture with --time {frames[0].time:g}, or let the run "
                         "write more ([output] frames_per_second)")
    path = options.out or os.path.join(options.directory, "post", "snow.png" if single else "film.mp4")
    require_ending(path, *([".png"] if single else CODECS))
    if not single and not shutil.which("ffmpeg"):
        raise InputError("ffmpeg is missing; install Debian's ffmpeg, or take single pictures with --time")
    with whole_file(path) as temporary:  # first: that it cannot be written is found before the work
        studio = Studio(run, frames, options.field, size)
        if single:
            studio.picture(min(frames, key=lambda f: abs(f.time - options.time)), temporary)
        else:
            rate = (len(frames) - 1) / max(frames[-1].time - frames[0].time, 1e-9) * options.slow
            with tempfile.TemporaryDirectory() as folder:
                for number, frame in enumerate(frames):
                    studio.picture(frame, os.path.join(folder, f"{number:05d}.png"))
                encode(folder, rate, temporary, options.kilobits)
    print(path)
