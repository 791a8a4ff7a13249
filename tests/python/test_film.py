"""The snow as a surface: its density on the grid, the rays of the camera, pictures and films of a run."""

import os
import shutil
import unittest
import unittest.mock

import numpy as np
from scipy.stats import norm

from mpmtools import Case
from mpmtools.figures.snow_surface import (LEVEL, SMOOTHING, Camera, LevelGround, SnowDensity, UnevenGround, draw,
                                           nearest_hits, prism_hits, standpoint)
from mpmtools.terrain import Terrain
from in_folder import sealed_h5
from study_samples import SOURCE, InFolder

SPACING = 0.1
needs_program = unittest.skipUnless("MPM" in os.environ, "needs the program: set MPM to its path (ctest does)")


def raster(height, half_width=8.0, spacing=0.5):
    """The text of [terrain] raster of a function height(x, y) over a square around the origin."""
    x = np.arange(-half_width, half_width + 0.5 * spacing, spacing)
    rows = [" ".join(f"{height(a, b):.17g}" for a in x) for b in x[::-1]]
    return f"ncols {len(x)} nrows {len(x)} xllcenter {x[0]} yllcenter {x[0]} cellsize {spacing} " + " ".join(rows)


def hill(x, y):
    """1 m high, 21 degrees steep."""
    return np.exp(-(x**2 + y**2) / (2.0 * 1.6**2))


def tilted(x, y):
    return 0.4 * x - 0.3 * y + 1.0


def block(nx=20, ny=20, nz=10):
    """Particles of a full block from the origin, and their volumes."""
    axes = [SPACING * (np.arange(n) + 0.5) for n in (nx, ny, nz)]
    positions = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return positions, np.full(len(positions), SPACING**3)


class Density(unittest.TestCase):
    def test_holds_the_mass_and_is_one_inside(self):
        positions, volumes = block()
        snow = SnowDensity(positions, volumes, SPACING)
        self.assertAlmostEqual(float(snow.density.sum()) * snow.cell**3, volumes.sum(), places=5)
        inside = np.array([[1.0, 1.0, 0.5], [0.8, 1.1, 0.4]])
        np.testing.assert_allclose(snow.at(inside), 1.0, atol=0.06)  # the lattice is not that of the grid

    def test_carries_a_property_of_the_particles(self):
        positions, volumes = block()
        snow = SnowDensity(positions, volumes, SPACING, values=positions[:, 0])
        np.testing.assert_allclose(snow.at(np.array([[0.7, 1.0, 0.5], [1.3, 1.0, 0.5]]), "values"), [0.7, 1.3], atol=0.01)

    def test_has_its_surface_where_the_block_ends_and_its_normals_outwards(self):
        positions, volumes = block()
        snow = SnowDensity(positions, volumes, SPACING)
        eye, rays = np.array([[1.0, 1.0, 5.0], [-4.0, 1.0, 0.5]]), np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
        way = snow.hits(eye, rays, 0.0, np.full(2, 20.0))
        # A step of the density, smoothed by the quadratic B-spline (variance 1/4 cell^2) and a Gaussian, falls to LEVEL outside the block
        outside = -norm.ppf(LEVEL) * np.hypot(0.5, SMOOTHING) * snow.cell
        np.testing.assert_allclose(way, 4.0 - outside, atol=0.1 * snow.cell)  # linear between nodes
        points = eye + way[:, None] * rays
        np.testing.assert_allclose(snow.at(points), LEVEL, atol=0.05)
        np.testing.assert_allclose(snow.normals(points), [[0, 0, 1], [-1, 0, 0]], atol=0.02)
        self.assertFalse(np.isfinite(snow.hits(eye, -rays, 0.0, np.full(2, 20.0))).any())


    def test_leaves_out_lumps_of_a_few_particles(self):
        snow, _ = block()
        for side, remains in ((2, False), (4, True)):  # 8 and 64 particles, and LUMP is between
            lump = block(side, side, side)[0] + [1.0, 1.0, 3.0]
            both = SnowDensity(np.concatenate([snow, lump]), np.full(len(snow) + len(lump), SPACING**3), SPACING)
            middle = lump.mean(axis=0)
            self.assertEqual(bool(both.at(middle[None])[0] > LEVEL), remains, side)
            self.assertGreater(both.at(np.array([[1.0, 1.0, 0.5]]))[0], LEVEL)

    def test_keeps_a_thread_of_four_particles_across_whole(self):
        thread = block(2, 2, 40)[0]
        snow = SnowDensity(thread, np.full(len(thread), SPACING**3), SPACING)
        self.assertGreater(snow.at(np.array([[SPACING, SPACING, z] for z in np.linspace(0.3, 3.7, 50)])).min(), LEVEL)


