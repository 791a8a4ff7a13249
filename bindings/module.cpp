/// The Python module `libmpm`: point paths, predictions, and stepping a scene, inside the Python process.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/driver/build_info.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/point_path.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/driver/threads.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/io/snapshot.hpp"

namespace py = pybind11;

namespace {

using Array = py::array_t<double>;

/// A copy of numbers as an array of the given shape.
Array array_of(const std::vector<double>& values, std::vector<py::ssize_t> shape) {
  Array result(std::move(shape));
  std::copy(values.begin(), values.end(), result.mutable_data());
  return result;
}

/// A path as columns, named as in the CSV of `mpm point`; and the stress.
py::dict point_path(const std::string& text, const std::vector<std::string>& changes) {
  const std::vector<mpm::PathRow> rows = mpm::follow_path(mpm::parse_path(text, "path", changes));
  const auto n = static_cast<py::ssize_t>(rows.size());
  std::array<Array, mpm::path_columns.size()> columns;
  for (Array& column : columns) column = Array(n);
  Array stress(std::vector<py::ssize_t>{n, 6});
  for (py::ssize_t i = 0; i < n; ++i) {
    const mpm::PathRow& r = rows[static_cast<std::size_t>(i)];
    const std::array values{static_cast<double>(r.step), r.eps_v, r.eps_q, r.p, r.q, r.eps_v_plastic, r.preconsolidation_pressure, r.yield};
    for (std::size_t c = 0; c < columns.size(); ++c) columns[c].mutable_at(i) = values[c];
    const std::array tau{r.stress.xx, r.stress.yy, r.stress.zz, r.stress.xy, r.stress.xz, r.stress.yz};
    for (std::size_t k = 0; k < tau.size(); ++k) stress.mutable_at(i, static_cast<py::ssize_t>(k)) = tau[k];
  }
  py::dict result;
  for (std::size_t c = 0; c < columns.size(); ++c) result[py::str(std::string(mpm::path_columns[c]))] = columns[c];
  result["kirchhoff_stress_pa"] = stress;
  return result;
}

/// A scene and its state.
class Simulation {
 public:
  Simulation(const std::string& text, const std::vector<std::string>& changes)
      : spec_(mpm::parse_case(text, "case", changes)), scene_(mpm::make_scene(spec_)), state_(mpm::make_state(spec_, scene_)) {}

  [[nodiscard]] double time() const { return state_.time; }
  [[nodiscard]] std::uint64_t steps() const { return state_.step; }
  [[nodiscard]] std::size_t particle_count() const { return state_.grid.particle_count(); }
  [[nodiscard]] double stable_time_step() const { return mpm::stable_time_step(state_, scene_); }
  [[nodiscard]] std::size_t boundary_count() const { return scene_.boundaries.size(); }
  [[nodiscard]] std::optional<std::size_t> obstacle() const { return scene_.obstacle; }
  [[nodiscard]] std::string case_text() const { return mpm::write_case(spec_); }

  py::dict step(std::optional<double> dt) {
    const double size = dt.value_or(stable_time_step());
    if (!(size > 0.0)) throw mpm::ConfigError("step: dt = " + std::to_string(size) + " s; give a time step above 0");
    History history;
    {
      const py::gil_scoped_release release;
      history.add(mpm::step(state_, scene_, size), state_.time);
    }
    return history.columns(boundary_count());
  }

  py::dict advance(double time) {
    if (!(time >= state_.time))
      throw mpm::ConfigError("advance: time = " + std::to_string(time) + " s is before the present one, " + std::to_string(state_.time) +
                             " s");
    History history;
    {
      const py::gil_scoped_release release;
      mpm::advance(state_, scene_, time, [&](const mpm::StepReport& report) { history.add(report, state_.time); });
    }
    return history.columns(boundary_count());
  }

  [[nodiscard]] py::dict particles() const {
    const mpm::ParticleTable t = mpm::particle_table(state_, scene_);
    const auto n = static_cast<py::ssize_t>(t.size());
    py::dict result;
    py::array_t<std::uint64_t> id(n);
    std::copy(t.id.begin(), t.id.end(), id.mutable_data());
    result["id"] = id;
    result["position_m"] = array_of(t.position, {n, 3});
    result["velocity_m_s"] = array_of(t.velocity, {n, 3});
    result["kirchhoff_stress_pa"] = array_of(t.stress, {n, 6});
    result["internal"] = array_of(t.internal, {n});
    result["volume_ratio"] = array_of(t.volume_ratio, {n});
    result["reference_volume_m3"] = array_of(t.volume, {n});
    return result;
  }

 private:
  /// Impulses on the boundaries in each step.
  struct History {
    std::vector<double> time, dt, force;

    void add(const mpm::StepReport& report, double now) {
      time.push_back(now);
      dt.push_back(report.dt);
      for (const mpm::Impulse& impulse : report.impulses) {
        for (int axis = 0; axis < 3; ++axis) force.push_back(impulse.linear[axis] / report.dt);
      }
    }
    [[nodiscard]] py::dict columns(std::size_t boundaries) const {
      const auto n = static_cast<py::ssize_t>(time.size());
      py::dict result;
      result["time_s"] = array_of(time, {n});
      result["dt_s"] = array_of(dt, {n});
      result["force_n"] = array_of(force, {n, static_cast<py::ssize_t>(boundaries), 3});
      return result;
    }
  };

