// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/second_model.h"

#include <fmt/format.h>

#include <cmath>
#include <new>

#include "core/error.h"
#include "core/muted_warnings.h"
#include "mesh/machine/finer_pads.h"
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

namespace {

constexpr double finer = 0.8;
constexpr int finer_joints = 2;

/// Uses a model on the first of the meshes whose factor is not nought. @param factor_of  a mesh, by its edges' ratio
std::string with_one_of(const std::vector<SecondMesh>& meshes, const solver::Case& machine_case,
                        const mesh::MachineMesh& mesh, const std::vector<mesh::SensorSpec>& sensors,
                        const std::filesystem::path& cache,
                        const std::function<double(const SecondMesh&, double)>& factor_of,
                        const std::function<void(const SecondModel&)>& use, int pads = 1) {
  std::string reason = "element_size_mm has no influence on its bodies";
  const double size = mesh::size_factor(machine_case.machine, machine_case.size);
  for (const SecondMesh& wanted : meshes) {
    try {
      const core::MutedWarnings muted;  // they would be about a mesh that nobody asked for
      mesh::Machine machine = mesh::with_finer_pads(machine_case.machine, pads);
      machine.order = wanted.order;
      machine.sensors = sensors;
      const mesh::MeshOptions options{wanted.factor * size, cache};
      const double ratio = edge_ratio(elements_of(mesh), elements_of(build_machine_mesh(machine, options)));
      const double factor = factor_of(wanted, ratio);
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

}  // namespace

std::string with_second_model(const solver::Case& machine_case, const mesh::MachineMesh& mesh,
                              const std::vector<mesh::SensorSpec>& sensors, const std::filesystem::path& cache,
                              const std::function<void(const SecondModel&)>& use) {
  const int order = machine_case.machine.order;
  const auto factor_of = [&](const SecondMesh& wanted, double ratio) {
    return error_of_difference(order, wanted.order, ratio);
  };
  return with_one_of(second_meshes(order), machine_case, mesh, sensors, cache, factor_of, use);
}

std::string with_finer_joints(const solver::Case& machine_case, const mesh::MachineMesh& mesh,
                              const std::vector<mesh::SensorSpec>& sensors, const std::filesystem::path& cache,
                              bool on_first, const std::function<void(const SecondModel&)>& use) {
  const int order = machine_case.machine.order;
  const auto factor_of = [&](const SecondMesh& wanted, double ratio) {
    return on_first || error_of_difference(order, wanted.order, ratio) > 0.0 ? error_of_pads : 0.0;
  };
  const std::vector<SecondMesh> meshes = on_first ? std::vector<SecondMesh>{{order, 1.0}} : second_meshes(order);
  return with_one_of(meshes, machine_case, mesh, sensors, cache, factor_of, use, finer_joints);
}

std::string with_finer_model(const solver::Case& machine_case, const mesh::MachineMesh& mesh,
                             const std::vector<mesh::SensorSpec>& sensors, const std::filesystem::path& cache,
                             const std::function<void(const SecondModel&)>& use) {
  const auto factor_of = [](const SecondMesh&, double ratio) { return std::abs(ratio - 1.0) < 0.02 ? 0.0 : 1.0; };
  return with_one_of({{machine_case.machine.order, finer}}, machine_case, mesh, sensors, cache, factor_of, use);
}

}  // namespace thermotwin::reduction
