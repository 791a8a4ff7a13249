"""Result folders as Run, and the pictures made of them."""

import contextlib
import resource
import unittest

from in_folder import sealed_h5
import numpy as np

from mpmtools import Run
from mpmtools.checksums import checksum
from mpmtools.errors import InputError
from mpmtools.figures import run_pictures
from mpmtools.frame import Frame
from reports.bench_history import draw_history, history_figure
from mpmtools.tables import read_series
from study_samples import InFolder

CASE = """\
title = "Small"
[conveyor]
velocity_m_s = 12.0
flow_height_m = 1.75
mirror_y = true
[obstacle]
shape = "box"
width_m = 1.75
depth_m = 1.75
[numerics]
cell_size_m = 0.5
particles_per_cell = 8
gravity_m_s2 = 9.81
[measurement]
bin_height_m = 0.2
box_upstream_m = 0.1
"""
SERIES = "time_s,runup_m,runup_p99_m,pressure_height_m,force_x_n,force_y_n,force_z_n,moment_x_n_m,moment_y_n_m,moment_z_n_m\n"


@contextlib.contextmanager
def largest_file(size):
    """As on a full disk, nothing can be written behind `size` bytes of a file; None: no limit."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limits[0] if size is None else size, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


class RunFolder(InFolder):
    def setUp(self):
        super().setUp()
        self.write("case.toml", CASE)
        self.write("obstacle.json", '{"outline_m": [[0, -0.875], [1.75, -0.875], [1.75, 0.875], [0, 0.875]], "top_m": null}')
        self.write("series.csv", SERIES + "0,1,1,nan,0,0,0,0,0,0\n1,5,4,2,9,0,1,0,2,0\n2,6,5,3,9,0,1,0,2,0\n3,7,5")
        self.write("results.json", '{"runup_mean_m": 6.5, "steady": true, "moment_mean_n_m": null, "steady_from_s": 1, "steady_to_s": 2}')
        self.write("profile.csv", "z_m,pressure_pa,smoothed_pressure_pa\n0.1,4000,3900\n0.3,2000,2100\n0.5,1000,900\n")
        (self.folder / "frames").mkdir()
        for i, time in enumerate((0.0, 1.5)):
            with sealed_h5(self.folder / "frames" / f"0000{i}.h5", "w") as file:
                file.attrs["time_s"] = time
                file["position_m"] = [[-0.3, 0.2, 0.4], [-1.0, 0.1, 2.0], [-1.0, 1.6, 9.0]]  # the last is beside the measuring strip
                file["volume_ratio"] = [0.5, 1.0, 1.0]
                file["kirchhoff_stress_pa"] = [[-1e4] + [0.0] * 5] * 3
        (self.folder / "frames" / "00002.h5.tmp").touch()


class Runs(RunFolder):
    def test_hold_results_series_profile_frames_and_case(self):
        run = Run(self.folder)
        self.assertEqual((run.title, run.flow_height, run.velocity, run.gravity, run.particle_spacing), ("Small", 1.75, 12.0, 9.81, 0.25))
        self.assertEqual((run.number("runup_mean_m"), run.number("steady"), run.number("none")), (6.5, None, None))
        self.assertEqual(run.series.index.tolist(), [0, 1, 2])  # the last line was cut off by a kill
        self.assertEqual(run.profile.z_m.tolist(), [0.1, 0.3, 0.5])
        self.assertEqual([frame.time for frame in run.frames], [0.0, 1.5])
        self.assertEqual(run.frames[1]["position_m"].shape, (3, 3))
        self.assertIn("volume_ratio", list(run.frames[0]))
        self.assertIsNone(run.final)
        with self.assertRaisesRegex(KeyError, "no array 'speed'; there are: "):
            run.frames[0]["speed"]

    def test_are_mappings_of_arrays_and_keys(self):
        run = Run(self.folder)
        frame = run.frames[0]
        self.assertEqual(set(frame), {"position_m", "volume_ratio", "kirchhoff_stress_pa"})
        self.assertTrue("position_m" in frame and "speed" not in frame and len(frame) == 3)
        self.assertEqual(frame.table.position_z_m.tolist(), [0.4, 2.0, 9.0])
        self.assertEqual(frame.table.kirchhoff_stress_xx_pa.tolist(), [-1e4] * 3)
        self.assertEqual((run.case["obstacle.width_m"], run.case["obstacle"]["shape"], dict(run.case)["numerics.cell_size_m"]), (1.75, "box", 0.5))
        self.assertIn("measurement.bin_height_m", list(run.case))

    def test_are_tables_where_no_particle_is_left(self):
        with sealed_h5(self.folder / "empty.h5") as file:
            file["position_m"] = np.zeros((0, 3))
        self.assertEqual(list(Frame(str(self.folder / "empty.h5")).table), ["position_x_m", "position_y_m", "position_z_m"])

    def test_name_a_key_that_a_case_lacks(self):
        run = Run(self.folder)
        with self.assertRaisesRegex(KeyError, "case.toml: obstacle.friction"):
            run.case["obstacle.friction"]

    def test_hold_profiles_over_time_and_height(self):
        self.assertEqual(Run(self.folder).profiles, {})
        with sealed_h5(self.folder / "profiles.h5") as file:
            file["time_s"], file["z_m"], file["pressure_pa"] = [0.0, 0.5], [0.1, 0.3, 0.5], np.arange(6.0).reshape(2, 3)
        self.assertEqual(Run(self.folder).profiles["pressure_pa"].loc[0.5, 0.3], 4.0)

    def test_give_a_quantity_and_its_components_by_one_name(self):
        self.write("results.json", '{"force_mean_n": [3.0, null, 1.0], "force_standard_error_n": [0.5, null, null], '
                                   '"force_x_numerical_uncertainty_n": 2.0, "moment_mean_n_m": null}')
        run = Run(self.folder)
        for name in ("force_mean_n.x", "force_mean_n[0]"):
            found = run.quantity(name)
            self.assertEqual((found.name, found.value, found.standard_error, found.numerical_uncertainty, found.unit),
                             ("force_mean_n.x", 3.0, 0.5, 2.0, "N"))
            self.assertEqual(run.number(name), 3.0)
        for name in ("force_mean_n.y", "moment_mean_n_m.x"):
            self.assertIsNone(run.number(name), name)
        for name in ("force_mean_n.w", "force_mean_n[3]"):
            with self.assertRaises(KeyError):
                run.quantity(name)

    def test_without_files_are_empty_and_look_into_the_fallback(self):
        for name in ("series.csv", "profile.csv", "results.json"):
            (self.folder / name).rename(self.folder / f"kept_{name}")
        self.assertTrue(Run(self.folder).series.empty and Run(self.folder).profile.empty and Run(self.folder).results == {})
        self.write("post/profile.csv", "z_m,pressure_pa\n0.1,7\n")
        self.assertEqual(Run(self.folder, fallback=self.folder / "post").profile.pressure_pa.tolist(), [7])
        with self.assertRaisesRegex(InputError, "there is no case.toml"):
            Run(self.folder / "frames")

    def test_know_whether_half_is_computed(self):
        for domain, mirrored in (('mirror = ["y"]', True), ('mirror = ["x"]', False), ('mirror = ["x", "y"]', True), ("", False)):
            self.write("case.toml", f"[domain]\n{domain}\n[numerics]\ncell_size_m = 0.5\n")
            self.assertEqual(Run(self.folder).mirrored_y, mirrored, domain)
        for conveyor, mirrored in (("true", True), ("false", False)):
            self.write("case.toml", f"[conveyor]\nmirror_y = {conveyor}\n")
            self.assertEqual(Run(self.folder).mirrored_y, mirrored, conveyor)


class Checksums(RunFolder):
    """What a run wrote is what is read: a digit that changed is an error that names the file."""

    def setUp(self):
        super().setUp()
        series = SERIES + "0,1,1,nan,0,0,0,0,0,0\n1,5,4,2,9,0,1,0,2,0\n"
        self.write("series.csv", series)
        results = '{\n  "series_crc32": "' + checksum(series.encode()) + '",\n  "crc32": "00000000",\n  "runup_mean_m": 6.5\n}\n'
        self.results = results.replace("00000000", checksum(results.encode()))
        self.write("results.json", self.results)

    def test_that_are_right_are_not_noticed(self):
        run = Run(self.folder)
        self.assertEqual((run.number("runup_mean_m"), len(run.series)), (6.5, 2))

    def test_refuse_altered_results(self):
        for altered in (self.results.replace("6.5", "9e9"), self.results[:-1], "[]"):
            self.write("results.json", altered)
            with self.assertRaisesRegex(InputError, "results.json"):
                Run(self.folder).results

    def test_refuse_an_altered_series(self):
        for altered in (SERIES + "0,1,1,nan,0,0,0,0,0,0\n1,5,4,2,9e9,0,1,0,2,0\n", SERIES + "0,1,1,nan,0,0,0,0,0,0\n"):
            self.write("series.csv", altered)
            with self.assertRaisesRegex(InputError, "series.csv: it does not match its checksum"):
                Run(self.folder).series

    def test_refuse_an_altered_profile(self):
        self.write("profile.csv", profile := "z_m,pressure_pa\n0.1,7\n")
        results = '{\n  "profile_crc32": "' + checksum(profile.encode()) + '",\n  "crc32": "00000000"\n}\n'
        self.write("results.json", results.replace("00000000", checksum(results.encode())))
        self.assertEqual(Run(self.folder).profile["pressure_pa"][0], 7)
        self.write("profile.csv", profile.replace("7", "9e9"))
        with self.assertRaisesRegex(InputError, "profile.csv: it does not match its checksum"):
            Run(self.folder).profile

    def test_refuse_what_is_not_utf_8_and_name_its_line(self):
        (self.folder / "case.toml").write_bytes(b'title = "a"\n# Sch\xe4tze\n')
        with self.assertRaisesRegex(InputError, "case.toml:2: a character is not UTF-8"):
            Run(self.folder).case

    def test_refuse_an_altered_frame(self):
        path = self.folder / "frames" / "00000.h5"
        content = path.read_bytes()
        self.assertEqual(Run(self.folder).frames[0].time, 0.0)
        for altered in (content[:-30] + b"x" + content[-29:], content[:-1], content[:-16] + bytes(16), content[:5], b""):
            path.write_bytes(altered)
            with self.assertRaisesRegex(InputError, "00000.h5"):
                Run(self.folder).frames[0]["position_m"]

    def test_tell_whose_results_they_are(self):
        self.write("results.json", '{"case_hash": "1234", "duration_s": 2.0}')
        run = Run(self.folder)
        self.assertTrue(run.is_finished("1234") and run.is_finished("1234", 2.0))
        self.assertFalse(run.is_finished("1235") or run.is_finished("1234", 2.5) or run.is_finished("1234", 1.5))
        with self.assertRaisesRegex(InputError, "run it again"):
            run.require("1235", "run it again")


class Pictures(RunFolder):
    def test_are_drawn_for_what_a_run_holds(self):
        code, _, err = self.command("plot", self.folder)
        self.assertEqual(code, 0, err)
        for name in ("heights", "profile", "forces", "side_view"):
            self.assertTrue((self.folder / "post" / f"{name}.png").read_bytes().startswith(b"\x89PNG"), name)
        for name in ("profile.csv", "frames/00000.h5", "frames/00001.h5"):
            (self.folder / name).unlink()
        _, _, err = self.command("plot", self.folder, "--out", self.folder / "again")
        self.assertIn("no picture profile: the run has no steady interval", err)
        self.assertIn("no picture side_view: the run stored no frames", err)
        self.assertEqual(sorted(p.name for p in (self.folder / "again").iterdir()), ["forces.png", "heights.png"])

    def test_show_the_profile_that_the_run_measured(self):
        """Its windows may be those of [measurement], or lie along a cylinder: a profile of the particles here would be another one."""
        for figure in (run_pictures.draw_panels(Run(self.folder), "profile"), run_pictures.draw_side_view(Run(self.folder), [1.5])):
            drawn = [line.get_xydata() for axes in figure.axes for line in axes.lines if len(line.get_xdata()) == 3]
            self.assertTrue(any(np.array_equal(xy, [[4.0, 0.1], [2.0, 0.3], [1.0, 0.5]]) for xy in drawn), drawn)
            run_pictures.plt.close(figure)

    def test_of_forces_are_not_scaled_by_the_first_contact_and_heights_keep_their_width(self):
        rows = "".join(f"{0.02 * i},5,4,2,{428e3 if i < 2 else 120e3},0,0,0,{-100e3},0\n" for i in range(200))
        self.write("series.csv", SERIES + rows)
        figure = run_pictures.draw_panels(Run(self.folder), "forces")
        self.assertLess(figure.axes[0].get_ylim()[1], 250.0)
        self.assertEqual([text.get_text() for text in figure.axes[0].texts], ["up to 428 at first contact: force (kN)"])
        self.assertEqual(len(figure.axes[1].texts), 0)
        run_pictures.plt.close(figure)
        figure = run_pictures.draw_panels(Run(self.folder), "heights")
        figure.canvas.draw()
        for axes in figure.axes:
            self.assertGreater(axes.get_position().width, 0.75)
        run_pictures.plt.close(figure)

    def test_of_a_section_have_the_mast_above_the_dots(self):
        figure = run_pictures.draw_side_view(Run(self.folder), [1.5])
        mast, dots = figure.axes[0].patches[0], figure.axes[0].collections[0]
        self.assertGreater(mast.get_zorder(), dots.get_zorder())  # a dot is wider than its particle, and the outline no rectangle
        run_pictures.plt.close(figure)

    def test_show_the_heights_of_the_time_of_a_section(self):
        figure = run_pictures.draw_side_view(Run(self.folder), [1.5])
        heights = {line.get_label(): line.get_ydata()[0] for axes in figure.axes for line in axes.lines}
        self.assertEqual((heights["run-up now"], heights["pressure height now"]), (5.5, 2.5))
        run_pictures.plt.close(figure)

    def test_show_the_particles_of_the_measuring_strip_by_their_cauchy_stress(self):
        run = Run(self.folder)
        section = run_pictures.Section(run, run.frames[0], half_width=0.75)
        self.assertEqual(section.z.tolist(), [0.4, 2.0])  # the nearest to the axis last, on top
        self.assertEqual(section.stress.tolist(), [-20.0, -10.0])

    def test_on_a_full_disk_or_without_permission_leave_no_pieces(self):
        (self.folder / "file").write_text("")
        for out, limit in ((self.folder / "file" / "out", None), (self.folder / "full", 1000)):
            with largest_file(limit):
                code, _, err = self.command("plot", self.folder, "--out", out)
            self.assertEqual(code, 4, err)
            self.assertRegex(err, f"^mpmtools plot: cannot write '{out}/heights.png': [^\\n]*\n$")
        self.assertEqual(list((self.folder / "full").iterdir()), [])

    def test_say_what_is_wrong(self):
        self.assertEqual(self.command("plot", self.folder / "none")[0], 4)
        for times in ("a,b", "1,nan", "inf"):
            self.assertEqual(self.command("plot", self.folder, "--times", times)[0], 2, times)
        for size in ("wide", "0x100", "100x9000", "-64x64"):
            code, _, err = self.command("render", self.folder, "--size", size)
            self.assertEqual(code, 2, err)
            self.assertIn("pixels are needed", err)
        self.write("results.json", "{")
        self.assertEqual(self.command("plot", self.folder)[0], 4)
        self.assertEqual(self.command("render", self.folder)[0], 4)  # no frames.xdmf


class Outlines(InFolder):
    def test_come_from_the_run_folder_whatever_the_shape(self):
        self.write("case.toml", '[obstacle]\nshape = "of another program"\n')
        self.write("obstacle.json", '{"outline_m": [[0.0, 0.0], [3.0, -1.0], [3.0, 1.0]], "top_m": null}')
        run = Run(self.folder)
        self.assertEqual(run.obstacle_outline, [(0.0, 0.0), (3.0, -1.0), (3.0, 1.0)])
        self.assertEqual((run.obstacle_depth, run.obstacle_width), (3.0, 2.0))
        self.assertEqual(run.solids(-1.0, 9.0), [(run.obstacle_outline, -1.0, 9.0)])

    def test_are_those_of_the_obstacle_and_of_its_arm(self):
        self.write("case.toml", "[obstacle]\n[arm]\n")
        self.write("obstacle.json", '{"outline_m": [[0, -1], [2, -1], [2, 1]], "top_m": 3.0, "base_m": 1.0,'
                   ' "arm": {"outline_m": [[0.5, -3], [1, -3], [1, 3], [0.5, 3]], "top_m": 2.5, "base_m": 2.0}}')
        obstacle, arm = Run(self.folder).solids(-1.0, 9.0)
        self.assertEqual((obstacle[1:], arm[1:]), ((1.0, 3.0), (2.0, 2.5)))
        self.assertEqual((len(obstacle[0]), arm[0][0]), (3, (0.5, -3.0)))

    def test_that_are_missing_or_broken_are_reported(self):
        self.write("case.toml", "[obstacle]\n")
        with self.assertRaisesRegex(InputError, "mpm post"):
            Run(self.folder).obstacle_outline
        self.write("obstacle.json", "[]")
        with self.assertRaises(InputError):
            Run(self.folder).obstacle_outline


class BenchmarkHistory(InFolder):
    HEAD = ("date,commit,machine,kernel,ns_per_particle,baseline,ratio,ratio_low,ratio_high,verdict,instructions_per_particle,"
            "instruction_ratio\n")
    ROWS = ("2026-01-01T00,005551511e13,here,step,50.0,0,1.0500,1.0400,1.0600,slower,100,1.01\n"
            "2026-01-02T00,abc,here,step,40.0,005551511e13,0.9900,0.9800,1.0100,no change,,\n")

    def test_shows_changes_with_intervals_and_verdicts(self):
        path = self.write("history.csv", self.HEAD + self.ROWS)
        figure = history_figure(read_series(path, dtype={"commit": str, "baseline": str}), threshold=0.02)
        axes = figure.axes[0]
        self.assertEqual(axes.get_yscale(), "linear")
        low, high = axes.get_ylim()
        self.assertTrue(-8.0 < low < -5.0 and 5.0 < high < 8.0)  # a change of 5 % takes most of the axis
        points = sorted(tuple(np.round(xy, 9)) for line in axes.lines if line.get_marker() == "o" for xy in line.get_xydata())
        self.assertEqual(points, [(0.0, 5.0), (1.0, -1.0)])
        bars = [np.round(segment[:, 1], 9).tolist() for c in axes.collections if hasattr(c, "get_segments") for segment in c.get_segments()]
        self.assertIn([4.0, 6.0], bars)
        self.assertIn("slower, +5.0 %", [text.get_text() for text in axes.texts])
        self.assertTrue(any("005551511e13" in label.get_text() for label in axes.get_xticklabels()))
        run_pictures.plt.close(figure)

    def test_is_that_of_this_machine(self):
        path = self.write("history.csv", self.HEAD + self.ROWS)
        self.assertFalse(draw_history(path, self.folder / "none.png", "elsewhere", 0.02))
        self.assertTrue(draw_history(path, self.folder / "out" / "history.png", "here", 0.02))
        self.assertTrue((self.folder / "out" / "history.png").exists())


if __name__ == "__main__":
    unittest.main()