  mpm::Case spec_;
  mpm::CaseScene scene_;
  mpm::State state_;
};

}  // namespace

PYBIND11_MODULE(libmpm, m) {
  m.doc() =
      "libmpm in this process: point paths, the paper's equations, and stepping a small scene. Cases and paths are texts in TOML, as "
      "in the files of the command mpm. For whole runs with results use mpmtools.";
  m.attr("__version__") = mpm::build_info().version;
  m.attr("instruction_set") = mpm::build_info().instruction_set;

  static py::exception<mpm::Error> error(m, "MpmError");
  static py::exception<mpm::ConfigError> config_error(m, "ConfigError", error.ptr());
  static py::exception<mpm::UnstableError> unstable_error(m, "UnstableError", error.ptr());
  static py::exception<mpm::IoError> io_error(m, "InputError", error.ptr());
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const mpm::ConfigError& e) {
      config_error(e.what());
    } catch (const mpm::UnstableError& e) {
      unstable_error(e.what());
    } catch (const mpm::IoError& e) {
      io_error(e.what());
    } catch (const mpm::Error& e) {
      error(e.what());
    }
  });

  m.def("set_threads", &mpm::start_threads, py::arg("threads"), "Number of threads of all that follows; it changes no result.");
  m.def("point_path", &point_path, py::arg("text"), py::arg("changes") = std::vector<std::string>{},
        "Leads one material point along a path (TOML with [material] and [path]). Returns the columns of `mpm point` as arrays, and "
        "kirchhoff_stress_pa (n, 6): xx yy zz xy xz yz, tension positive. changes: texts 'table.key=value'.");

  m.def("effective_friction", py::vectorize(&mpm::effective_friction), py::arg("critical_state_slope"), py::arg("cohesion_beta"),
        "M' (Eq. 2)");
  m.def("predicted_runup", py::vectorize(&mpm::predicted_runup), py::arg("effective_friction"), py::arg("velocity_m_s"),
        py::arg("flow_height_m"), py::arg("gravity_m_s2") = mpm::standard_gravity, "Steady run-up by Eqs. 7 to 10, m; for w = H");
  m.def("predicted_pressure_height", py::vectorize(&mpm::predicted_pressure_height), py::arg("effective_friction"), py::arg("velocity_m_s"),
        py::arg("flow_height_m"), py::arg("gravity_m_s2") = mpm::standard_gravity, "Steady pressure height by Eqs. 7 to 10, m; for w = H");
  m.def("guideline_runup", py::vectorize(&mpm::guideline_runup), py::arg("velocity_m_s"), py::arg("dissipation"), py::arg("width_factor"),
        py::arg("gravity_m_s2") = mpm::standard_gravity, "v^2/(2 g lambda) f (Eq. 5), m above the surface of the avalanche");
  m.def("width_factor", py::vectorize(&mpm::width_factor), py::arg("relative_width"), "f(w/H) (Eq. 6)");
  m.def("bernoulli_height", py::vectorize(&mpm::bernoulli_height), py::arg("velocity_m_s"), py::arg("flow_height_m"),
        py::arg("gravity_m_s2") = mpm::standard_gravity, "H + v^2/(2 g), m");

  py::class_<Simulation>(m, "Simulation",
                         "A scene that is stepped from Python. Simulation(text, changes=[]): a case in TOML, and texts 'table.key=value'.")
      .def(py::init<const std::string&, const std::vector<std::string>&>(), py::arg("text"),
           py::arg("changes") = std::vector<std::string>{})
      .def_property_readonly("time", &Simulation::time, "s")
      .def_property_readonly("steps", &Simulation::steps, "steps done")
      .def_property_readonly("particle_count", &Simulation::particle_count)
      .def_property_readonly("stable_time_step", &Simulation::stable_time_step, "s, for the next step")
      .def_property_readonly("boundary_count", &Simulation::boundary_count, "walls, and last the obstacle")
      .def_property_readonly("obstacle", &Simulation::obstacle, "number of the boundary that is the obstacle; None without one")
      .def_property_readonly("case_text", &Simulation::case_text, "the case with every default, as TOML")
      .def("step", &Simulation::step, py::arg("dt") = py::none(),
           "One step, of the stable size unless dt (s) is given. Returns what advance() returns, for this step.")
      .def("advance", &Simulation::advance, py::arg("time"),
           "Steps until `time` (s). Returns time_s (n), dt_s (n) and force_n (n, boundaries, 3): the force of the snow on each boundary in "
           "each step, on the computed part.")
      .def("particles", &Simulation::particles,
           "Copies of the particles in the order of their identity numbers: id, position_m (n, 3), velocity_m_s (n, 3), "
           "kirchhoff_stress_pa (n, 6), internal, volume_ratio, reference_volume_m3.");
}
