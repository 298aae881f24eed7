// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/full_model.h"

#include "core/progress.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/isolated_check.h"

namespace thermotwin::solver {

FullModel build_full_model(const mesh::Machine& machine, const mesh::MeshOptions& options, SolverChoice choice) {
  mesh::MachineMesh mesh = mesh::build_machine_mesh(machine, options);
  ThermalSystem thermal = assemble_thermal(mesh);
  for (const std::string& sentence : isolated_parts(mesh, thermal)) core::warn(sentence);
  MemoryPlan memory;
  memory.heat = heat_memory_need(thermal, choice, memory.wide);
  ElasticOptions elastic_options;
  elastic_options.choice = choice;
  elastic_options.plan = &memory;
  ElasticModel elastic(mesh, thermal, elastic_options);
  thermal.solver = memory.heat_solver;
  core::log_line(memory.brief());
  return {std::move(mesh), std::move(thermal), std::move(elastic), memory};
}

}  // namespace thermotwin::solver
