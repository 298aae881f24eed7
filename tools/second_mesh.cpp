// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/second_mesh.h"

#include <fmt/format.h>

#include <new>

#include "core/error.h"
#include "core/muted_warnings.h"
#include "core/progress.h"
#include "mesh/machine_mesh.h"
#include "reduction/basis/mesh_error.h"
#include "solver/campaign/campaign.h"

namespace thermotwin::tools {
namespace {

double elements_of(const mesh::MachineMesh& mesh) {
  Eigen::Index count = 0;
  for (const mesh::TetMesh& body : mesh.bodies) count += body.elements();
  return count;
}

}  // namespace

std::optional<reduction::MeshError> mesh_error_of(const solver::FullModel& full, const solver::Case& machine_case,
                                                  const solver::LoadProgram& load, const solver::LoadResult& result,
                                                  const std::filesystem::path& out) {
  std::string reason = "element_size_mm has no influence on its bodies";
  const double size = mesh::size_factor(machine_case.machine, machine_case.size);
  const int order = machine_case.machine.order;
  for (const reduction::SecondMesh& wanted : reduction::second_meshes(order)) {
    try {
      const core::MutedWarnings muted;  // they would be about a mesh that nobody asked for
      mesh::Machine machine = machine_case.machine;
      machine.order = wanted.order;
      const mesh::MeshOptions options{wanted.factor * size, out / "cache"};
      const double ratio =
          reduction::edge_ratio(elements_of(full.mesh), elements_of(build_machine_mesh(machine, options)));
      const double factor = reduction::error_of_difference(order, wanted.order, ratio);
      if (factor == 0.0) continue;
      const solver::FullModel second = solver::build_full_model(machine, options);
      reduction::MeshError error =
          reduction::estimate_mesh_error(machine, {result}, solver::run_campaign(second, {load}, {}), factor);
      error.second = fmt::format("{} tetrahedra of {:.2f} times the size, {} nodes",
                                 wanted.order == 2 ? "quadratic" : "linear", ratio, second.mesh.nodes());
      return error;
    } catch (const core::Interrupted&) {
      throw;
    } catch (const core::Error& error) {  // a model is there already: it is worth more than this estimate
      reason = error.what();
    } catch (const std::bad_alloc&) {
      reason = "out of memory";
    }
  }
  core::warn("no second mesh, hence no estimate of the mesh error: " + reason);
  return std::nullopt;
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
