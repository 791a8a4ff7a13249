"""The interactive page of a run: what it holds; and, where Debian's chromium is installed, that a browser draws it."""

import base64
import gzip
import json
import re
import shutil
import subprocess
import unittest

from in_folder import sealed_h5
import numpy as np

from mpmtools.figures import view_page
from mpmtools.terrain import Terrain
from test_film import raster
from test_run import CASE, RunFolder

BROWSER = shutil.which("chromium")


# Added to a page: what its picture shows, as attributes of its body.
PIXELS = """
<script>
const waiting = setInterval(() => {
  if (document.body.dataset.state !== "ready") return;
  clearInterval(waiting);
  const canvas = document.querySelector("canvas"), gl = canvas.getContext("webgl2");
  const pixels = new Uint8Array(4 * canvas.width * canvas.height), rgb = (i) => pixels.subarray(i, i + 3);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let coloured = 0, cut = 0;
  for (let i = 0; i < pixels.length; i += 4) coloured += Math.max(...rgb(i)) - Math.min(...rgb(i)) > 24;
  document.body.dataset.coloured = (coloured / (pixels.length / 4)).toFixed(4);  // share of the picture that is neither white nor grey
  const white = (x, y) => { const i = 4 * (x + y * canvas.width); return pixels[i] + pixels[i + 1] + pixels[i + 2] === 765; };
  for (let x = 0; x < canvas.width; ++x) cut += !white(x, 0) + !white(x, canvas.height - 1);
  for (let y = 0; y < canvas.height; ++y) cut += !white(0, y) + !white(canvas.width - 1, y);
  document.body.dataset.cut = cut;  // pixels of the edge that show something
}, 50);
</script>
"""


def unpack(text, kind):
    return np.frombuffer(gzip.decompress(base64.b64decode(text)), kind)


class ViewFolder(RunFolder):
    """A run of two frames with 400 particles at random places."""

    COUNT = 400

    def setUp(self):
        super().setUp()
        random = np.random.default_rng(5)
        self.places = []
        for i, time in enumerate((0.0, 1.5)):
            place = random.uniform([-4.0, 0.0, 0.0], [0.0, 3.0, 2.0], size=(self.COUNT, 3))
            self.places.append(place)
            with sealed_h5(self.folder / "frames" / f"0000{i}.h5", "w") as file:
                file.attrs.update(time_s=time, mirror_x=0, mirror_y=1)
                file["id"] = np.arange(self.COUNT, dtype=np.uint64)
                file["position_m"] = place
                file["velocity_m_s"] = np.column_stack([place[:, 2], np.zeros(self.COUNT), np.zeros(self.COUNT)])
                file["pressure_pa"] = 1e3 * place[:, 2]
                file["stress_xx_pa"] = -1e3 * place[:, 2]
                file["density_kg_m3"] = np.full(self.COUNT, 300.0)

    def put_on(self, height):
        """Gives the run uneven ground. @return its raster"""
        text = raster(height, half_width=9.0)
        self.write("case.toml", CASE + f'[terrain]\nraster = "{text}"\n')
        return text

    def data(self, name="view.html"):
        text = (self.folder / name).read_text(encoding="utf-8")
        return json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', text, flags=re.DOTALL)[1])


