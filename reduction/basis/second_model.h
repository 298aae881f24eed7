// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A full model of a case on a second mesh (mesh_error.h), to compare with.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mesh/machine_mesh.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::reduction {

struct SecondModel {
  const solver::FullModel& full;
  double factor;  ///< from the difference to the error, see error_of_difference
  double ratio;   ///< of the edge lengths

  std::string words() const;  ///< "quadratic tetrahedra, 1234 nodes"
};

/// Builds models on second_meshes() until one differs enough, and uses it. What `use` throws of core::Error, but for
/// Interrupted, and std::bad_alloc count as a mesh that cannot be used: a model is there already, and worth more.
/// @param mesh     first mesh of the case
/// @param sensors  of the second model
/// @param cache    folder of meshes
/// @return why no second model was used; empty: one was
std::string with_second_model(const solver::Case& machine_case, const mesh::MachineMesh& mesh,
                              const std::vector<mesh::SensorSpec>& sensors, const std::filesystem::path& cache,
                              const std::function<void(const SecondModel&)>& use);

/// The same with joints divided twice as finely (mesh::with_finer_pads) and the factor error_of_pads.
/// @param on_first  on the case's own mesh, else on that of with_second_model
std::string with_finer_joints(const solver::Case& machine_case, const mesh::MachineMesh& mesh,
                              const std::vector<mesh::SensorSpec>& sensors, const std::filesystem::path& cache,
                              bool on_first, const std::function<void(const SecondModel&)>& use);

/// The same on a mesh of the same tetrahedra with smaller edges, and with factor 1: rules with boxes take other
/// triangles there, so that areas of sources, films and contacts differ as they may from those of the machine.
std::string with_finer_model(const solver::Case& machine_case, const mesh::MachineMesh& mesh,
                             const std::vector<mesh::SensorSpec>& sensors, const std::filesystem::path& cache,
                             const std::function<void(const SecondModel&)>& use);

}  // namespace thermotwin::reduction