class Heights(unittest.TestCase):
    """Between the points of a raster: those of libmpm/boundary/terrain.hpp."""

    def test_pass_through_the_points_and_follow_a_plane_beyond_them(self):
        terrain = Terrain(raster(tilted))
        np.testing.assert_allclose(terrain.heights(terrain.x, terrain.y), terrain.height, atol=1e-14)
        x, y = np.array([-9.3, -7.77, 0.1, 8.2]), np.array([-8.4, 0.33, 9.0])
        np.testing.assert_allclose(terrain.heights(x, y), tilted(x[None, :], y[:, None]), atol=1e-13)  # round-off

    def test_are_keys_kernel_inside(self):
        def kernel(s):  # Keys 1981, Eq. 4, a = -1/2
            s = np.abs(s)
            near, far = 1.5 * s**3 - 2.5 * s**2 + 1.0, -0.5 * s**3 + 2.5 * s**2 - 4.0 * s + 2.0
            return np.where(s < 1.0, near, np.where(s < 2.0, far, 0.0))

        terrain = Terrain(raster(lambda x, y: np.sin(1.3 * x) + np.cos(x + 2.0 * y)))
        x, y = np.array([-3.14, 0.2, 5.71]), np.array([-6.9, 1.05])
        along_x, along_y = (kernel((at[:, None] - points) / 0.5) for at, points in ((x, terrain.x), (y, terrain.y)))
        expected = along_y @ terrain.height @ along_x.T
        np.testing.assert_allclose(terrain.heights(x, y), expected, atol=1e-13)  # round-off

    def test_are_a_mesh_of_limited_size(self):
        terrain = Terrain(raster(hill))
        x, y, height = terrain.mesh((-1.0, 0.0), (1.0, 8.0))
        self.assertEqual((len(x), len(y), height.shape), (17, 65, (65, 17)))  # four intervals in one of 0.5 m
        self.assertEqual((x[0], x[-1], y[0], y[-1]), (-1.0, 1.0, 0.0, 8.0))
        self.assertEqual(len(Terrain(raster(hill, spacing=0.1)).mesh((-8.0, -8.0), (8.0, 8.0))[0]), 161)

    def test_give_a_solid_its_foot(self):
        box = [(0.0, -1.0), (2.0, -1.0), (2.0, 1.0), (0.0, 1.0)]
        self.assertAlmostEqual(Terrain(raster(tilted)).foot(box), 0.7)  # at (0, 1)


