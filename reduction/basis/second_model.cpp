// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/second_model.h"

#include <fmt/format.h>

#include <new>

#include "core/error.h"
#include "core/muted_warnings.h"
#include "reduction/basis/mesh_error.h"

namespace thermotwin::reduction {
namespace {

double elements_of(const mesh::MachineMesh& mesh) {
  Eigen::Index count = 0;
  for (const mesh::TetMesh& body : mesh.bodies) count += body.elements();
  return 1.0 * count;
}

}  // namespace

std::string SecondModel::words() const {
  return fmt::format("{} tetrahedra, {} nodes", full.mesh.machine.order == 2 ? "quadratic" : "linear",
                     full.mesh.nodes());
}

std::string with_second_model(const solver::Case& machine_case, const mesh::MachineMesh& mesh,
                              const std::vector<mesh::SensorSpec>& sensors, const std::filesystem::path& cache,
                              const std::function<void(const SecondModel&)>& use) {
  std::string reason = "element_size_mm has no influence on its bodies";
  const double size = mesh::size_factor(machine_case.machine, machine_case.size);
  const int order = machine_case.machine.order;
  for (const SecondMesh& wanted : second_meshes(order)) {
    try {
      const core::MutedWarnings muted;  // they would be about a mesh that nobody asked for
      mesh::Machine machine = machine_case.machine;
      machine.order = wanted.order;
      machine.sensors = sensors;
      const mesh::MeshOptions options{wanted.factor * size, cache};
      const double ratio = edge_ratio(elements_of(mesh), elements_of(build_machine_mesh(machine, options)));
      const double factor = error_of_difference(order, wanted.order, ratio);
      if (factor == 0.0) continue;
      use({solver::build_full_model(machine, options), factor, ratio});
      return "";
    } catch (const core::Interrupted&) {
      throw;
    } catch (const core::Error& error) {
      reason = error.what();
    } catch (const std::bad_alloc&) {
      reason = "out of memory";
    }
  }
  return reason;
}

}  // namespace thermotwin::reduction
