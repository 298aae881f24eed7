// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The machine of small_machine.h as a full model.

#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "solver/thermal/assembly.h"
#include "tests/reduction/small_machine.h"

namespace thermotwin::test {

/// @param finer  as small_machine_mesh takes it
inline solver::FullModel boxes(int finer = 1) {
  mesh::MachineMesh mesh = small_machine_mesh(finer);
  solver::ThermalSystem thermal = solver::assemble_thermal(mesh);
  solver::ElasticModel elastic(mesh, thermal);
  return {std::move(mesh), std::move(thermal), std::move(elastic)};
}

}  // namespace thermotwin::test