class Ground(unittest.TestCase):
    def eyes_above(self, places):
        return np.column_stack([places, np.full(len(places), 6.0)])

    def test_that_is_tilted_is_met_at_its_height_from_everywhere(self):
        ground = UnevenGround(Terrain(raster(tilted)))
        random = np.random.default_rng(3)
        target = random.uniform(-6.0, 6.0, (500, 2))
        points = np.column_stack([target, tilted(*target.T)])
        eye = points + random.normal(size=points.shape) * [2.0, 2.0, 1.0]
        eye[:, 2] += np.maximum(0.0, tilted(*eye[:, :2].T) - eye[:, 2]) + 0.05  # above the ground
        inside = np.all(np.abs(eye[:, :2]) < 8.0, axis=1)
        eye, points = eye[inside], points[inside]
        way = np.linalg.norm(points - eye, axis=1)
        # Bilinear faces are exact for a plane. Bisection ends at a millionth of the last step, a metre or so at most.
        np.testing.assert_allclose(ground.hits(eye, (points - eye) / way[:, None], 100.0), way, atol=5e-6)
        normal = np.array([-0.4, 0.3, 1.0]) / np.sqrt(1.25)
        np.testing.assert_allclose(ground.normals(points), np.broadcast_to(normal, points.shape), atol=1e-12)

    def test_with_a_hill_is_met_at_its_height(self):
        ground = UnevenGround(Terrain(raster(hill)))
        places = np.random.default_rng(4).uniform(-6.0, 6.0, (300, 2))
        eye = self.eyes_above(places)
        way = ground.hits(eye, np.broadcast_to([0.0, 0.0, -1.0], eye.shape), 100.0)
        # A cubic through points h = 0.5 m apart is off by some 3/128 h^4 of the fourth derivative, 3/1.6^4, which
        # is 7e-4 m along each axis; faces h/4 wide by 1/8 (h/4)^2 of the second, 1/1.6^2: 8e-4 m along each axis.
        np.testing.assert_allclose(way, 6.0 - hill(*places.T), atol=3e-3)

    def test_hides_what_is_behind_a_hill(self):
        ground = UnevenGround(Terrain(raster(hill)))
        eye, ray = np.array([[-7.0, 0.0, 0.8]]), np.array([[1.0, 0.0, 0.0]])
        way = ground.hits(eye, ray, 100.0)[0]
        expected = 7.0 - 1.6 * np.sqrt(-2.0 * np.log(0.8))
        self.assertAlmostEqual(way, expected, delta=0.01)  # a height error of 3 mm over a slope of 0.33
        self.assertEqual(ground.hits(eye + [[0.0, 0.0, 0.3]], ray, 100.0)[0], np.inf)  # over the top, 1 m
        self.assertEqual(ground.hits(eye, -ray, 100.0)[0], np.inf)

    def test_that_is_even_is_the_plane(self):
        rays = Camera([-4.0, -4.0, 3.0], [1.0, 1.0, 0.5]).rays(64, 48)
        eye = np.broadcast_to([-4.0, -4.0, 3.0], rays.shape)
        level = LevelGround().hits(eye, rays, 60.0)
        near = level < 60.0
        self.assertGreater(near.sum(), 1000)
        even = UnevenGround(Terrain(raster(lambda x, y: 0.0)))
        np.testing.assert_allclose(even.hits(eye, rays, 60.0)[near], level[near], atol=1e-12)
        np.testing.assert_array_equal(even.normals(eye), LevelGround().normals(eye))

    def test_leaves_the_flow_before_a_mast_whole_at_the_lower_edge(self):
        class Flow:
            obstacle, obstacle_width, obstacle_depth, flow_height = {"height_m": 10.0}, 1.75, 1.75, 1.75

            @staticmethod
            def solids(*_):
                return []

        x, y = np.meshgrid(np.linspace(-8.4, 4.2, 40), np.linspace(-10.5, 10.5, 60))
        flow = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.1)], axis=1)
        for top in (4.0, 9.0):
            self.assertLessEqual(standpoint(Flow, flow, top)[0].share_below(flow), 0.01)  # the nearest corner

    def test_moves_the_camera_above_a_hill(self):
        class Flow:
            obstacle = None

            @staticmethod
            def solids(*_):
                return []

        positions = np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]])
        level, _ = standpoint(Flow, positions, 1.0)
        # A terrace 4 m high between the snow and the camera.
        wall = UnevenGround(Terrain(raster(lambda x, y: 4.0 / (1.0 + np.exp(2.0 * (x + y + 3.0))))))
        camera, _ = standpoint(Flow, positions, 1.0, wall)
        for seen, view in ((False, level), (True, camera)):
            to_the_snow = np.hypot(*view.eye[:2]) / np.hypot(*view.forward[:2])  # its middle is at x = y = 0
            self.assertEqual(wall.hits(view.eye[None], view.forward[None], 100.0)[0] > to_the_snow, seen)


class Solid(unittest.TestCase):
    def test_is_met_at_its_faces_only(self):
        square = [(0.0, -0.5), (1.0, -0.5), (1.0, 0.5), (0.0, 0.5)]
        eye = np.array([[-2.0, 0.0, 1.0], [-2.0, 0.7, 1.0], [0.5, 0.0, 5.0], [-2.0, 0.0, 3.5], [-2.0, 0.0, 0.4], [0.5, 0.0, 0.1]])
        rays = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        way, normals = prism_hits(square, 0.5, 3.0, eye, rays)
        np.testing.assert_allclose(way, [2.0, np.inf, 2.0, np.inf, np.inf, 0.4])
        np.testing.assert_allclose(normals[[0, 2, 5]], [[-1, 0, 0], [0, 0, 1], [0, 0, -1]])

    def test_of_several_the_nearest_is_met(self):
        boxes = [([(x, -0.5), (x + 1.0, -0.5), (x + 1.0, 0.5), (x, 0.5)], 0.0, top) for x, top in ((3.0, 9.0), (1.0, 2.0))]
        way, normals = nearest_hits(boxes, np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 3.0]]), np.array([[1.0, 0.0, 0.0]] * 2))
        np.testing.assert_allclose(way, [1.0, 3.0])
        np.testing.assert_allclose(normals, [[-1.0, 0.0, 0.0]] * 2)


