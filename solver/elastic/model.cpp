// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/model.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include <iterator>
#include <optional>

#include "core/error.h"
#include "core/progress.h"
#include "core/range.h"
#include "core/thread_pool.h"
#include "mesh/machine/kinematics.h"
#include "solver/elastic/elastic_bodies.h"
#include "solver/elastic/outputs.h"
#include "solver/elastic/rigid_followers.h"
#include "solver/elastic/springs.h"
#include "solver/elastic/system.h"

namespace thermotwin::solver {

struct ElasticModel::Impl : ElasticBodies {
  Eigen::Index size = 0;  ///< unknowns of the thermal system
  std::optional<SpringSet> springs;
  std::optional<TcpOutputs> outputs;  ///< none: a machine without [tcp]
  std::vector<CarriedBody> carried;   ///< bodies that are not elastic

  explicit Impl(const mesh::MachineMesh& mesh) : ElasticBodies(mesh) {}

  SmallSystem::Solution solve(const SmallSystem& system, const Eigen::VectorXd& temperature) const;
  OutputRows in_frames(const Eigen::MatrixXd& rows, const mesh::Pose& pose) const;
  void require_tcp() const {
    if (!outputs)
      throw core::InputError(machine.path.string() + " [tcp]", "missing", "a [tcp], whose error is asked for");
  }
  SmallSystem small_system(const mesh::Pose& pose) const {
    return SmallSystem(machine, elastic, responses, springs->at(machine, pose));
  }
};

namespace {

/// The rigid motions of a body are six: another piece would be free in its own.
void require_whole(const mesh::Machine& machine, const std::vector<int>& elastic) {
  for (const int body : elastic) {
    const mesh::BodySpec& spec = machine.bodies[body];
    if (spec.pieces == 1) continue;
    throw core::MeshError(fmt::format("{} body '{}'", machine.path.filename().string(), spec.id),
                          fmt::format("elastic, of {} unconnected pieces", spec.pieces),
                          "elastic = false, or a body for each piece");
  }
}

}  // namespace

void ElasticOptions::validate() const { core::require_within("elastic options: tolerance", tolerance, {1e-16, 1.0}); }

ElasticModel::ElasticModel(const mesh::MachineMesh& mesh, const ThermalSystem& thermal, const ElasticOptions& options)
    : impl_(std::make_unique<Impl>(mesh)) {
  options.validate();
  Impl& impl = *impl_;
  impl.size = thermal.size;
  impl.springs.emplace(mesh, thermal.layout.grids, impl.units);
  if (mesh.machine.has_tcp()) impl.outputs.emplace(mesh, impl.units);
  impl.carried = carried_bodies(mesh);
  require_whole(mesh.machine, impl.elastic);
  require_held(mesh.machine, impl.elastic, impl.springs->at(mesh.machine, mesh::home_pose(mesh.machine)));
  impl.factorise(mesh, options);
  impl.solve_units();
  if (impl.elastic.empty()) return;
  const SmallSystem home = impl.small_system(mesh::home_pose(mesh.machine));
  impl.summary.springs = home.springs().size();
  if (const std::string text = home.hardly_held(mesh.machine); !text.empty()) core::warn(text);
}

ElasticModel::~ElasticModel() = default;
ElasticModel::ElasticModel(ElasticModel&&) noexcept = default;

const ElasticModel::Summary& ElasticModel::summary() const { return impl_->summary; }

OutputRows ElasticModel::output_rows(const mesh::Pose& pose) const {
  const Impl& impl = *impl_;
  impl.require_tcp();
  const mesh::Pose at_zero = impl.outputs->table_at_zero(pose);
  const SmallSystem system = impl.small_system(at_zero);
  const auto outputs = impl.outputs->combinations();
  const std::vector<Combination> wanted(outputs.begin(), outputs.end());
  const Eigen::MatrixXd forces = system.adjoint_forces(wanted);  // (springs x 19)
  const auto count = std::ssize(wanted);

  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(impl.size, count);  // transposed
  for (int body : impl.elastic) {
    const std::size_t b = body;
    const Eigen::MatrixXd weights = system.unit_weights(body, wanted, forces);  // (units x 19)
    // Most units belong to other places of the axes: only those in use are multiplied.
    std::vector<Eigen::Index> used;
    for (Eigen::Index u = 0; u < weights.rows(); ++u)
      if ((weights.row(u).array() != 0.0).any()) used.push_back(u);
    rows.middleRows(impl.first_node[b], impl.nodes(body)).noalias() =
        impl.thermal[b](Eigen::all, used) * weights(used, Eigen::all);
  }
  for (std::size_t s = 0; s < system.springs().size(); ++s) {
    const Spring& spring = system.springs()[s];
    for (const auto& [node, per_kelvin] : spring.expansion)
      rows.row(impl.first_node[spring.expansion_body] + node) -= per_kelvin * forces.row(s);
  }

  return impl.in_frames(rows.transpose(), at_zero);
}

std::vector<Eigen::MatrixXd> ElasticModel::unit_images(const Eigen::MatrixXd& basis) const {
  const Impl& impl = *impl_;
  std::vector<Eigen::MatrixXd> images(impl.bodies.size());
  core::parallel_for(0, impl.elastic.size(), [&](std::size_t i) {
    const std::size_t b = impl.elastic[i];
    images[b].noalias() =
        impl.thermal[b].transpose() * basis.middleRows(impl.first_node[b], impl.nodes(impl.elastic[i]));
  });
  return images;
}

OutputParts ElasticModel::output_parts(const mesh::Pose& pose, const Eigen::MatrixXd& basis,
                                       const std::vector<Eigen::MatrixXd>& images) const {
  const Impl& impl = *impl_;
  impl.require_tcp();
  const mesh::Pose at_zero = impl.outputs->table_at_zero(pose);
  const SmallSystem system = impl.small_system(at_zero);
  const auto outputs = impl.outputs->combinations();
  const std::vector<Combination> wanted(outputs.begin(), outputs.end());
  const auto count = std::ssize(wanted);
  const auto joints = std::ssize(impl.machine.joints);
  const Eigen::MatrixXd forces = system.adjoint_forces(wanted);
  std::vector<char> springs_of(impl.machine.joints.size(), 0);
  for (const Spring& spring : system.springs())
    if (spring.joint >= 0) springs_of[spring.joint] = 1;
  Eigen::MatrixXd changes =
      Eigen::MatrixXd::Zero(forces.rows(), 2 * count * joints);  // joint after joint, both derivatives
  for (Eigen::Index j = 0; j < joints; ++j) {
    if (!springs_of[j]) continue;
    const auto [first, second] = system.stiffness_change(j, forces);
    changes.middleCols(2 * count * j, count) = first;
    changes.middleCols(2 * count * j + count, count) = second;
  }

  OutputParts parts;
  parts.bodies.resize(impl.machine.bodies.size());
  Eigen::MatrixXd by_stiffness = Eigen::MatrixXd::Zero(changes.cols(), basis.cols());
  for (int body : impl.elastic) {
    const std::size_t b = body;
    const Eigen::MatrixXd own = system.unit_weights(body, wanted, forces),
                          changed = system.unit_weights(body, {}, changes);
    std::vector<Eigen::Index> used;
    for (Eigen::Index u = 0; u < own.rows(); ++u)
      if ((own.row(u).array() != 0.0).any() || (changed.row(u).array() != 0.0).any()) used.push_back(u);
    const Eigen::MatrixXd image = images[b](used, Eigen::all);
    parts.bodies[b] = impl.in_frames(own(used, Eigen::all).transpose() * image, at_zero);
    by_stiffness.noalias() += changed(used, Eigen::all).transpose() * image;
  }
  std::vector<Eigen::MatrixXd> scales(impl.machine.scales.size()), screws(impl.machine.screws.size());
  for (std::size_t s = 0; s < system.springs().size(); ++s) {
    const Spring& spring = system.springs()[s];
    if (spring.expansion.empty()) continue;
    const Eigen::Index at = s;
    Eigen::RowVectorXd growth = Eigen::RowVectorXd::Zero(basis.cols());
    for (const auto& [node, per_kelvin] : spring.expansion)
      growth += per_kelvin * basis.row(impl.first_node[spring.expansion_body] + node);
    Eigen::MatrixXd& rows = spring.expands_scale >= 0 ? scales[spring.expands_scale] : screws[spring.expands_screw];
    if (rows.size() == 0) rows.setZero(count, basis.cols());
    rows.noalias() -= forces.row(at).transpose() * growth;
    by_stiffness.noalias() -= changes.row(at).transpose() * growth;
  }
  const auto framed = [&](const Eigen::MatrixXd& rows) {
    return rows.size() > 0 ? impl.in_frames(rows, at_zero) : OutputRows{};
  };
  for (const Eigen::MatrixXd& rows : scales) parts.scales.push_back(framed(rows));
  for (const Eigen::MatrixXd& rows : screws) parts.screws.push_back(framed(rows));
  for (Eigen::Index j = 0; j < joints; ++j) {
    const bool any = springs_of[j] != 0;
    parts.stiffness.push_back(any ? impl.in_frames(by_stiffness.middleRows(2 * count * j, count), at_zero)
                                  : OutputRows{});
    parts.curvature.push_back(any ? impl.in_frames(by_stiffness.middleRows(2 * count * j + count, count), at_zero)
                                  : OutputRows{});
  }
  return parts;
}

/// The 19 rows as OutputRows has them: the tool's turned into the machine frame.
OutputRows ElasticModel::Impl::in_frames(const Eigen::MatrixXd& rows, const mesh::Pose& pose) const {
  OutputRows result;
  const int tool = machine.body_index(machine.tcp.tool_body);
  const Eigen::Matrix3d turn = mesh::body_transform(machine, tool, pose).linear();
  result.tool.resize(6, rows.cols());
  result.tool.topRows<3>() = turn * rows.topRows<3>();
  result.tool.bottomRows<3>() = turn * rows.middleRows<3>(3);
  result.table_axis = rows.middleRows<6>(6);
  result.table_own = rows.middleRows<7>(12);
  return result;
}

SmallSystem::Solution ElasticModel::Impl::solve(const SmallSystem& system, const Eigen::VectorXd& temperature) const {
  std::vector<Eigen::VectorXd> unit_motions(bodies.size());  // w^T K^+ F T
  for (int body : elastic) {
    const std::size_t b = body;
    unit_motions[b] = thermal[b].transpose() * temperature.segment(first_node[b], nodes(body));
  }
  return system.solve(unit_motions, [&](int body, Eigen::Index node) { return temperature[first_node[body] + node]; });
}

std::vector<ElasticModel::ScrewTension> ElasticModel::screw_tensions(const Eigen::VectorXd& temperature,
                                                                     const mesh::Pose& pose) const {
  const Impl& impl = *impl_;
  std::vector<ScrewTension> tensions;
  if (impl.machine.screws.empty()) return tensions;
  const SmallSystem system = impl.small_system(pose);
  const SmallSystem::Solution solution = impl.solve(system, temperature);
  for (std::size_t s = 0; s < system.springs().size(); ++s) {
    if (const int screw = system.springs()[s].screw; screw >= 0)
      tensions.push_back({screw, impl.machine.screws[screw].pretension + solution.forces[s]});
  }
  return tensions;
}

Eigen::Matrix3Xd ElasticModel::displacement(const Eigen::VectorXd& temperature, const mesh::Pose& pose) const {
  const Impl& impl = *impl_;
  if (impl.elastic.empty()) return {};
  const SmallSystem system = impl.small_system(pose);
  const SmallSystem::Solution solution = impl.solve(system, temperature);

  Eigen::Matrix3Xd displacement = Eigen::Matrix3Xd::Zero(3, impl.first_node.back());
  core::parallel_for(0, impl.elastic.size(), [&](std::size_t i) {
    const int body = impl.elastic[i];
    const std::size_t b = body;
    Eigen::MatrixXd load = impl.bodies[b].thermal_load * temperature.segment(impl.first_node[b], impl.nodes(body));
    const Eigen::MatrixXd weights = system.unit_weights(body, {}, solution.forces);
    for (Eigen::Index u = 0; u < weights.rows(); ++u) {
      if (weights(u, 0) == 0.0) continue;
      for (const auto& [dof, weight] : impl.units.of(body)[u]) load(dof, 0) -= weights(u, 0) * weight;
    }
    const Eigen::VectorXd motion =
        impl.apply_inverse(body, std::move(load)).col(0) + impl.bodies[b].rigid * solution.rigid.segment<6>(6 * i);
    displacement.middleCols(impl.first_node[b], impl.nodes(body)) =
        Eigen::Map<const Eigen::Matrix3Xd>(motion.data(), 3, impl.nodes(body));
  });
  for (const CarriedBody& body : impl.carried) move_with_parent(body, impl.machine, pose, displacement);
  return displacement;
}

ElasticModel::Outputs ElasticModel::outputs_of(const Eigen::Matrix3Xd& displacement, const mesh::Pose& pose) const {
  const Impl& impl = *impl_;
  impl.require_tcp();
  const auto combinations = impl.outputs->combinations();
  Eigen::Matrix<double, 19, 1> value;
  for (std::size_t i = 0; i < combinations.size(); ++i) {
    double sum = 0.0;
    for (const UnitTerm& term : combinations[i]) {
      const Eigen::Index first = impl.first_node[term.body];
      const Eigen::Map<const Eigen::VectorXd> of_body(displacement.data() + 3 * first, 3 * impl.nodes(term.body));
      sum += term.weight * evaluate(impl.units.of(term.body)[term.unit], of_body);
    }
    value[i] = sum;
  }
  Outputs outputs;
  const int tool = impl.machine.body_index(impl.machine.tcp.tool_body);
  const Eigen::Matrix3d turn = mesh::body_transform(impl.machine, tool, pose).linear();
  outputs.tool.head<3>() = turn * value.head<3>();
  outputs.tool.tail<3>() = turn * value.segment<3>(3);
  outputs.table_axis = value.segment<6>(6);
  outputs.table_own = value.segment<7>(12);
  return outputs;
}

}  // namespace thermotwin::solver
