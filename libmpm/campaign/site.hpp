#pragma once
/// A site file: the avalanche and the mast. `mpm design` makes runs from it (design_plan.hpp).
///
///   [flow]
///   depth_m = 2.0
///   velocity_m_s = 14.0            # or froude_number
///   snow_class = "loose"           # or entries of [[snow]] with parameters of their own
///   [mast]
///   width_m = 0.8

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libmpm/boundary/obstacle_spec.hpp"
#include "libmpm/config/reference.hpp"
#include "libmpm/config/schema.hpp"

namespace mpm {

/// Key format_version of a site file; another version is refused.
inline constexpr int site_format_version = 1;

/// Kinds of snow with parameters from sources: design_snows().
enum class SnowClass : std::uint8_t { loose, cold_dense, warm_cohesive };
/// As in a site file: "cold_dense".
std::string to_string(SnowClass);

/// [flow]: the avalanche before it meets the mast.
struct SiteFlow {
  double depth = 0.0;                   ///< H, m, normal to the ground
  double velocity = 0.0;                ///< v, m/s; 0: not given
  std::optional<double> froude_number;  ///< v / sqrt(g cos(slope) H), given instead of velocity, which read_site computes from it
  double density = 300.0;               ///< kg/m^3
  double slope = 0.0;                   ///< rad
  double snow_cover = 0.0;              ///< m, of snow or a deposit under the flow
  std::optional<SnowClass> snow_class;  ///< empty: [[snow]] gives the snow
  std::string source;                   ///< where depth, speed and density come from
  bool operator==(const SiteFlow&) const = default;

  /// The keys of [flow] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("depth_m", &SiteFlow::depth).unit("m").range(0.05, 100.0).required().text("Depth H of the flow, normal to the ground");
    table.add("velocity_m_s", &SiteFlow::velocity)
        .unit("m/s")
        .positive(200.0)
        .left_out("froude_number is given instead (one of the two is required)")
        .text("Speed v of the flow, mean over the depth");
    table.add("froude_number", &SiteFlow::froude_number)
        .range(0.05, 20.0)
        .excludes("velocity_m_s")
        .left_out("velocity_m_s is given instead")
        .text("Fr = v / sqrt(g cos(slope) H)");
    table.add("density_kg_m3", &SiteFlow::density)
        .unit("kg/m^3")
        .range(10.0, 1000.0)
        .text("Density of the flowing snow; the default is a common estimate, quoted in the paper (Sect. 2.2)");
    table.add("slope_deg", &SiteFlow::slope)
        .degrees()
        .range(0.0, 60.0)
        .text(
            "Slope of the ground at the mast. It is assumed that ground friction keeps the flow at its speed, so that only g cos(slope) "
            "acts");
    table.add("snow_cover_m", &SiteFlow::snow_cover)
        .unit("m")
        .range(0.0, 50.0)
        .hide_default()
        .text("Height of a snow cover or a deposit on which the flow runs: the snow meets the mast higher, and the moment grows");
    table.add("snow_class", ParameterType::choice, get_class, set_class)
        .one_of({"loose", "cold_dense", "warm_cohesive", "wet_dense"})
        .left_out("[[snow]] gives the snow")
        .text(
            "Kind of snow, a range of three sets of parameters with sources in the table of presets: loose (dry), cold_dense (dry, dense), "
            "warm_cohesive or wet_dense (moist or wet, dense: two names of one class)");
    table.add("source", &SiteFlow::source)
        .hide_default()
        .text("Where depth, speed and density come from, for the page: model, scenario, return period");
  }

 private:
  static std::optional<ParameterValue> get_class(const SiteFlow& flow) {
    return flow.snow_class ? std::optional<ParameterValue>(to_string(*flow.snow_class)) : std::nullopt;
  }
  static void set_class(SiteFlow& flow, const ParameterValue& value) {
    const std::string& name = std::get<std::string>(value);
    for (const SnowClass c : {SnowClass::loose, SnowClass::cold_dense, SnowClass::warm_cohesive}) {
      if (to_string(c) == name) flow.snow_class = c;
    }
    if (name == "wet_dense") flow.snow_class = SnowClass::warm_cohesive;
  }
};

/// [[snow]]: one set of parameters of the snow, instead of a class.
struct SiteSnow {
  std::string name;                   ///< in the page and in the names of runs
  double critical_state_slope = 0.0;  ///< M
  double cohesion_beta = 0.0;         ///< beta
  double hardening_xi = 5.0;          ///< xi
  std::string source;                 ///< origin of the numbers
  bool operator==(const SiteSnow&) const = default;

  /// The keys of [[snow]] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("name", &SiteSnow::name).left_out("snow_1, snow_2, ...").text("Name in the page: letters, digits, '_', '-'");
    table.add("critical_state_slope", &SiteSnow::critical_state_slope).range(0.0, 10.0).required().text("Internal friction M");
    table.add("cohesion_beta", &SiteSnow::cohesion_beta)
        .below(0.0, 1.0)
        .required()
        .text("Cohesion beta: tensile over compressive strength");
    table.add("hardening_xi", &SiteSnow::hardening_xi).range(0.05, 100.0).required().text("Hardening xi; large: hardly compressible");
    table.add("source", &SiteSnow::source).text("Where these numbers come from, for the page");
  }
};

