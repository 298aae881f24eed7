// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/second_mesh.h"

#include <fmt/format.h>

#include <vector>

#include "core/progress.h"
#include "mesh/machine/finer_pads.h"
#include "reduction/basis/mesh_error.h"
#include "reduction/basis/second_model.h"
#include "solver/campaign/campaign.h"

namespace thermotwin::tools {

namespace {

constexpr double notable = 0.02;  // share of the motion from which the pads of joints are spoken of

void warn_of_pads(const reduction::MeshError& of_pads) {
  Eigen::Index worst = 0;
  const double share = of_pads.tcp.head<3>().maxCoeff(&worst);
  if (share < notable) return;
  core::warn(fmt::format(
      "the pads of joints make an error of {:.1f} % of the motion in d{}: a larger divide or sectors reduces it",
      100 * share, "xyz"[worst]));
}

}  // namespace

std::optional<reduction::MeshError> mesh_error_of(const solver::FullModel& full, const solver::Case& machine_case,
                                                  const solver::LoadProgram& load, const solver::LoadResult& result,
                                                  const std::filesystem::path& out) {
  const mesh::Machine& machine = machine_case.machine;
  const auto on = [&](const reduction::SecondModel& model) { return solver::run_campaign(model.full, {load}, {}); };
  std::optional<reduction::MeshError> error;
  std::vector<solver::LoadResult> stated;  // on the mesh on which joints are divided more finely: the cheaper one
  bool on_first = machine.order == 1;
  const std::string no_mesh = reduction::with_second_model(
      machine_case, full.mesh, machine.sensors, out / "cache", [&](const reduction::SecondModel& second) {
        stated = on(second);
        on_first = on_first || second.ratio < 1.0;
        error = reduction::estimate_mesh_error(machine, {result}, stated, second.factor);
        error->second = fmt::format("{} tetrahedra of {:.2f} times the size, {} nodes",
                                    second.full.mesh.machine.order == 2 ? "quadratic" : "linear", second.ratio,
                                    second.full.mesh.nodes());
      });
  if (!error) core::warn("no second mesh, hence no estimate of the mesh error: " + no_mesh);
  if (!error || !mesh::has_divided_pads(machine)) return error;
  if (on_first) stated = {result};
  const std::string no_joints = reduction::with_finer_joints(
      machine_case, full.mesh, machine.sensors, out / "cache", on_first, [&](const reduction::SecondModel& second) {
        const reduction::MeshError of_pads = reduction::estimate_mesh_error(machine, stated, on(second), second.factor);
        error = reduction::both_errors(*error, of_pads);
        error->second += ", finer joints";
        warn_of_pads(of_pads);
      });
  if (!no_joints.empty()) core::warn("no model with joints divided more finely, whose error is left out: " + no_joints);
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
