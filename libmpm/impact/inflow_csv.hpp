#pragma once
/// Inflow over time from a table, such as the result of a path model at the mast.

#include <filesystem>

#include "libmpm/impact/conveyor_spec.hpp"

namespace mpm {

class ParameterReport;

/// Turns [conveyor] inflow_csv into rows of [[conveyor.inflow]], so that a case is complete without the file. Columns: time_s, depth_m,
/// velocity_m_s, and perhaps density_kg_m3, which becomes the ratio to the material's density. Where the conveyor's own speed or height is
/// not given, it is that of the row with the greatest momentum flux v^2 H, so that 2 v/g and the equations belong to the strongest flow.
/// Does nothing without inflow_csv. Problems name the file, the row and the remedy.
/// @param folder   of the case file, to which the name is relative
/// @param density  of the material, kg/m^3
void read_inflow_csv(ConveyorSpec& belt, const std::filesystem::path& folder, double density, ParameterReport& report);

}  // namespace mpm
