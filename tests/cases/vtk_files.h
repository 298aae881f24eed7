// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What VTK's own readers find in a file for ParaView.

#include <filesystem>
#include <string>
#include <vector>

namespace thermotwin::cases {

struct VtkFile {
  long points = 0, cells = 0;
  std::vector<std::string> point_arrays, cell_arrays, field_arrays;
  double time = 0;                     ///< field data TimeValue
  double lowest_C = 0, highest_C = 0;  ///< of temperature_C, where it is there
  bool finite = true;                  ///< all point arrays
};

/// .vtu or .vtp. @throws std::runtime_error if the reader does not accept it
VtkFile read_vtk(const std::filesystem::path& file);

}  // namespace thermotwin::cases
