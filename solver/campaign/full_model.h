// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The full model of a machine on one mesh.

#include "mesh/machine_mesh.h"
#include "solver/elastic/model.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

/// The full model of a machine on one mesh, everything that is made once.
struct FullModel {
  mesh::MachineMesh mesh;
  ThermalSystem thermal;
  ElasticModel elastic;
  MemoryPlan memory{};
};

FullModel build_full_model(const mesh::Machine& machine, const mesh::MeshOptions& options,
                           SolverChoice choice = SolverChoice::automatic);

}  // namespace thermotwin::solver
