// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/second_mesh.h"

#include <fmt/format.h>

#include "core/progress.h"
#include "reduction/basis/mesh_error.h"
#include "reduction/basis/second_model.h"
#include "solver/campaign/campaign.h"

namespace thermotwin::tools {

std::optional<reduction::MeshError> mesh_error_of(const solver::FullModel& full, const solver::Case& machine_case,
                                                  const solver::LoadProgram& load, const solver::LoadResult& result,
                                                  const std::filesystem::path& out) {
  std::optional<reduction::MeshError> error;
  const std::string reason = reduction::with_second_model(
      machine_case, full.mesh, machine_case.machine.sensors, out / "cache", [&](const reduction::SecondModel& second) {
        error = reduction::estimate_mesh_error(second.full.mesh.machine, {result},
                                               solver::run_campaign(second.full, {load}, {}), second.factor);
        error->second = fmt::format("{} tetrahedra of {:.2f} times the size, {} nodes",
                                    second.full.mesh.machine.order == 2 ? "quadratic" : "linear", second.ratio,
                                    second.full.mesh.nodes());
      });
  if (!error) core::warn("no second mesh, hence no estimate of the mesh error: " + reason);
  return error;
}

std::string about_measured_mesh(const reduction::ReducedModel& model, Eigen::Index measured_nodes) {
  const std::string nodes = fmt::format("{} nodes", measured_nodes);
  const std::size_t at = model.size.find(nodes);
  if (at == std::string::npos || (at > 0 && model.size[at - 1] >= '0' && model.size[at - 1] <= '9'))
    return "another mesh than the model's, which has " + model.size;
  return "the model's own mesh, since element_size_mm does not change it: the mesh error takes no part in these "
         "figures";
}

}  // namespace thermotwin::tools
