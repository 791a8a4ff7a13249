"""Figures on axes, quantities with units, and particles in VTK's layout."""

import base64
import importlib.util
import subprocess
import sys
import unittest
import xml.etree.ElementTree as xml

import matplotlib
from in_folder import sealed_h5
import numpy as np

from mpmtools import Frame, Run, plots, vtk_arrays, write_vtp
from mpmtools.errors import InputError, MpmError
from mpmtools.quantities import known
from study_samples import SOURCE
from test_run import CASE, RunFolder

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


class Plots(RunFolder):
    def tearDown(self):
        plt.close("all")
        super().tearDown()

    def test_return_the_axes_that_they_are_given_or_new_ones(self):
        run = Run(self.folder)
        for draw in (plots.runup, plots.pressure_height, plots.profile, plots.force, plots.moment, plots.side_view, plots.plan_view):
            axes = plt.subplots()[1]
            self.assertIs(draw(run, axes=axes), axes)
            self.assertIsNot(draw(run), axes)
            self.assertTrue(axes.has_data(), draw.__name__)

    def test_show_what_the_run_holds(self):
        run = Run(self.folder)
        line = plots.runup(run).lines[0]
        self.assertEqual((line.get_xdata().tolist(), line.get_ydata().tolist()), ([0, 1, 2], [1, 4, 5]), "99 % of the mass")
        force = plots.force(run).lines[0]
        np.testing.assert_allclose(force.get_ydata(), [0.0, 0.009, 0.009])  # kN
        pressure = plots.profile(run).lines[1]
        self.assertEqual(pressure.get_xdata().round(9).tolist(), [3.9, 2.1, 0.9])  # kPa

    def test_call_an_equation_outside_its_range_extrapolated(self):
        def labels():
            return [line.get_label() for draw in (plots.runup, plots.pressure_height) for line in draw(Run(self.folder)).lines]

        self.write("results.json", '{"predicted_runup_m": 5.0, "predicted_pressure_height_m": 2.5}')
        self.assertEqual([label for label in labels() if "equation" in label], ["paper's equation: 5 m", "paper's equation: 2.5 m"])
        self.write("case.toml", CASE.replace("width_m = 1.75", "width_m = 0.8"))
        self.assertEqual([label for label in labels() if "equation" in label],
                         ["paper's equation, extrapolated: 5 m", "paper's equation, extrapolated: 2.5 m"])

    def test_from_above_show_both_halves_of_a_mirrored_flow(self):
        with sealed_h5(self.folder / "frames" / "00001.h5", "a") as file:
            file.attrs["mirror_y"] = 1
        shown = plots.plan_view(Run(self.folder)).collections[0].get_offsets()
        self.assertEqual(sorted(shown[:, 1].round(3)), [-1.6, -0.2, -0.1, 0.1, 0.2, 1.6])

    def test_name_what_is_missing(self):
        for name in ("profile.csv", "series.csv", "frames/00000.h5", "frames/00001.h5"):
            (self.folder / name).unlink()
        for draw, message in ((plots.profile, "no steady interval"), (plots.runup, "no run-up"), (plots.force, "no obstacle"),
                              (plots.side_view, "no frames")):
            with self.assertRaisesRegex(InputError, message):
                draw(Run(self.folder))

    def test_of_a_run_that_has_just_begun_say_so(self):
        (self.folder / "results.json").unlink()
        series = self.folder / "series.csv"
        series.write_text(series.read_text().splitlines(keepends=True)[0])
        for draw in (plots.runup, plots.pressure_height, plots.force):
            with self.assertRaisesRegex(InputError, "series.csv has no row yet"):
                draw(Run(self.folder))
        plots.side_view(Run(self.folder))

    def test_leave_the_backend_of_a_notebook_alone(self):
        code = "import matplotlib; matplotlib.use('template'); from mpmtools import plots; print(matplotlib.get_backend())"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env={"PYTHONPATH": str(SOURCE / "python")})
        self.assertEqual(done.stdout.strip(), "template")


class Quantities(RunFolder):
    RESULTS = ('{"runup_mean_m": 6.5, "runup_standard_error_m": 0.2543, "runup_numerical_uncertainty_m": null, "force_mean_n": [9.0, 0.0, null],'
               ' "force_standard_error_n": [1.0, 0.0, null], "force_x_numerical_uncertainty_n": 2.0, "steady": true, "title": "x"}')

    def test_have_value_errors_unit_and_meaning(self):
        self.write("results.json", self.RESULTS)
        run = Run(self.folder)
        runup = run.quantity("runup_mean_m")
        self.assertEqual((runup.value, runup.standard_error, runup.numerical_uncertainty, runup.unit), (6.5, 0.2543, None, "m"))
        self.assertIn("highest particle", runup.meaning)
        self.assertEqual(str(runup), "6.5 ± 0.25 (statistics) m")
        force = run.quantity("force_mean_n")
        self.assertEqual(str(force), "(9, 0, -) ± (1, 0, -) (statistics) ± (2, -, -) (grid) N")
        self.assertEqual([q.name for q in run.quantities], ["runup_mean_m", "force_mean_n"])
        self.assertEqual((run.units["force_x_n"], run.units["pressure_pa"], run.units["runup_mean_m"]), ("N", "Pa", "m"))
        with self.assertRaisesRegex(KeyError, "'speed' is not among the results: runup_mean_m"):
            run.quantity("speed")
        with self.assertRaisesRegex(KeyError, r"'runup_mean' is not among the results: runup_mean_m\W*$"):
            run.quantity("runup_mean")
        with self.assertRaisesRegex(MpmError, "^'speed' is not among the results: runup_mean_m"):
            run.quantity("speed")

    def test_cover_what_runs_write(self):
        self.assertGreater(len(known()), 100)
        self.assertTrue({"runup_mean_m", "force_x_n", "smoothed_pressure_pa", "wall_time_s"} <= set(known()))


