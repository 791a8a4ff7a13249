#pragma once
/// Uneven ground, as a case gives it.

#include <optional>
#include <string>

#include "libmpm/base/types.hpp"
#include "libmpm/boundary/contact.hpp"

namespace mpm {

/// [terrain]: the ground as a raster of heights.
struct TerrainSpec {
  std::optional<std::string> file;       ///< with the raster; its content becomes `raster` when a case is read
  std::optional<std::string> raster;     ///< an ESRI ASCII grid in the coordinates of the case
  Contact contact = Contact::separable;  ///< how the surface acts (boundary/contact.hpp)
  double friction = 0.0;                 ///< Coulomb mu; slip and separable only
  double speed = 0.0;                    ///< of the surface along x, m/s; along z it follows the slope
  bool operator==(const TerrainSpec&) const = default;

  /// The keys of [terrain] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("file", &TerrainSpec::file)
        .left_out("raster is given instead (one of the two is required)")
        .excludes("raster")
        .text(
            "Heights of the ground, relative to the case file: an ESRI ASCII grid, or a table (.csv) of a regular grid with the columns "
            "x_m, "
            "y_m, z_m; in the coordinates of the case. Its content becomes raster, so that the case does not depend on the file");
    table.add("raster", &TerrainSpec::raster)
        .left_out("file is given instead (one of the two is required)")
        .text(
            "The same as text in the case: an ESRI ASCII grid with blanks instead of line breaks. Heights between its points are "
            "interpolated by cubics");
    table.add("contact", &TerrainSpec::contact, {"no_slip", "slip", "separable"})
        .text("no_slip: sticks; slip: stays on the ground and slides; separable: slides and may lift off");
    table.add("friction", &TerrainSpec::friction)
        .range(0.0, 10.0)
        .only_with("contact", {"slip", "separable"})
        .text("Coulomb coefficient mu, in the tangent plane");
    table.add("surface_speed_m_s", &TerrainSpec::speed)
        .unit("m/s")
        .range(-fastest_speed, fastest_speed)
        .text("Speed of the surface along x, as of a belt that follows the ground");
  }
};

}  // namespace mpm