class Pages(ViewFolder):
    def test_show_any_title_as_text(self):
        title = "<!--<script>"  # in a script element it would hide the end of that element, and with it the page
        self.write("case.toml", f"title = '{title}'\n" + CASE.split("\n", 1)[1])
        code, _, err = self.command("view", self.folder, "--out", self.folder / "view.html")
        self.assertEqual((code, self.data()["title"]), (0, title), err)
        self.assertFalse(title in (self.folder / "view.html").read_text(encoding="utf-8"))

    def test_hold_the_particles_within_their_precision(self):
        code, out, err = self.command("view", self.folder, "--out", self.folder / "view.html")
        self.assertEqual((code, out.strip()), (0, str(self.folder / "view.html")), err)
        data = self.data()
        low, high = np.array(data["low"]), np.array(data["high"])
        for frame, place in zip(data["frames"], self.places):
            found = low + unpack(frame["position"], "<u2").reshape(-1, 3) / 65535 * (high - low)
            np.testing.assert_allclose(found, place, atol=0.51 * (high - low).max() / 65535)
            fields = unpack(frame["fields"], np.uint8).reshape(len(data["fields"]), -1)
            for about, values in zip(data["fields"], fields):
                expected = {"speed": place[:, 2], "pressure": place[:, 2], "stress_xx": -place[:, 2]}.get(about["name"])
                if expected is not None:
                    clipped = np.clip(expected, about["low"], about["high"])
                    np.testing.assert_allclose(about["low"] + values / 255 * (about["high"] - about["low"]), clipped, atol=0.51 / 255 * 2.0)
        self.assertEqual(([f["time"] for f in data["frames"]], data["mirror_y"], data["mirror_x"]), ([0.0, 1.5], True, False))
        self.assertEqual(data["solids"][0]["outline"][1], [1.75, -0.875])

    def test_hold_uneven_ground_as_a_mesh_and_the_mast_on_it(self):
        terrain = Terrain(self.put_on(lambda x, y: 0.2 * x + 0.05 * y**2))
        view_page.write_view(self.folder, self.folder / "view.html")
        data = self.data()
        x, y, height = (np.array(data["ground"][name]) for name in ("x", "y", "height"))
        low, high = data["low"], data["high"]
        # The mirrored half too; three decimals.
        np.testing.assert_allclose([x[0], x[-1], y[0], y[-1]], [low[0], high[0], -high[1], high[1]], atol=6e-4)
        np.testing.assert_allclose(height, terrain.heights(x, y), atol=1e-3)  # three numbers in mm, slopes below 0.5
        self.assertEqual(height.shape, (len(y), len(x)))
        self.assertAlmostEqual(data["solids"][0]["foot"], 0.0, delta=1e-9)  # at (0, 0)
        self.assertFalse(data["floor"])

    def test_on_level_ground_have_a_floor(self):
        view_page.write_view(self.folder, self.folder / "view.html")
        data = self.data()
        self.assertEqual((data["ground"], data["floor"], data["solids"][0]["foot"]), (None, True, 0.0))

    def test_need_no_other_file_and_end_no_script_early(self):
        self.write("case.toml", (self.folder / "case.toml").read_text(encoding="utf-8").replace('"Small"', '"</script><b>x"'))
        self.command("view", self.folder)
        text = (self.folder / "post" / "view.html").read_text(encoding="utf-8")
        self.assertIsNone(re.search(r'(src|href)\s*=|url\(|import ', text))
        self.assertEqual(text.count("</script>"), 2)
        self.assertEqual(self.data("post/view.html")["title"], "</script><b>x")

    def test_of_large_runs_are_thinned_by_the_same_particles(self):
        view_page.write_view(self.folder, self.folder / "view.html", largest=200)
        data = self.data()
        self.assertEqual((data["every"], [frame["count"] for frame in data["frames"]]), (4, [100, 100]))
        self.assertAlmostEqual(data["spacing"], 0.25 * 4 ** (1 / 3))

    def test_say_what_is_wrong(self):
        for name in ("00000", "00001"):
            (self.folder / "frames" / f"{name}.h5").unlink()
        code, _, err = self.command("view", self.folder)
        self.assertEqual(code, 4)
        self.assertIn("the run stored no frames; set output.frames_per_second above 0", err)
        self.write("attempts.json", "{}")  # of a campaign's run
        for command in (["view"], ["film"], ["render"]):
            code, _, err = self.command(*command, self.folder)
            self.assertEqual(code, 4)
            self.assertIn('keep = ["frames"] in its plan; this run alone: mpm run ', err)
        code, _, err = self.command("view", self.folder, "--particles", 5)
        self.assertEqual(code, 2)
        self.assertIn("argument --particles: '5': give a whole number from 1000", err)
        case = (self.folder / "case.toml").read_text()
        code, _, err = self.command("view", self.folder, "--out", self.folder / "case.toml")
        self.assertEqual(code, 2)
        self.assertIn("the name has to end with .html", err)
        self.assertEqual((self.folder / "case.toml").read_text(), case)


@unittest.skipUnless(BROWSER, "needs Debian's chromium")
class Browser(ViewFolder):
    def opened(self, path, begin=""):
        """What a page and its picture are in headless Chromium, drawn by the processor. @param begin  of the page, such as #frame=1"""
        page = path.read_text(encoding="utf-8").replace("{ antialias: true }", "{ antialias: true, preserveDrawingBuffer: true }")
        self.write("opened.html", page + PIXELS)
        done = subprocess.run([BROWSER, "--headless=new", "--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader",
                               "--enable-unsafe-swiftshader", "--window-size=600,500", "--virtual-time-budget=20000",
                               f"--user-data-dir={self.folder / 'profile'}", "--dump-dom", f"file://{self.folder}/opened.html{begin}"],
                              capture_output=True, text=True, timeout=120, check=False)
        body = re.search(r"<body([^>]*)>", done.stdout)
        self.assertIsNotNone(body, done.stderr[-2000:])
        shown = re.search(r'<output id="shown">([^<]*)', done.stdout)
        return dict(re.findall(r'data-(\w+)="([^"]*)"', body[1])), shown and shown[1], done.stdout

    def test_draws_the_frame_that_is_asked_for(self):
        path = view_page.write_view(self.folder, self.folder / "view.html")
        state, shown, page = self.opened(path, "#frame=1&field=pressure")
        self.assertEqual((state["state"], state["frame"], state["particles"], shown), ("ready", "1", "400", "1.50 s"), page[-500:])
        self.assertGreater(float(state["coloured"]), 0.02)  # of the picture
        self.assertIn("pressure (kPa)", page)
        self.assertEqual(state["cut"], "0")  # flow and mast are inside the picture

    def test_draws_uneven_ground_at_its_height(self):
        shares = []
        for height in (-1.0, 2.0):  # below the particles, and as a roof over them
            self.put_on(lambda x, y: height)
            state, _, _ = self.opened(view_page.write_view(self.folder, self.folder / "view.html"))
            self.assertEqual((state["state"], state["particles"]), ("ready", "400"))
            shares.append(float(state["coloured"]))
        self.assertLess(shares[1], 0.8 * shares[0])  # of three sides that the camera sees, the roof hides one

    def test_shows_nothing_coloured_where_nothing_is(self):
        for i in (0, 1):
            with sealed_h5(self.folder / "frames" / f"0000{i}.h5", "a") as file:
                for name in list(file):
                    values = file[name][:1]
                    del file[name]
                    file[name] = values
        state, _, _ = self.opened(view_page.write_view(self.folder, self.folder / "view.html"))
        self.assertEqual(state["particles"], "1")
        self.assertLess(float(state["coloured"]), 0.02)


if __name__ == "__main__":
    unittest.main()