class Particles(RunFolder):
    def frame(self, **mirrors):
        path = self.folder / "frame.h5"
        with sealed_h5(path, "w") as file:
            file.attrs.update(time_s=1.0, **mirrors)
            file["position_m"] = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
            file["velocity_m_s"] = np.array([[3.0, 4.0, 0.0], [0.0, 1.0, 0.0]], np.float32)
            file["kirchhoff_stress_pa"] = [[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]] * 2
            file["velocity_gradient_1_s"] = np.arange(18.0).reshape(2, 3, 3)
            file["id"] = np.array([7, 8], np.uint64)
            file["vertex"] = np.array([0, 1], np.int32)
        return Frame(path)

    def test_have_the_layout_of_vtk(self):
        arrays = vtk_arrays(self.frame())
        self.assertEqual((arrays["points"].shape, arrays["points"].dtype), ((2, 3), np.float64))
        self.assertEqual(arrays["vertices"].tolist(), [1, 0, 1, 1])
        data = arrays["point_data"]
        self.assertEqual({name: array.shape for name, array in data.items()},
                         {"id": (2,), "kirchhoff_stress_pa": (2, 6), "velocity_gradient_1_s": (2, 9), "velocity_m_s": (2, 3), "speed_m_s": (2,)})
        self.assertEqual(data["speed_m_s"].tolist(), [5.0, 1.0])
        self.assertTrue(all(array.flags.c_contiguous for array in data.values()))

    def test_of_which_none_is_left_keep_their_layout(self):
        path = self.folder / "left.h5"
        with sealed_h5(path, "w") as file:
            file["position_m"], file["velocity_gradient_1_s"] = np.zeros((0, 3)), np.zeros((0, 3, 3))
        arrays = vtk_arrays(Frame(path))
        self.assertEqual((arrays["points"].shape, arrays["point_data"]["velocity_gradient_1_s"].shape), ((0, 3), (0, 9)))

    def test_behind_a_mirror_plane_are_images(self):
        arrays = vtk_arrays(self.frame(mirror_x=0, mirror_y=1))
        data = arrays["point_data"]
        self.assertEqual(arrays["points"][2].tolist(), [1.0, -2.0, 3.0])
        self.assertEqual(data["velocity_m_s"][2].tolist(), [3.0, -4.0, 0.0])
        self.assertEqual(data["kirchhoff_stress_pa"][2].tolist(), [1.0, 2.0, 3.0, -4.0, 5.0, -6.0])  # xy and yz change their signs
        reflect = np.diag([1.0, -1.0, 1.0])
        self.assertEqual(data["velocity_gradient_1_s"][2].reshape(3, 3).tolist(),
                         (reflect @ np.arange(9.0).reshape(3, 3) @ reflect).tolist())
        self.assertEqual(data["id"].tolist(), [7, 8, 7, 8])
        self.assertEqual(len(vtk_arrays(self.frame(mirror_y=1), whole=False)["points"]), 2)
        self.assertEqual(len(vtk_arrays(self.frame(mirror_x=1, mirror_y=1))["points"]), 8)
        self.assertEqual(self.frame(mirror_x=1).whole("position_m")[2].tolist(), [-1.0, 2.0, 3.0])  # of films, too

    def test_written_for_vtk_read_back(self):
        path = self.folder / "particles.vtp"
        write_vtp(self.frame(), path)
        piece = xml.parse(path).find("PolyData/Piece")
        self.assertEqual((piece.get("NumberOfPoints"), piece.get("NumberOfVerts")), ("2", "2"))
        types = {"Float64": np.float64, "Float32": np.float32, "Int64": np.int64, "UInt64": np.uint64}

        def values(element):
            raw = base64.b64decode(element.text)
            size = int(np.frombuffer(raw[:8], np.uint64)[0])
            self.assertEqual(size, len(raw) - 8)
            return np.frombuffer(raw[8:], types[element.get("type")]).tolist()

        found = {element.get("Name"): values(element) for element in piece.iter("DataArray")}
        self.assertEqual(found["position_m"], [1, 2, 3, 4, 5, 6])
        self.assertEqual((found["id"], found["connectivity"], found["offsets"]), ([7, 8], [0, 1], [1, 2]))
        self.assertEqual(found["velocity_m_s"], [3, 4, 0, 0, 1, 0])

    def test_without_pyvista_say_so(self):
        if importlib.util.find_spec("pyvista"):
            self.skipTest("PyVista is installed")
        from mpmtools import to_pyvista

        with self.assertRaisesRegex(InputError, "PyVista is not installed"):
            to_pyvista(self.frame())


if __name__ == "__main__":
    unittest.main()
