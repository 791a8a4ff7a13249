#pragma once
/// Pictures of the flow in the report: the particles of one instant, seen from the side (x to the right, z upwards), coloured by a field.
/// The case stores the particles, the report script draws them:
///
///   result.flows.push_back(flow_picture(context.directory(), state, scene,
///                                       {.id = "front", .field = FlowField::speed, .title = "Collapse, t = 1 s",
///                                        .caption = "...", .slice_half_width = 0.1}));

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/core/step.hpp"
#include "libmpm/driver/case.hpp"

namespace mpm::validation {

/// The field that colours the particles.
enum class FlowField {
  speed,       ///< |v|, m/s
  velocity_x,  ///< m/s
  velocity_z,  ///< m/s
  pressure,    ///< Cauchy, -tr(sigma)/3, compression positive, kPa
  stress_xx,   ///< Cauchy, tension positive, kPa
  density,     ///< rho_0 / J, kg/m^3
};
std::string to_string(FlowField);

struct FlowPicture {
  std::string id;  ///< file name, unique in its case
  FlowField field = FlowField::speed;
  std::string title, caption = {};
  double slice_half_width = 0.0;                     ///< m; particles with |y| <= this are drawn; 0: all
  std::optional<std::array<double, 4>> window = {};  ///< x_min, x_max, z_min, z_max, m; empty: around the particles
  std::optional<std::array<double, 2>> range = {};   ///< of the colours, in the field's unit; empty: that of the slice
  // The rest is filled in by flow_picture.
  std::filesystem::path snapshot = {};            ///< frame file of io/snapshot.hpp
  double time = 0.0;                              ///< s
  std::vector<std::array<double, 4>> walls = {};  ///< a point of the plane and its normal into the material: x, z, n_x, n_z
  std::vector<std::array<double, 4>> boxes = {};  ///< x_min, z_min, x_max, z_max, m
};

/// Stores the particles of `state` that the picture shows below `directory` and completes the picture with them and the scene's boundaries.
/// @throws IoError
FlowPicture flow_picture(const std::filesystem::path& directory, const State& state, const Scene& scene, FlowPicture picture);

/// The same from frame `index` that run_case left in `run_directory`. @throws IoError, ConfigError
FlowPicture flow_picture_of_run(const std::filesystem::path& run_directory, int index, const Case& c, FlowPicture picture);

}  // namespace mpm::validation