/// [mast]: rigid, upright, its front against the flow.
struct SiteMast {
  /// Its plan.
  enum class Shape : std::uint8_t { box, cylinder } shape = Shape::box;  ///< of its plan
  double width = 0.0;                                                    ///< w across the flow, diameter of a cylinder, m
  std::optional<double> depth;                                           ///< along the flow, of a box, m; read_site fills it in
  std::optional<double> height;                                          ///< m, above the ground; empty: taller than any jet
  double angle = 0.0;                                                    ///< rad, counter-clockwise from above, of a box
  double taper = 1.0;                                                    ///< width at the top over that at the foot, for the modes
  double top_mass_ratio = 0.0;                                           ///< mass at the top over that of the mast, for the modes
  double friction = 0.15;                                                ///< mu
  std::optional<double> drag_coefficient;                                ///< c_D of the guideline's force; empty: by the shape
  bool operator==(const SiteMast&) const = default;

  [[nodiscard]] ObstacleSpec obstacle() const;                              ///< its shape and height; in a resolved site
  [[nodiscard]] double facing_width() const { return obstacle().width(); }  ///< of what faces the flow, m

  /// The keys of [mast] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("shape", &SiteMast::shape, {"box", "cylinder"}).text("Plan of the mast: a box with a face against the flow, or a cylinder");
    table.add("width_m", &SiteMast::width).unit("m").range(0.05, 100.0).required().text("Width w across the flow, diameter of a cylinder");
    table.add("depth_m", &SiteMast::depth)
        .unit("m")
        .range(0.05, 100.0)
        .only_with("shape", {"box"})
        .left_out("width_m")
        .text("Depth along the flow");
    table.add("height_m", &SiteMast::height).unit("m").range(0.05, 1000.0).left_out("taller than any jet").text("Height above the ground");
    table.add("angle_deg", &SiteMast::angle)
        .degrees()
        .range(-90.0, 90.0)
        .only_with("shape", {"box"})
        .hide_default()
        .text(
            "Turns the mast about its vertical axis, counter-clockwise from above: an oblique flow. The whole flow is computed instead of "
            "half of it (twice the work), with lateral force and torsion");
    table.add("taper", &SiteMast::taper)
        .range(0.1, 2.0)
        .hide_default()
        .text(
            "Width at the top over that at the foot, for the modes of vibration: mass per height in proportion to the width, stiffness to "
            "its "
            "cube (a tube of constant wall). The runs have the width width_m at all heights");
    table.add("top_mass_ratio", &SiteMast::top_mass_ratio)
        .range(0.0, 100.0)
        .hide_default()
        .text("Mass at the top (crossarm, sheaves, ropes) over that of the mast, for the modes of vibration");
    table.add("friction", &SiteMast::friction)
        .range(0.0, 2.0)
        .text("Coulomb coefficient of snow on the mast; the paper does not give its own, and more friction lowers the run-up");
    table.add("drag_coefficient", &SiteMast::drag_coefficient)
        .range(0.5, 10.0)
        .left_out("1 for a cylinder, 2 for a box")
        .text("c_D of the guideline's force c_D rho v^2/2 w H, which the page sets beside the computed one; it changes no run");
  }
};

/// [[mode]]: a mode of vibration of the mast in the direction of the flow.
struct SiteMode {
  double frequency = 0.0;               ///< Hz
  double damping_ratio = 0.02;          ///< of critical damping
  std::optional<double> shape_at_load;  ///< mode shape at the load over that at the top; empty: a uniform cantilever
  bool operator==(const SiteMode&) const = default;

  /// The keys of [[mode]] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("frequency_hz", &SiteMode::frequency).unit("Hz").range(0.05, 20.0).required().text("Eigenfrequency");
    table.add("damping_ratio", &SiteMode::damping_ratio).range(0.0, 0.5).text("Damping over critical damping; the default is assumed");
    table.add("shape_at_load", &SiteMode::shape_at_load)
        .range(-1.0, 1.0)
        .left_out("cantilever with the taper and the top mass of [mast], weighted by the pressure over height at each time")
        .text(
            "Displacement of the mode at the load over that of the mast's top, weighted by the first impact of line_load.csv; the "
            "generalised "
            "force is this times the force");
  }
};

/// [[scenario]]: another avalanche at the same mast, for which the page scales the loads of [flow].
struct SiteScenario {
  std::string name;               ///< on the page
  double depth = 0.0;             ///< m
  double velocity = 0.0;          ///< m/s
  std::optional<double> density;  ///< kg/m^3; empty: that of [flow]
  bool operator==(const SiteScenario&) const = default;