class Pictures(InFolder):
    def test_show_snow_ground_mast_and_sky_where_they_are(self):
        positions, volumes = block()
        camera = Camera([-4.0, -4.0, 3.0], [1.0, 1.0, 0.5])
        image = draw(SnowDensity(positions, volumes, SPACING), camera, (64, 48), [([(2.5, 0.5), (3.0, 0.5), (3.0, 1.0), (2.5, 1.0)], -1.0, 2.0)])
        self.assertEqual(image.shape, (48, 64, 3))
        self.assertTrue(np.all((image >= 0.0) & (image <= 1.0)))
        self.assertGreater(image[26, 32].min(), 0.5)  # lit snow in the middle
        self.assertGreater(image[0, 0, 2], image[-1, 0, 2])  # sky above, ground below

    def test_show_uneven_ground_where_it_is(self):
        positions, volumes = block()
        snow = SnowDensity(positions, volumes, SPACING)
        def red_snow(values):
            return np.tile([1.0, 0.0, 0.0], (len(values), 1))

        camera, pictures = Camera([-6.0, 0.0, 2.0], [1.0, 0.0, 1.0]), []
        for height in (0.0, 1.9):  # of a ridge between the camera and the block, which is 1 m high
            ground = UnevenGround(Terrain(raster(lambda x, y: height * np.exp(-((x + 2.0) ** 2)))))
            pictures.append(draw(snow, camera, (64, 48), colours=red_snow, ground=ground))
        red = [int((image[..., 0] > 2.0 * image[..., 2]).sum()) for image in pictures]
        self.assertGreater(red[0], 100)
        self.assertEqual(red[1], 0)

    @needs_program
    def test_and_films_come_from_a_run(self):
        small = {"numerics.cell_size_m": 0.875, "conveyor.width_m": 8.75, "output.duration_s": 0.4, "output.frames_per_second": 10}
        Case.read(SOURCE / "examples" / "avalanche_fr3.toml").changed(small).run(self.folder / "run", threads=1, progress=False)
        code, out, _ = self.command("film", self.folder / "run", "--time", 0.4, "--field", "speed", "--size", "160x100")
        self.assertEqual(code, 0)
        self.assertTrue((self.folder / "run" / "post" / "snow.png").read_bytes().startswith(b"\x89PNG"))
        for wrong, message in ((["--size", "161x100"], "even numbers"), (["--out", "a.gif"], "end with .mp4 or .webm"), (["--time", "0", "--out", "a.mp4"], "end with .png"),
                               (["--time", "nan"], "'nan': give a number"), (["--time", "inf"], "'inf': give a number"), (["--slow", "0"], "from 0.001 to 1000"),
                               (["--slow", "nan"], "from 0.001"), (["--kilobits", "0"], "give a whole number from 1 to"), (["--size", "8x8"], "from 16 to 8192 pixels")):
            code, _, err = self.command("film", self.folder / "run", *wrong)
            self.assertEqual(code, 2)
            self.assertIn(message, err)
        with unittest.mock.patch("mpmtools.figures.film.Studio") as studio:
            code, _, err = self.command("film", self.folder / "run", "--time", "0", "--out", "/proc/snow.png")
        self.assertEqual(code, 4)
        self.assertIn("cannot write '/proc/snow.png'", err)
        studio.assert_not_called()  # minutes of drawing for nothing
        if shutil.which("ffmpeg"):
            self.assertEqual(self.command("film", self.folder / "run", "--size", "160x100", "--out", self.folder / "film.webm")[0], 0)
            self.assertEqual(self.command("film", self.folder / "run", "--size", "160x100", "--out", self.folder / "FILM.MP4")[0], 0)
            self.assertTrue(all((self.folder / name).stat().st_size > 500 for name in ("film.webm", "FILM.MP4")))

    @needs_program
    def test_leave_out_frames_that_all_snow_has_left(self):
        small = {"numerics.cell_size_m": 0.875, "conveyor.width_m": 8.75, "output.duration_s": 0.1, "output.frames_per_second": 10}
        run = Case.read(SOURCE / "examples" / "avalanche_fr3.toml").changed(small).run(self.folder / "run", threads=1, progress=False)
        arrays, attributes = {name: run.frames[-1][name][:0] for name in run.frames[-1]}, run.frames[-1].attributes
        os.unlink(run.frames[-1].path)
        with sealed_h5(run.frames[-1].path, "w") as file:
            file.attrs.update(attributes)
            for name, array in arrays.items():
                file[name] = array
        code, _, err = self.command("film", run.folder, "--time", attributes["time_s"], "--size", "160x100")
        self.assertEqual((code, err), (0, ""))
        os.unlink(run.frames[0].path)
        code, _, err = self.command("film", run.folder, "--time", 0, "--size", "160x100")
        self.assertEqual((code, err), (4, f"mpmtools film: {run.folder}: no frame holds snow\n"))

    @needs_program
    def test_of_one_frame_are_no_film(self):
        small = {"numerics.cell_size_m": 0.875, "conveyor.width_m": 8.75, "output.duration_s": 0.1, "output.frames_per_second": 0.5}
        run = Case.read(SOURCE / "examples" / "avalanche_fr3.toml").changed(small).run(self.folder / "run", threads=1, progress=False)
        self.assertEqual(len(run.frames), 1)
        with unittest.mock.patch("shutil.which", return_value="ffmpeg"):
            code, _, err = self.command("film", self.folder / "run", "--size", "160x100")
        self.assertEqual(code, 4)
        self.assertIn("there is one frame, and a film needs two; take its picture with --time 0,", err)
        self.assertFalse((self.folder / "run" / "post").exists())
        self.assertEqual(self.command("film", self.folder / "run", "--size", "160x100", "--time", "0")[0], 0)
