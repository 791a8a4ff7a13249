#pragma once
/// Inflow over time from a table, such as the result of a path model at the mast.

#include <filesystem>

#include "libmpm/impact/conveyor_spec.hpp"

namespace mpm {

class ParameterReport;

/// Converts [conveyor] inflow_csv to rows of [[conveyor.inflow]], so that the case does not depend on the file. Columns: time_s, depth_m,
/// velocity_m_s, and optionally density_kg_m3, which becomes the ratio to the material's density. If the conveyor's own speed or height is
/// not given, it is taken from the row with the greatest momentum flux v^2 H, so that 2 v/g and the equations refer to the strongest flow.
/// Does nothing without inflow_csv. Problems name the file, the row and the remedy.
/// @param folder   of the case file, to which the name is relative
/// @param density  of the material, kg/m^3
void read_inflow_csv(ConveyorSpec& belt, const std::filesystem::path& folder, double density, ParameterReport& report);

}  // namespace mpm
