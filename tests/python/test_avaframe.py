"""Rasters of AvaFrame's com1DFA as the inflow of a case, on a synthetic slope in its file format."""

import contextlib
import importlib.util
import io
import json
import math
import os
import subprocess
import tomllib
import unittest
import unittest.mock

import numpy as np

from mpmtools import Case, avaframe, plots
from mpmtools.__main__ import main
from mpmtools.avaframe.case_files import DENSITIES, WIDTHS
from mpmtools.avaframe.projection import check_metres, same
from mpmtools.avaframe.rasters import read_elevation, read_raster
from mpmtools.errors import ConfigError, InputError
from mpmtools.files import save_figure
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
        return avaframe.import_avalanche(**arguments)[0]

    def test_overwrites_nothing_without_force(self):
        (self.folder / "case").mkdir()
        own = self.folder / "case" / "case.toml"
        own.write_text("of the user")
        words = ["import-avaframe", str(self.folder), "--at", "1100,2050", "--out", str(self.folder / "case")]
        with contextlib.redirect_stderr(io.StringIO()) as messages, contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(main(words), 2)
            self.assertEqual(os.listdir(self.folder / "case"), ["case.toml"])
            self.assertEqual(own.read_text(), "of the user")
            self.assertEqual(main([*words, "--force"]), 0)
        self.assertIn("case.toml; choose another folder with --out, or overwrite with --force", messages.getvalue())

    def test_gives_depth_and_speed_over_time_at_the_point(self):
        self.convert()
        rows = np.genfromtxt(self.folder / "case" / "inflow.csv", delimiter=",", names=True)
        np.testing.assert_allclose(rows["depth_m"], [1.0, 2.0, 1.0])  # the front is there at 5 s, the middle at 7 s; t = 0 at the first row
        np.testing.assert_allclose(rows["time_s"], [0.0, 1.0, 2.0])
        np.testing.assert_allclose(rows["velocity_m_s"], 20.0)
        self.assertGreater(Case.read(self.folder / "case" / "case.toml")["output.duration_s"], rows["time_s"][-1])  # each row enters

    def test_takes_the_slope_from_the_terrain(self):
        lines = self.convert()
        self.assertIn("slope 14.0 degrees, falling towards 0 degrees", lines[1])  # atan(1/4)
        self.assertIn(f"gravity_m_s2 = {9.81 * math.cos(math.atan(0.25)):.6g}", (self.folder / "case" / "case.toml").read_text())
        self.assertIn("differs by less than 0.01 m from this plane", "\n".join(lines))

    def test_falls_back_to_a_plane_where_the_relief_is_too_steep(self):
        self.raster(self.folder / "Inputs" / "dem.asc", 500.0 - 0.25 * (self.x - X0) + 6.0 * (np.abs(self.x - 1095.0) < 3.0))
        self.assertRegex("\n".join(self.convert()), "degrees steep against it, where a run can have 30: the run takes the plane; heights.*may move")
        self.assertNotIn("terrain", Case.read(self.folder / "case" / "case.toml").tables)
        with self.assertRaisesRegex(ConfigError, "degrees steep.*--no-terrain"):
            self.convert(terrain=True, out=str(self.folder / "none"))
        self.assertFalse((self.folder / "none").exists())

    def uneven(self, relief):
        """A slope that falls 1 in 4 to the north-west, and a wave along and across it."""
        east, north = self.x - 1100.0, self.y - 2050.0
        wave = relief * np.sin(east / 9.0) * np.cos(north / 7.0)
        self.raster(self.folder / "Inputs" / "dem.asc", 500.0 + 0.25 * (east - north) / math.sqrt(2.0) + wave)

    def terrain(self):
        return read_raster(str(self.folder / "case" / "terrain.asc"))

    def test_gives_the_case_the_terrain_where_it_is_uneven(self):
        self.uneven(0.1)
        self.assertIn("the run takes the plane", "\n".join(self.convert()))  # a wave of 0.1 m under a flow of 2 m
        self.assertFalse((self.folder / "case" / "terrain.asc").exists())
        self.uneven(2.0)
        self.assertIn("the run takes terrain.asc", "\n".join(self.convert()))
        case = Case.read(self.folder / "case" / "case.toml")
        self.assertEqual((case["terrain.file"], case["conveyor.sidewall_contact"], case["conveyor.mirror_y"]), ("terrain.asc", "slip", False))
        self.assertNotIn("terrain", Case.read(self.converted_without()).tables)

    def converted_without(self):
        self.convert(out=str(self.folder / "plane"), terrain=False)
        return self.folder / "plane" / "case.toml"

    def test_takes_a_plane_as_terrain_if_asked(self):
        self.convert(terrain=True)
        self.assertLess(np.max(np.abs(self.terrain().data)), 2e-4)

    def test_refuses_terrain_that_the_dem_does_not_hold(self):
        self.uneven(2.0)
        self.x, self.y = self.x[5:16], self.y[5:16]
        head = f"ncols {COLUMNS}\nnrows 11\nxllcenter {X0}\nyllcenter {Y0 + 25.0}\ncellsize {CELL}\nnodata_value -9999.00\n"
        dem = 500.0 - 0.25 * (self.x - X0) + np.sin(self.x / 9.0)
        (self.folder / "Inputs" / "dem.asc").write_text(head + "\n".join(" ".join(f"{v:.5f}" for v in row) for row in dem) + "\n")
        with self.assertRaisesRegex(ConfigError, "does not cover the window of the case.*--no-terrain"):
            self.convert(width=6.0, terrain=True)

    @needs_program
    def test_writes_terrain_that_the_program_accepts(self):
        self.uneven(2.0)
        self.convert()
        done = subprocess.run([os.environ["MPM"], "check", self.folder / "case" / "case.toml"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn('raster = "ncols', done.stdout)

    @needs_program
    def test_covers_the_belt_of_narrow_and_wide_masts_with_terrain(self):
        for width in (0.3, 0.7, 1.0, 3.0):  # under a flow of 2 m
            self.convert(width=width, terrain=True)
            done = subprocess.run([os.environ["MPM"], "check", self.folder / "case" / "case.toml"], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_refuses_densities_and_widths_that_no_site_has(self):
        for option, value, message in (("--density", "5", "--density 5: give a number from 10 to 1000 kg/m^3"), ("--density", "nan", "--density nan"),
                                       ("--density", "1001", "--density 1001"), ("--mast-width", "0.04", "--mast-width 0.04: give a number from 0.05 to 100 m"),
                                       ("--mast-width", "inf", "--mast-width inf"), ("--mast-width", "nan", "--mast-width nan")):
            code, _, err = self.command("import-avaframe", self.folder, "--at", "1100,2050", option, value, "--out", self.folder / "case")
            self.assertEqual(code, 2)
            self.assertIn(message, err)
            self.assertFalse((self.folder / "case").exists())

    @needs_program
    def test_knows_the_ranges_of_a_site(self):
        tables = json.loads(subprocess.run([os.environ["MPM"], "schema", "--site", "--json"], capture_output=True, text=True, check=True).stdout)["tables"]
        ranges = {key["name"]: (key["range"]["low"], key["range"]["high"]) for table in tables if table["name"] in ("flow", "mast") for key in table["keys"] if "range" in key}
        self.assertEqual((ranges["density_kg_m3"], ranges["width_m"]), (DENSITIES, WIDTHS))

    @needs_program
    def test_reports_what_the_program_refuses(self):
        code, out, err = self.command("import-avaframe", self.folder, "--at", "1100,2050", "--mast-width", "0.05", "--out", self.folder / "case")
        self.assertEqual(code, 2)
        self.assertIn("depth up to 2 m", out)
        self.assertRegex(err, r"site.toml is written, but the program refuses it: .*\[mast\] width_m = 0.05 m is 0.025 times the depth of the flow")

    def test_says_where_nothing_could_be_checked(self):
        with unittest.mock.patch("mpmtools.avaframe.case_files.find_program", side_effect=InputError("the program 'mpm' is not found")):
            code, out, _ = self.command("import-avaframe", self.folder, "--at", "1100,2050", "--mast-width", "0.05", "--out", self.folder / "case")
        self.assertEqual(code, 0)
        self.assertIn("the files were not checked: the program 'mpm' is not found", out)

    def test_interpolates_between_cell_centres_with_north_up(self):
        self.raster(self.folder / "plane.asc", self.x + 2 * self.y)
        raster = read_raster(str(self.folder / "plane.asc"))
        for x, y in ((1000.0, 2000.0), (1103.2, 2041.7), (1200.0, 2100.0)):
            self.assertAlmostEqual(raster.at(x, y), x + 2 * y, delta=1e-4)  # five decimals

    def test_reads_headers_with_corners(self):
        (self.folder / "corner.asc").write_text("NCOLS 2\nNROWS 2\nXLLCORNER 0\nYLLCORNER 0\nCELLSIZE 2\nNODATA_VALUE -9999\n3 4\n1 -9999\n")
        raster = read_raster(str(self.folder / "corner.asc"))
        self.assertEqual(raster.at(1.0, 1.0), 1.0)
        self.assertTrue(math.isnan(raster.at(2.0, 2.0)))

    def peaks(self):
        for path in self.steps.iterdir():
            path.unlink()
        self.raster(self.steps.parent / "rel1_null_dfa_pft.asc", 2.0 + 0 * self.x)
        self.raster(self.steps.parent / "rel1_null_dfa_pfv.asc", 20.0 + 0 * self.x)

    @needs_program
    def test_writes_a_site_from_peak_values_only(self):
        self.peaks()
        lines = "\n".join(self.convert())
        self.assertRegex(lines, "need not coincide(.|\n)*no case, since peak values do not say.*tSteps")
        self.assertFalse((self.folder / "case" / "case.toml").exists())
        site = tomllib.loads((self.folder / "case" / "site.toml").read_text())
        self.assertRegex(site["flow"]["source"], "com1DFA.* at 1100,2050: largest depth and largest speed.*need not coincide")
        done = subprocess.run([os.environ["MPM"], "design", self.folder / "case" / "site.toml", "--quick", "--plan"], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_takes_the_speed_from_components_where_there_is_no_fv(self):
        for path in list(self.steps.glob("*_FV_*")):
            speed = read_raster(str(path)).data
            path.unlink()
            self.raster(self.steps / path.name.replace("_FV_", "_Vx_"), speed * math.cos(math.atan(0.25)))
            self.raster(self.steps / path.name.replace("_FV_", "_Vy_"), 0.0 * speed)
        lines = "\n".join(self.convert())
        self.assertRegex(lines, "speed up to 20 m/s(.|\n)*towards 0 degrees.*from Vx and Vy")

    def test_states_one_slope_in_both_files(self):
        self.uneven(2.0)
        self.convert()
        with open(self.folder / "case" / "site.toml", "rb") as file:
            slope = tomllib.load(file)["flow"]["slope_deg"]
        self.assertAlmostEqual(Case.read(self.folder / "case" / "case.toml")["numerics.gravity_m_s2"], 9.81 * math.cos(math.radians(slope)),
                               delta=6e-4)  # four digits of the angle

    def header(self, old, new):
        path = self.folder / "Inputs" / "dem.asc"
        path.write_text(path.read_text().replace(old, new), encoding="utf-8")

    def test_reads_headers_with_dx_and_dy_and_byte_order_marks(self):
        whole = self.convert()
        self.header(f"cellsize {CELL}", f"dx {CELL}\ndy {CELL}")
        self.header("ncols", "\ufeffncols")
        self.assertEqual(self.convert(), whole)
        self.header(f"dy {CELL}", "dy 4.0")
        with self.assertRaisesRegex(InputError, "cells are 5 x 4; resample"):
            self.convert()

    def test_refuses_headers_without_a_corner(self):
        self.header(f"yllcenter {Y0}\n", "")
        with self.assertRaisesRegex(InputError, "the header has no yllcorner"):
            self.convert()

    def test_takes_zeros_amid_mountains_as_missing_data(self):
        self.raster(self.folder / "Inputs" / "dem.asc", np.where(self.x < 1060.0, 0.0, 500.0 - 0.25 * (self.x - X0)))
        self.assertRegex("\n".join(self.convert()), "slope 14.0(.|\n)*cells are exactly 0.*taken as missing data")
        self.raster(self.folder / "sea.asc", np.maximum(0.0, 0.25 * (self.x - 1100.0)))  # a coast has zeros, too
        dem, lines = read_elevation(str(self.folder / "sea.asc"))
        self.assertEqual((lines, int(np.isnan(dem.data).sum())), ([], 0))

    def test_prints_the_point_as_given(self):
        self.convert(x=1100.123, y=2050.456)
        self.assertIn("at 1100.123,2050.456", (self.folder / "case" / "site.toml").read_text())

    def test_takes_negative_coordinates(self):
        for path in (*self.folder.rglob("*.asc"),):
            path.write_text(path.read_text().replace(f"xllcenter {X0}", "xllcenter -100100").replace(f"yllcenter {Y0}", "yllcenter -52000"))
        for number, at in enumerate((["--at", "-100000,-51950"], ["--at=-100000,-51950"])):
            with contextlib.redirect_stdout(io.StringIO()):
                self.assertEqual(main(["import-avaframe", str(self.folder), *at, "--out", str(self.folder / f"case{number}")]), 0)
            self.assertIn("at -100000,-51950", (self.folder / f"case{number}" / "site.toml").read_text())

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

    def without(self, *names):
        for name in names:
            (self.steps / f"rel1_null_dfa_{name}.asc").unlink()

    def test_refuses_a_time_step_between_others_that_lacks_a_file(self):
        self.without("FV_t7.00")  # the strongest
        with self.assertRaisesRegex(InputError, "timeSteps: the time step at 7 s has no rel1_null_dfa_FV_t7.00.asc, and others before and behind it are complete"):
            self.convert()
        self.assertFalse((self.folder / "case").exists())
        self.raster(self.steps / "rel1_null_dfa_Vx_t7.00.asc", 20.0 + 0 * self.x)
        with self.assertRaisesRegex(InputError, "has no rel1_null_dfa_Vy_t7.00.asc"):
            self.convert()
        self.raster(self.steps / "rel1_null_dfa_Vy_t7.00.asc", 0 * self.x)
        self.assertRegex("\n".join(self.convert()), "15 of 16 time steps have no Vx and Vy, the first at 0 s: the direction is found without them")
        self.without("FT_t7.00")
        with self.assertRaisesRegex(InputError, "has no rel1_null_dfa_FT_t7.00.asc"):
            self.convert()

    def test_refuses_an_outer_time_step_that_lacks_a_file_where_the_flow_is_strongest(self):
        self.without(*(f"{quantity}_t{time}.00" for quantity in ("FT", "FV") for time in range(8, 16)), "FV_t7.00")
        with self.assertRaisesRegex(InputError, "at 7 s has no rel1_null_dfa_FV_t7.00.asc, and there the flow at 1100,2050 is deeper, 2 m, than at all complete time steps, 1 m"):
            self.convert()
        self.without("FT_t7.00")
        self.raster(self.steps / "rel1_null_dfa_FV_t7.00.asc", 30.0 + 0 * self.x)
        with self.assertRaisesRegex(InputError, "at 7 s has no rel1_null_dfa_FT_t7.00.asc, and there the flow at 1100,2050 is faster, 30 m/s"):
            self.convert()

    def test_warns_of_outer_time_steps_that_lack_a_file(self):
        whole = self.convert()
        self.without("FV_t15.00")
        lines = self.convert()
        self.assertIn("warning: the time step at 15 s is left out: there is no rel1_null_dfa_FV_t15.00.asc", lines)
        self.without("FT_t0.00")
        lines = self.convert()
        self.assertIn("warning: 2 time steps are left out: there is no rel1_null_dfa_FT_t0.00.asc, ...", lines)
        self.assertEqual([line for line in lines if "left out" not in line], [line.replace("16 time", "14 time") for line in whole])
        self.raster(self.steps.parent / "rel1_null_dfa_pft.asc", 2.0 + 0 * self.x)
        self.raster(self.steps.parent / "rel1_null_dfa_pfv.asc", 20.0 + 0 * self.x)
        for path in self.steps.glob("*_FV_*"):
            path.unlink()
        self.assertRegex("\n".join(self.convert()), "no case, since peak values(.|\n)*wrote")
        self.assertRegex("\n".join(self.convert()), "15 time steps are left out: there is no rel1_null_dfa_FV_t1.00.asc, ...")

    def test_refuses_two_files_of_one_quantity_at_one_time(self):
        for other, what in (("FT_t7.00.tif", "the thickness"), ("FD_t7.00.asc", "the thickness"), ("FV_t7.0.asc", "the speed"), ("FV_t7.00.TIFF", "the speed")):
            path = self.steps / f"rel1_null_dfa_{other}"
            path.write_text("")
            with self.assertRaisesRegex(InputError, f"rel1_null_dfa_F[TVD]_t7.* and rel1_null_dfa_F[TV]_t7.* both hold {what} of the same time; move one"):
                self.convert()
            path.unlink()
        self.peaks()
        (self.steps.parent / "rel1_null_dfa_pft.tif").write_text("")
        with self.assertRaisesRegex(InputError, "pft.asc and rel1_null_dfa_pft.tif both hold the thickness"):
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
        self.raster(self.folder / "Inputs" / "dem.asc", 1000.0 * (500.0 - 0.25 * (self.x - X0)))
        with self.assertRaisesRegex(InputError, "is 90 degrees steep.*same unit, metres"):
            self.convert()
        for path in self.steps.glob("*_FT_*"):
            self.raster(path, 0.002 + 0 * self.x)
        with self.assertRaisesRegex(ConfigError, "nowhere deeper .*rasters of thickness are in metres"):
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
        self.assertTrue(any("no projection is stated" in line and "taken to be metres" in line for line in self.convert()))
        metres = 'PROJCS["ETRS89 / UTM zone 32N",GEOGCS["ETRS89",UNIT["degree",0.0174532925199433]],UNIT["metre",1]]'
        prj = self.folder / "Inputs" / "dem.prj"
        prj.write_text(metres)
        self.assertTrue(any("lie on the same grid" in line for line in self.convert()))
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
        with self.assertRaisesRegex(InputError, "coordinates are degrees; reproject"):
            self.convert(dem=str(self.folder / "dem.tif"))

    @needs_program
    def test_enters_the_run_as_deep_and_as_fast_as_in_the_rasters(self):
        self.convert(y=2050.0, width=2.0)
        case = Case.read(self.folder / "case" / "case.toml").changed(
            {"numerics.cell_size_m": 0.4, "conveyor.width_m": 3.2, "conveyor.sidewall_contact": "slip", "obstacle": None,
             "output.duration_s": 2.0, "output.frames_per_second": 10})
        run = case.run(self.folder / "run", threads=1, progress=False)
        if folder := os.environ.get("MPM_PICTURES"):  # docs/pictures.py
            save_figure(plots.inflow(run)[0].figure, os.path.join(folder, "imported_inflow.png"), dpi=90)
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

    def test_knows_units_and_projections_however_they_are_written(self):
        metres = 'PROJCS["ETRS89 / UTM zone 32N",GEOGCS["ETRS89",UNIT["degree",0.0174532925199433]],UNIT["metre",1]]'
        check_metres(metres, "dem.asc")
        check_metres(f'COMPD_CS["both",{metres},VERT_CS["height",VERT_DATUM["d",2005],UNIT["metre",1]]]', "dem.asc")
        for wrong, message in ((metres.replace('"metre",1', '"Foot_US",0.3048006'), "coordinates is Foot_US"),
                               (f'COMPD_CS["both",{metres},VERT_CS["height",VERT_DATUM["d",2005],UNIT["US survey foot",0.3048]]]', "heights is US survey foot"),
                               (f'{metres},VERTCS["height",VDATUM["d"],UNIT["Foot",0.3048]]', "heights is Foot")):
            with self.assertRaisesRegex(InputError, message):
                check_metres(wrong, "dem.asc")
        self.assertTrue(same(metres, metres.replace(",", ", ").upper()))
        for both in (f'COMPD_CS["both",{metres},VERT_CS["height",UNIT["metre",1]]]', f'{metres},VERTCS["height",UNIT["Meter",1]]'):
            self.assertTrue(same(metres, both))  # a DEM that names its heights, too

    @needs_rasterio
    def test_compares_projections_and_not_their_texts(self):
        from rasterio.crs import CRS

        system = CRS.from_epsg(25832)
        self.assertTrue(same(system.to_wkt(), system.to_wkt(version="WKT2_2019")))
        self.assertTrue(same(system.to_wkt(), system.to_wkt(version="WKT1_ESRI")))
        self.assertFalse(same(system.to_wkt(), CRS.from_epsg(25833).to_wkt()))

    @needs_rasterio
    def test_compares_the_projections_of_a_geotiff_and_of_ascii_grids(self):
        import rasterio
        from rasterio.crs import CRS

        transform = rasterio.transform.from_origin(X0 - 0.5 * CELL, Y0 + (ROWS - 0.5) * CELL, CELL, CELL)
        with rasterio.open(self.folder / "dem.tif", "w", driver="GTiff", width=COLUMNS, height=ROWS, count=1, dtype="float32", transform=transform,
                           crs="EPSG:25832") as file:
            file.write((500.0 - 0.25 * (self.x - X0)).astype("float32"), 1)
        for code in (25832, 25833):
            for path in self.steps.glob("*.asc"):
                path.with_suffix(".prj").write_text(CRS.from_epsg(code).to_wkt(version="WKT1_ESRI"))
            if code == 25832:
                self.convert(dem=str(self.folder / "dem.tif"))
        with self.assertRaisesRegex(InputError, "different projections"):
            self.convert(dem=str(self.folder / "dem.tif"))

    def test_refuses_a_projection_beside_one_only_where_the_grids_differ(self):
        (self.folder / "Inputs" / "dem.prj").write_text('PROJCS["x",GEOGCS["y",UNIT["degree",0.01745]],UNIT["metre",1]]')
        self.header(f"xllcenter {X0}", "xllcenter 980.0")
        with self.assertRaisesRegex(InputError, "its grid is another one.*put the .prj"):
            self.convert()


class Scene(InFolder):
    """Synthetic avalanches in com1DFA's formats, 5 m cells, a step a second, that conserve volume exactly: a patch of snow that moves along a
    straight line, or turns about a centre."""

    SIZE, CELL = 60, 5.0

    def setUp(self):
        super().setUp()
        axis = self.CELL * np.arange(self.SIZE)
        self.x, self.y = np.meshgrid(axis, axis[::-1])
        (self.folder / "Inputs").mkdir()
        self.steps = self.folder / "Outputs" / "com1DFA" / "peakFiles" / "timeSteps"
        self.steps.mkdir(parents=True)

    def raster(self, path, data, geotiff):
        if geotiff:
            import rasterio

            transform = rasterio.transform.from_origin(-0.5 * self.CELL, (self.SIZE - 0.5) * self.CELL, self.CELL, self.CELL)
            with rasterio.open(f"{path}.tif", "w", driver="GTiff", width=self.SIZE, height=self.SIZE, count=1, dtype="float32", transform=transform,
                               crs="EPSG:25832") as file:
                file.write(data.astype("float32"), 1)
            return
        head = f"ncols {self.SIZE}\nnrows {self.SIZE}\nxllcenter 0\nyllcenter 0\ncellsize {self.CELL}\nnodata_value -9999\n"
        with open(f"{path}.asc", "w", encoding="utf-8") as file:
            file.write(head)
            np.savetxt(file, data, fmt="%.4f")

    def avalanche(self, name, components=True, geotiff=False):
        """Writes it. @return (points, direction(x, y) of the velocity, rad)"""
        x, y = self.x, self.y
        if name == "steep valley":  # 25 degrees along, sides of 38 degrees, 30 degrees from east; the snow comes down obliquely to the axes of the map
            angle = math.radians(30.0)
            along, left = x * math.cos(angle) + y * math.sin(angle), -(x - 60.0) * math.sin(angle) + (y - 80.0) * math.cos(angle)
            ground = 900.0 - math.tan(math.radians(25.0)) * along + 0.78 * (np.hypot(left, 8.0) - 8.0)
            points = [(60.0 + a * math.cos(angle) - b * math.sin(angle), 80.0 + a * math.sin(angle) + b * math.cos(angle))
                      for a in (50.0, 75.0, 100.0, 125.0) for b in (-9.3, 4.1)]
        elif name == "counter-slope":  # a dam 6 m high across a slope of 15 degrees: its face rises against the flow
            ground = 600.0 - math.tan(math.radians(15.0)) * x + 6.0 * np.exp(-((x - 150.0) / 12.0)**2)
            angle = 0.0
            along, left = x, y - 150.0
            points = [(a, b) for a in (130.0, 140.0, 146.3, 158.0) for b in (140.0, 157.7)]
        if name == "curved channel":  # an arc of 120 m about the corner of the map, with banks; it falls 20 degrees along the arc
            radius, turn = np.hypot(x, y), np.arctan2(y, x)
            ground = 700.0 - 120.0 * math.tan(math.radians(20.0)) * turn + 12.0 * ((radius - 120.0) / 30.0)**2
            points = [(r * math.cos(t), r * math.sin(t)) for t in (0.5, 0.7, 0.9, 1.1) for r in (113.0, 126.0)]
        speed = 16.0

        def depth(time):
            if name == "curved channel":
                return 2.5 * np.exp(-(120.0 * turn - speed * time)**2 / 2.0 / 25.0**2 - (radius - 120.0)**2 / 2.0 / 14.0**2)
            return 2.5 * np.exp(-(along - speed * time)**2 / 2.0 / 25.0**2 - left**2 / 2.0 / 14.0**2)

        if name == "curved channel":
            vx, vy = -speed * y / 120.0, speed * x / 120.0

            def direction(px, py):
                return math.atan2(px, -py)
        else:
            vx, vy = speed * math.cos(angle) + 0 * x, speed * math.sin(angle) + 0 * x

            def direction(px, py):
                return angle
        self.raster(self.folder / "Inputs" / "dem", ground, geotiff)
        for time in range(0, 18):
            h = depth(time)
            fields = {"FT": np.where(h > 0.02, h, 0.0), "FV": np.hypot(vx, vy) * (h > 0.02)}
            if components:
                fields |= {"Vx": vx * (h > 0.02), "Vy": vy * (h > 0.02)}
            for quantity, values in fields.items():
                self.raster(self.steps / f"rel_1_C_L_null_dfa_{quantity}_t{time:.2f}", values, geotiff)
        return points, direction

    def check_points(self, name, **how):
        points, direction = self.avalanche(name, **how)
        dem = read_raster(str(next((self.folder / "Inputs").iterdir())))
        worst = 0.0
        for px, py in points:
            out = self.folder / "case"
            lines, _ = avaframe.import_avalanche(str(self.folder), px, py, 1.5, str(out))
            found = float(next(line for line in lines if line.startswith("the flow goes")).split()[4])
            worst = max(worst, abs(math.degrees(np.angle(np.exp(1j * (math.radians(found) - direction(px, py)))))))
            done = subprocess.run([os.environ["MPM"], "check", out / "case.toml"], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            if "terrain" in Case.read(out / "case.toml").tables:
                self.assertLess(self.off_the_dem(dem, px, py, out), 0.01)
            else:
                self.assertTrue(any("the run takes the plane" in line for line in lines))
        self.assertLess(worst, 10.0)

    def off_the_dem(self, dem, px, py, out):
        """The largest vertical distance of the points of terrain.asc from the DEM; the plane is taken from site and DEM alone."""
        from mpmtools.avaframe import flow, ground, results
        from mpmtools.avaframe.case_files import setup

        _, steps, _, _ = results.simulation_files(str(self.folder))
        whole, _ = flow.flow_at(steps, px, py, dem)
        angle = flow.direction_of(whole, flow.passage(whole, 0.3), px, py).angle
        plane = ground.plane_at(dem, px, py, angle, setup(1.5, whole.depth.max()).window)
        raster = read_raster(str(out / "terrain.asc"))
        x, y, z = raster.points()
        at = plane.to_map(x, y, z)
        return float(np.max(np.abs(at[2] - dem.values(at[0], at[1]))))

    @needs_program
    def test_steep_valley(self):
        self.check_points("steep valley")

    @needs_program
    def test_curved_channel(self):
        self.check_points("curved channel")

    @needs_program
    def test_counter_slope(self):
        self.check_points("counter-slope")

    @needs_program
    def test_direction_from_the_balance_of_volume(self):
        self.check_points("curved channel", components=False)

    @needs_program
    def test_direction_from_the_balance_of_volume_on_a_counter_slope(self):
        self.check_points("counter-slope", components=False)  # the ground falls against the flow at half of the points

    @needs_program
    @needs_rasterio
    def test_geotiff(self):
        self.check_points("steep valley", components=False, geotiff=True)
