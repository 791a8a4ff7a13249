#pragma once
/// Rasters of uneven ground: the text of [terrain] raster, and the files that it may come from.

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "libmpm/boundary/terrain.hpp"

namespace mpm {

class ParameterReport;

/// Reads an ESRI ASCII grid: ncols, nrows, xllcenter or xllcorner, yllcenter or yllcorner, cellsize and perhaps nodata_value, each with its
/// number, then the heights row by row from the north. Line breaks are blanks. @param problem  what is wrong and the remedy, as the end of
/// a sentence; empty: nothing
[[nodiscard]] HeightField::Points parse_raster(std::string_view text, std::string& problem);

/// The same points as one line, with the fewest digits that read back to the same numbers.
[[nodiscard]] std::string raster_text(const HeightField::Points& points);

/// Converts [terrain] file to raster, so that the case does not depend on the file, and writes a raster in its shortest form. Files: an
/// ESRI ASCII grid, or a table .csv with the columns x_m, y_m, z_m, whose points are a regular grid in any order. Problems name the file,
/// the place and the remedy. @param folder  of the case file, to which the name is relative
void read_terrain(TerrainSpec& terrain, const std::filesystem::path& folder, ParameterReport& report);

/// What makes the ground unfit for a domain: the raster does not cover it, is too steep, or is not symmetric about a mirror plane.
/// @param low, high  corners of the whole domain in plan, m. @returns ends of sentences, each with the remedy
[[nodiscard]] std::vector<std::string> terrain_problems(const HeightField& ground, const Vec2& low, const Vec2& high,
                                                        const MirrorPlanes& mirror);

/// The ground of a case that was read.
[[nodiscard]] std::shared_ptr<const HeightField> height_field(const TerrainSpec& terrain);

}  // namespace mpm