  /// The keys of [[scenario]] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("name", &SiteScenario::name).required().text("Name on the page: \"100 years\"");
    table.add("depth_m", &SiteScenario::depth).unit("m").range(0.05, 100.0).required().text("Depth of the flow");
    table.add("velocity_m_s", &SiteScenario::velocity).unit("m/s").positive(200.0).required().text("Speed of the flow");
    table.add("density_kg_m3", &SiteScenario::density)
        .unit("kg/m^3")
        .range(10.0, 1000.0)
        .left_out("that of [flow]")
        .text("Density of the flowing snow");
  }
};

/// [range]: how uncertain the avalanche is. The page scales the loads of [flow] to the ends of the ranges.
struct SiteRange {
  double depth = 0.2, velocity = 0.2, density = 0.2;  ///< half of the range over the value
  bool operator==(const SiteRange&) const = default;

  /// The keys of [range] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    const auto add = [&](const char* key, double SiteRange::*member, const char* of) {
      table.add(key, member)
          .range(0.0, 0.9)
          .hide_default()
          .text(std::string("Half of the range of the ") + of + " over its value; assumed");
    };
    add("depth_ratio", &SiteRange::depth, "depth");
    add("velocity_ratio", &SiteRange::velocity, "speed");
    add("density_ratio", &SiteRange::density, "density");
  }
};

/// [plan]: grids and duration. Omitted values follow from the level of `mpm design`.
struct SitePlan {
  int finest_cells = 0;            ///< cells in the smaller of w and H, of the finest grid; 0: by the level
  int grids = 0;                   ///< 2 or 3; 0: by the level
  std::optional<double> duration;  ///< s
  bool operator==(const SitePlan&) const = default;

  /// The keys of [plan] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("finest_cells", &SitePlan::finest_cells)
        .one_of({"5", "7", "11", "15", "21"})
        .hide_default()
        .left_out("the finest that the time of the level allows")
        .text("Cells in the smaller of mast width and flow depth on the finest grid");
    table.add("grids", &SitePlan::grids)
        .one_of({"2", "3"})
        .hide_default()
        .left_out("as many as the time of the level allows")
        .text("Number of grids");
    table.add("duration_s", &SitePlan::duration)
        .unit("s")
        .positive(1000.0)
        .left_out("from speed, depth and width")
        .text("Simulated time of each run");
  }
};

/// A site file with every default filled in.
struct Site {
  std::string title;                    ///< heading of the page
  std::string author;                   ///< who answers for the page
  std::string project;                  ///< number or name of the project
  SiteFlow flow;                        ///< [flow]
  std::vector<SiteSnow> snows;          ///< [[snow]]
  SiteMast mast;                        ///< [mast]
  std::optional<ArmSpec> arm;           ///< [arm], heights above the ground
  std::vector<SiteMode> modes;          ///< [[mode]]
  SiteRange range;                      ///< [range]
  std::vector<SiteScenario> scenarios;  ///< [[scenario]]
  SitePlan plan;                        ///< [plan]
  bool operator==(const Site&) const = default;

  [[nodiscard]] double gravity() const;        ///< g cos(slope), m/s^2
  [[nodiscard]] double froude_number() const;  ///< v / sqrt(g cos(slope) H)
  /// m, of the mast above the snow cover; empty: taller than any jet.
  [[nodiscard]] std::optional<double> exposed_height() const;

  /// The keys above the first table.
  template <class Table>
  static void declare(Table& table) {
    table.add("title", &Site::title).text("Heading of the page");
    table.add("author", &Site::author).text("Who answers for the page; printed on every sheet");
    table.add("project", &Site::project).text("Number or name of the project; printed on every sheet");
    table.add_constant("format_version", site_format_version).text("Version of the format of this file");
  }
};

[[nodiscard]] const config::SchemaOf<Site>& site_schema();  ///< of site files

/// Reads a site file. @throws ConfigError with all errors at once, as read_case, and where the keys are listed; IoError
[[nodiscard]] Site read_site(const std::filesystem::path& file);
/// The same from memory. @param file_name  for messages
[[nodiscard]] Site parse_site(std::string_view text, std::string_view file_name);
/// Every key that applies: parse_site(write_site(s)) == s.
[[nodiscard]] std::string write_site(const Site& site);

/// The snows of a site: its [[snow]] entries, or three sets of parameters of its class, each with its source.
///
/// loose: beta 0.15 and xi 0.5 of the paper's dry, loose avalanche (Sect. 4.3), M' = 0.45, 0.59, 0.65: the range that corresponds to the
/// guideline's lambda = 1.5 (Sect. 4.2) and the paper's own value. cold_dense: beta 0.3, xi 1.5 of its dense avalanche, M' = 1.0, 1.32, 1.5
/// (lambda = 3). warm_cohesive (assumed): beta 0.45 and xi 5, the most cohesive and least compressible snow of the relevant range of
/// Table 1, M' = 1.0, 1.25, 1.5, as the guideline counts wet avalanches among the dense.
[[nodiscard]] std::vector<SiteSnow> design_snows(const Site& site);

/// What `mpm schema --site` prints.
[[nodiscard]] config::Reference site_reference();

}  // namespace mpm
