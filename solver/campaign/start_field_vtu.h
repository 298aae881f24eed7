// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The initial temperature field of a run, interpolated from the output of another run whose mesh may differ.

#include <filesystem>

#include "mesh/machine_mesh.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

struct StartField {
  Eigen::VectorXd temperature;  ///< (size) K above the reference
  double farthest = 0;          ///< m, largest distance of a node from the place of its value
};

/// Interpolates temperature_C of a .vtu of fields.pvd in each body's home frame. A node outside the other mesh takes
/// the value of the nearest place, a fluid node the mean of its wall.
/// @throws InputError if the array is missing or the bodies have other names
StartField field_from_vtu(const std::filesystem::path& path, const mesh::MachineMesh& mesh,
                          const ThermalSystem& thermal);

}  // namespace thermotwin::solver
