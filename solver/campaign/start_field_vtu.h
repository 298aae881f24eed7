// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The field of another run, on whatever mesh, to start from.

#include <filesystem>

#include "mesh/machine_mesh.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

struct StartField {
  Eigen::VectorXd temperature;  ///< (size) K above the reference
  double farthest = 0;          ///< m: of a node outside the other mesh to the place it took its value from
};

/// Interpolates temperature_C of a fields .vtu in each body's home frame; a node outside the other
/// mesh takes the value at its nearest place. Fluid nodes: the mean of their wall.
/// @throws InputError: no such array, bodies of other names
StartField field_from_vtu(const std::filesystem::path& path, const mesh::MachineMesh& mesh,
                          const ThermalSystem& thermal);

}  // namespace thermotwin::solver
