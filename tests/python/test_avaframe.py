"""Rasters of AvaFrame's com1DFA as the inflow of a case, on a synthetic slope in its file format."""

import importlib.util
import json
import math
import os
import subprocess
import tomllib
import unittest

import numpy as np

from mpmtools import Case, avaframe
from mpmtools.errors import ConfigError, InputError
from mpmtools.inflow import measured_inflow
from study_samples import InFolder

needs_program = unittest.skipUnless("MPM" in os.environ, "needs the program: set MPM to its path (ctest does)")
needs_rasterio = unittest.skipUnless(importlib.util.find_spec("rasterio"), "needs Debian's python3-rasterio")

CELL, ROWS, COLUMNS, X0, Y0 = 5.0, 21, 41, 1000.0, 2000.0


class Avalanche(InFolder):
    """A plane that falls 1 in 4 to the east, and a flow that passes x at t = (x - 1000)/20 s: triangle of 4 s, 2 m deep, 20 m/s."""

    def setUp(self):
        super().setUp()
        (self.folder / "Inputs").mkdir()
        self.steps = self.folder / "Outputs" / "com1DFA" / "peakFiles" / "timeSteps"
        self.steps.mkdir(parents=True)
        self.x, self.y = np.meshgrid(X0 + CELL * np.arange(COLUMNS), Y0 + CELL * np.arange(ROWS)[::-1])
        self.raster(self.folder / "Inputs" / "dem.asc", 500.0 - 0.25 * (self.x - X0))
        for time in range(16):
            depth = np.maximum(0.0, 2.0 - np.abs(time - 2.0 - (self.x - X0) / 20.0))
            self.raster(self.steps / f"rel1_null_dfa_FT_t{time:.2f}.asc", depth)
            self.raster(self.steps / f"rel1_null_dfa_FV_t{time:.2f}.asc", 20.0 * (depth > 0))

    def raster(self, path, data):
        head = f"ncols {COLUMNS}\nnrows {ROWS}\nxllcenter {X0}\nyllcenter {Y0}\ncellsize {CELL}\nnodata_value -9999.00\n"
        path.write_text(head + "\n".join(" ".join(f"{v:.5f}" for v in row) for row in data) + "\n")

    def convert(self, **changes):
        arguments = {"folder": str(self.folder), "x": 1100.0, "y": 2050.0, "width": 1.0, "out": str(self.folder / "case"), **changes}
        return avaframe.import_avalanche(**arguments)

    def test_gives_depth_and_speed_over_time_at_the_point(self):
        self.convert()
        rows = np.genfromtxt(self.folder / "case" / "inflow.csv", delimiter=",", names=True)
        np.testing.assert_allclose(rows["depth_m"], [1.0, 2.0, 1.0])  # the front is there at 5 s, the middle at 7 s; t = 0 at the first row
        np.testing.assert_allclose(rows["time_s"], [0.0, 1.0, 2.0])
        np.testing.assert_allclose(rows["velocity_m_s"], 20.0)

    def test_takes_the_slope_from_the_terrain(self):
        lines = self.convert()
        self.assertIn("slope 14.0 degrees, falling towards 0 degrees", lines[1])  # atan(1/4)
        self.assertIn(f"gravity_m_s2 = {9.81 * math.cos(math.atan(0.25)):.6g}", (self.folder / "case" / "case.toml").read_text())
        self.assertIn("less than 0.01 m from a plane", lines[2])

    def test_says_how_uneven_the_ground_is(self):
        self.raster(self.folder / "Inputs" / "dem.asc", 500.0 - 0.25 * (self.x - X0) + 1.0 * (np.abs(self.x - 1080.0) < 3.0))
        step = self.convert()[2]
        self.assertIn("up to 0.9", step)  # a ridge of 1 m on one of eleven rows: the plane takes 1/11 of it

    def uneven(self, relief):
        """A slope that falls 1 in 4 to the north-west, and a wave along and across it."""
        east, north = self.x - 1100.0, self.y - 2050.0
        wave = relief * np.sin(east / 9.0) * np.cos(north / 7.0)
        self.raster(self.folder / "Inputs" / "dem.asc", 500.0 + 0.25 * (east - north) / math.sqrt(2.0) + wave)

    def terrain(self):
        return avaframe.read_raster(str(self.folder / "case" / "terrain.asc"))

    def test_gives_the_case_the_terrain_where_it_is_uneven(self):
        self.uneven(0.1)
        self.assertIn("the run takes a plane", self.convert()[2])  # a wave of 0.1 m under a flow of 2 m
        self.assertFalse((self.folder / "case" / "terrain.asc").exists())
        self.uneven(1.0)
        self.assertIn("the run takes terrain.asc", self.convert()[2])
        case = Case.read(self.folder / "case" / "case.toml")
        self.assertEqual((case["terrain.file"], case["conveyor.sidewall_contact"], case["conveyor.mirror_y"]), ("terrain.asc", "slip", False))
        self.assertLess(self.terrain().x0, -50.0)
        self.assertNotIn("terrain", Case.read(self.converted_without()).tables)

    def converted_without(self):
        self.convert(out=str(self.folder / "plane"), terrain=False)
        return self.folder / "plane" / "case.toml"

    def test_turns_the_terrain_into_the_frame_of_the_flow(self):
        self.uneven(1.0)
        self.convert()
        ground = avaframe.ground_at(avaframe.read_raster(str(self.folder / "Inputs" / "dem.asc")), 1100.0, 2050.0)
        slope, direction = ground.mean_slope, ground.mean_direction
        self.assertAlmostEqual(math.degrees(direction) % 360.0, 135.0, delta=10.0)  # north-west; the wave turns the plane a little
        dem, raster = avaframe.read_raster(str(self.folder / "Inputs" / "dem.asc")), self.terrain()
        self.assertAlmostEqual(raster.at(0.0, 0.0), 0.0, delta=0.15)  # the mast's foot, between points of the raster 5 m apart
        c, s = math.cos(direction), math.sin(direction)
        rows, columns = raster.data.shape
        for row in range(rows):
            for column in range(0, columns, 3):
                along, across = raster.x0 + column * raster.cell_size, raster.y0 + (rows - 1 - row) * raster.cell_size
                height = raster.data[row, column]
                way = along * math.cos(slope) + height * math.sin(slope)  # back to the map: horizontal, and vertical
                rise = height * math.cos(slope) - along * math.sin(slope)
                there = dem.at(1100.0 + way * c - across * s, 2050.0 + way * s + across * c)
                self.assertAlmostEqual(there - dem.at(1100.0, 2050.0), rise, delta=2e-4)  # four decimals, and what the iteration leaves

    def test_takes_a_plane_as_terrain_if_asked(self):
        self.convert(terrain=True)
        self.assertLess(np.max(np.abs(self.terrain().data)), 2e-4)

    def test_refuses_terrain_that_the_dem_does_not_hold(self):
        self.uneven(1.0)
        with self.assertRaisesRegex(ConfigError, "does not cover the 50 m before"):
            self.convert(x=1180.0, terrain=True)
        self.x, self.y = self.x[5:16], self.y[5:16]
        head = f"ncols {COLUMNS}\nnrows 11\nxllcenter {X0}\nyllcenter {Y0 + 25.0}\ncellsize {CELL}\nnodata_value -9999.00\n"
        dem = 500.0 - 0.25 * (self.x - X0) + np.sin(self.x / 9.0)
        (self.folder / "Inputs" / "dem.asc").write_text(head + "\n".join(" ".join(f"{v:.5f}" for v in row) for row in dem) + "\n")
        with self.assertRaisesRegex(ConfigError, "does not cover the window of the case.*--no-terrain"):
            self.convert(width=6.0, terrain=True)

    @needs_program
    def test_writes_terrain_that_the_program_accepts(self):
        self.uneven(1.0)
        self.convert()
        done = subprocess.run([os.environ["MPM"], "check", self.folder / "case" / "case.toml"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn('raster = "ncols', done.stdout)

    def test_interpolates_between_cell_centres_with_north_up(self):
        self.raster(self.folder / "plane.asc", self.x + 2 * self.y)
        raster = avaframe.read_raster(str(self.folder / "plane.asc"))
        for x, y in ((1000.0, 2000.0), (1103.2, 2041.7), (1200.0, 2100.0)):
            self.assertAlmostEqual(raster.at(x, y), x + 2 * y, delta=1e-4)  # five decimals

    def test_reads_headers_with_corners(self):
        (self.folder / "corner.asc").write_text("NCOLS 2\nNROWS 2\nXLLCORNER 0\nYLLCORNER 0\nCELLSIZE 2\nNODATA_VALUE -9999\n3 4\n1 -9999\n")
        raster = avaframe.read_raster(str(self.folder / "corner.asc"))
        self.assertEqual(raster.at(1.0, 1.0), 1.0)
        self.assertTrue(math.isnan(raster.at(2.0, 2.0)))

    def test_says_what_to_export_where_there_are_peaks_only(self):
        for path in self.steps.iterdir():
            path.unlink()
        self.raster(self.steps.parent / "rel1_null_dfa_pft.asc", 0 * self.x)
        with self.assertRaisesRegex(InputError, "peak values alone.*tSteps"):
            self.convert()

    def test_refuses_points_outside_and_beside_the_flow(self):
        with self.assertRaisesRegex(ConfigError, "outside .*covers x from 1000 to 1200"):
            self.convert(x=47.1)
        for path in self.steps.glob("*_FT_*"):
            self.raster(path, 0.01 + 0 * self.x)
        with self.assertRaisesRegex(ConfigError, "nowhere deeper"):
            self.convert()

    def test_refuses_wrong_units(self):
        for path in self.steps.glob("*_FV_*"):
            self.raster(path, 20000.0 + 0 * self.x)
        with self.assertRaisesRegex(InputError, "speed .* reaches 20000.*check the unit"):
            self.convert()

    def test_refuses_files_that_are_cut_off(self):
        path = next(self.steps.glob("*_FT_t7.00.asc"))
        path.write_text(path.read_text()[:2000])
        with self.assertRaisesRegex(InputError, "values, 21 x 41 are needed"):
            self.convert()

    def test_asks_for_the_simulation_where_there_are_two(self):
        self.raster(self.steps / "other_FT_t0.00.asc", 0 * self.x)
        with self.assertRaisesRegex(ConfigError, "2 simulations.*--simulation"):
            self.convert()
        self.convert(simulation="rel1_null_dfa")

    def test_takes_the_thickness_of_older_versions(self):
        for path in list(self.steps.glob("*_FT_*")):
            path.rename(str(path).replace("_FT_", "_FD_"))
        self.assertIn("depth up to 2 m", self.convert()[0])

    def test_refuses_thickness_in_kilometres_and_terrain_in_millimetres(self):
        for path in self.steps.glob("*_FT_*"):
            self.raster(path, 0.002 + 0 * self.x)
        with self.assertRaisesRegex(ConfigError, "nowhere deeper .*rasters of thickness are in metres"):
            self.convert()
        self.raster(self.folder / "Inputs" / "dem.asc", 1000.0 * (500.0 - 0.25 * (self.x - X0)))
        with self.assertRaisesRegex(InputError, "is 90 degrees steep.*same unit, metres"):
            self.convert()

    def test_refuses_grids_in_degrees(self):
        path = self.folder / "Inputs" / "dem.asc"
        path.write_text(path.read_text().replace(f"cellsize {CELL}", "cellsize 0.0001"))
        with self.assertRaisesRegex(InputError, "cells are 0.0001 wide, which are degrees.*reproject"):
            self.convert()

    def test_refuses_empty_files_and_folders(self):
        next(self.steps.glob("*_FT_t7.00.asc")).write_text("")
        with self.assertRaisesRegex(InputError, "the header has no ncols, nrows, cellsize"):
            self.convert()
        (self.folder / "empty").mkdir()
        with self.assertRaisesRegex(InputError, "no rasters of flow thickness"):
            self.convert(folder=str(self.folder / "empty"))

    def test_refuses_a_point_without_terrain(self):
        self.raster(self.folder / "Inputs" / "dem.asc", np.where(np.abs(self.x - 1100.0) < 20.0, -9999.0, 500.0 - 0.25 * (self.x - X0)))
        with self.assertRaisesRegex(ConfigError, "no elevation at 1100,2050; give a point inside"):
            self.convert()

    def test_writes_a_site_for_the_moment_of_the_largest_pressure(self):
        lines = self.convert(density=220.0)
        with open(self.folder / "case" / "site.toml", "rb") as file:
            site = tomllib.load(file)
        self.assertEqual((site["flow"]["depth_m"], site["flow"]["velocity_m_s"], site["flow"]["density_kg_m3"]), (2.0, 20.0, 220.0))
        self.assertAlmostEqual(site["flow"]["slope_deg"], math.degrees(math.atan(0.25)), delta=0.005)  # four digits
        self.assertEqual(site["mast"]["width_m"], 1.0)
        self.assertIn("largest v^2 H: 2 m at 20 m/s, 1 s after the arrival", lines)

    @needs_program
    def test_writes_a_site_that_the_design_accepts(self):
        self.convert()
        done = subprocess.run([os.environ["MPM"], "design", self.folder / "case" / "site.toml", "--quick", "--plan", "--json"], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout)["flow"]["velocity_m_s"], 20.0)

    def test_checks_the_projection_beside_ascii_grids(self):
        self.assertTrue(any("no .prj beside" in line and "taken to be metres" in line for line in self.convert()))
        metres = 'PROJCS["ETRS89 / UTM zone 32N",GEOGCS["ETRS89",UNIT["degree",0.0174532925199433]],UNIT["metre",1]]'
        prj = self.folder / "Inputs" / "dem.prj"
        prj.write_text(metres)
        self.assertFalse(any(".prj" in line for line in self.convert()))
        for wrong, message in (('GEOGCS["WGS 84",UNIT["degree",0.0174532925199433]]', "dem.prj: the coordinates are degrees; reproject"),
                               (metres.replace('"metre",1]]', '"US survey foot",0.3048006]]'), "the unit of the coordinates is US survey foot")):
            prj.write_text(wrong)
            with self.assertRaisesRegex(InputError, message):
                self.convert()
        prj.write_text(metres)
        next(self.steps.glob("*_FT_t7.00.asc")).with_suffix(".prj").write_text(metres.replace("32N", "33N"))
        with self.assertRaisesRegex(InputError, "different projections"):
            self.convert()

    @needs_rasterio
    def test_reads_geotiff_and_refuses_it_without_projection_and_in_degrees(self):
        import rasterio

        def write(projection, cell=CELL):
            transform = rasterio.transform.from_origin(X0 - 0.5 * cell, Y0 + (ROWS - 0.5) * cell, cell, cell)
            with rasterio.open(self.folder / "dem.tif", "w", driver="GTiff", width=COLUMNS, height=ROWS, count=1, dtype="float32",
                               transform=transform, crs=projection) as file:
                file.write((500.0 - 0.25 * (self.x - X0)).astype("float32"), 1)

        write("EPSG:25832")
        self.assertIn("slope 14.0 degrees", self.convert(dem=str(self.folder / "dem.tif"))[1])
        write(None)
        with self.assertRaisesRegex(InputError, "names no projection.*gdal_edit"):
            self.convert(dem=str(self.folder / "dem.tif"))
        write("EPSG:4326")
        with self.assertRaisesRegex(InputError, "coordinates are degrees .*reproject"):
            self.convert(dem=str(self.folder / "dem.tif"))

    @needs_program
    def test_enters_the_run_as_deep_and_as_fast_as_in_the_rasters(self):
        self.convert(y=2050.0, width=2.0)
        case = Case.read(self.folder / "case" / "case.toml").changed(
            {"numerics.cell_size_m": 0.4, "conveyor.width_m": 3.2, "conveyor.sidewall_contact": "slip", "obstacle": None,
             "output.duration_s": 2.0, "output.frames_per_second": 10})
        run = case.run(self.folder / "run", threads=1, progress=False)
        found = measured_inflow(run)
        raster = np.genfromtxt(self.folder / "case" / "inflow.csv", delimiter=",", names=True)
        later = found[found.time_s >= 0.2]  # snow that entered after t = 0 fills the section
        np.testing.assert_allclose(later.velocity_m_s, 20.0, rtol=0.01)
        expected = np.interp(later.entered_s, raster["time_s"], raster["depth_m"])
        np.testing.assert_allclose(later.depth_m, expected, rtol=0.01)  # the surge is linear over a section, but at its crest
        arrived = measured_inflow(run, at=0.0)  # where the mast would stand, 8 m behind the inlet
        arrived = arrived[arrived.entered_s >= 0.1]
        self.assertGreater(len(arrived), 10)
        np.testing.assert_allclose(arrived.velocity_m_s, 20.0, rtol=0.02)  # its own weight spreads the surge: g dH/dx 0.4 s = 0.2 m/s
        np.testing.assert_allclose(arrived.depth_m, np.interp(arrived.entered_s, raster["time_s"], raster["depth_m"]), rtol=0.05)
