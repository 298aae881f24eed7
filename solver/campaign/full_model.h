// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The full model of a machine on one mesh, built once for all loads and poses.

#include "mesh/machine_mesh.h"
#include "solver/elastic/model.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

/// Mesh, thermal system and elastic model of a machine.
struct FullModel {
  mesh::MachineMesh mesh;
  ThermalSystem thermal;
  ElasticModel elastic;
  MemoryPlan memory{};
};

/// Meshes the machine and assembles and factorises its systems. @throws MeshError, InputError, SolverError
FullModel build_full_model(const mesh::Machine& machine, const mesh::MeshOptions& options,
                           SolverChoice choice = SolverChoice::automatic);

}  // namespace thermotwin::solver
