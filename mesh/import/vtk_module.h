// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Interface of the module that links VTK. It is loaded at run time.

#include <filesystem>
#include <string>
#include <vector>

#include "mesh/import/vtk_grid.h"

namespace thermotwin::mesh {

/// Functions of the module, see vtk_grid.h.
struct VtkModule {
  /// @param place  for messages  @throws SolverError
  std::string (*file_bytes)(const VtkGrid& grid, VtkFile kind, const std::string& place);
  VtkGrid (*read)(const std::filesystem::path& path, const std::vector<std::string>& arrays);
  VtkValues (*interpolate)(const VtkGrid& grid, const Eigen::VectorXd& of_points, const Eigen::Matrix3Xd& at);
};

}  // namespace thermotwin::mesh
