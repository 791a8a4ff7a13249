"""The snow as a surface: its density on the grid, the rays of the camera, pictures and films of a run."""

import os
import shutil
import unittest

import numpy as np
from scipy.stats import norm

from mpmtools import Case
from mpmtools.figures.snow_surface import LEVEL, SMOOTHING, Camera, SnowDensity, draw, prism_hits
from study_samples import SOURCE, InFolder

SPACING = 0.1
needs_program = unittest.skipUnless("MPM" in os.environ, "needs the program: set MPM to its path (ctest does)")


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
        np.testing.assert_allclose(snow.value_at(np.array([[0.7, 1.0, 0.5], [1.3, 1.0, 0.5]])), [0.7, 1.3], atol=0.01)

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


class Solid(unittest.TestCase):
    def test_is_met_at_its_faces_only(self):
        square = [(0.0, -0.5), (1.0, -0.5), (1.0, 0.5), (0.0, 0.5)]
        eye = np.array([[-2.0, 0.0, 1.0], [-2.0, 0.7, 1.0], [0.5, 0.0, 5.0], [-2.0, 0.0, 3.5]])
        rays = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
        way, normals = prism_hits(square, 3.0, eye, rays)
        np.testing.assert_allclose(way, [2.0, np.inf, 2.0, np.inf])
        np.testing.assert_allclose(normals[[0, 2]], [[-1, 0, 0], [0, 0, 1]])


class Pictures(InFolder):
    def test_show_snow_ground_mast_and_sky_where_they_are(self):
        positions, volumes = block()
        camera = Camera([-4.0, -4.0, 3.0], [1.0, 1.0, 0.5])
        image = draw(SnowDensity(positions, volumes, SPACING), camera, (64, 48), ([(2.5, 0.5), (3.0, 0.5), (3.0, 1.0), (2.5, 1.0)], 2.0))
        self.assertEqual(image.shape, (48, 64, 3))
        self.assertTrue(np.all((image >= 0.0) & (image <= 1.0)))
        self.assertGreater(image[26, 32].min(), 0.5)  # lit snow in the middle
        self.assertGreater(image[0, 0, 2], image[-1, 0, 2])  # sky above, ground below

    @needs_program
    def test_and_films_come_from_a_run(self):
        small = {"numerics.cell_size_m": 0.875, "conveyor.width_m": 8.75, "output.duration_s": 0.4, "output.frames_per_second": 10}
        Case.read(SOURCE / "examples" / "avalanche_fr3.toml").changed(small).run(self.folder / "run", threads=1, progress=False)
        code, out, _ = self.command("film", self.folder / "run", "--time", 0.4, "--field", "speed", "--size", "160x100")
        self.assertEqual(code, 0)
        self.assertTrue((self.folder / "run" / "post" / "snow.png").read_bytes().startswith(b"\x89PNG"))
        for wrong, message in ((["--size", "161x100"], "even numbers"), (["--out", "a.gif"], "ends with .mp4"), (["--time", "0", "--out", "a.mp4"], "ends with .png")):
            code, _, err = self.command("film", self.folder / "run", *wrong)
            self.assertEqual(code, 2)
            self.assertIn(message, err)
        if shutil.which("ffmpeg"):
            self.assertEqual(self.command("film", self.folder / "run", "--size", "160x100", "--out", self.folder / "film.webm")[0], 0)
            self.assertGreater((self.folder / "film.webm").stat().st_size, 500)
