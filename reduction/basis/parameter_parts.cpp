// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/parameter_parts.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/thread_pool.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/basis.h"
#include "reduction/model/output_grid.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::reduction {
namespace {

constexpr double steepest = 1.5;  ///< exponent: no joint follows more than its own compliance

/// (6 x r)
Eigen::MatrixXd table_remainder(const mesh::Machine& machine, const mesh::Pose& pose, Eigen::MatrixXd axis,
                                Eigen::MatrixXd own, const ReducedOutputs& outputs) {
  const Eigen::VectorXd weights = table_weights(machine, pose);
  for (Eigen::Index k = 0; k < weights.size(); ++k) {
    if (weights(k) == 0.0) continue;
    axis -= weights(k) * outputs.table_axis[k];
    own -= weights(k) * outputs.table_own[k];
  }
  Eigen::MatrixXd rest(6, axis.cols());
  for (Eigen::Index j = 0; j < axis.cols(); ++j)
    rest.col(j) = solver::tcp_error(machine, pose, solver::Vector6::Zero(), axis.col(j), own.col(j)).table;
  return rest;
}

/// V_b^T E_bb V_b of bodies and volumes; a body's block of the capacity is its own, a volume is one of the last states.
std::vector<Eigen::MatrixXd> capacities(const solver::FullModel& full, const Eigen::MatrixXd& basis) {
  const mesh::MachineMesh& mesh = full.mesh;
  std::vector<Eigen::MatrixXd> all(mesh.bodies.size());
  core::parallel_for(0, all.size(), [&](std::size_t b) {
    const Eigen::Index first = mesh.first_node[b], nodes = mesh.first_node[b + 1] - first;
    const solver::SparseMatrix block = full.thermal.capacity.block(first, first, nodes, nodes);
    const Eigen::MatrixXd own = project(block, RowMajorMatrix(basis.middleRows(first, nodes)));
    all[b] = 0.5 * (own + own.transpose());
  });
  const std::vector<mesh::VolumeSpec>& volumes = mesh.machine.volumes;
  for (Eigen::Index v = 0; v < std::ssize(volumes); ++v) {
    const Eigen::RowVectorXd row = basis.row(basis.rows() - std::ssize(volumes) + v);
    all.push_back(volumes[v].capacity.value * row.transpose() * row);
  }
  return all;
}

}  // namespace

ReducedOutputs stored_outputs(const mesh::Machine& machine, const std::vector<mesh::Pose>& tool_poses,
                              const std::vector<mesh::Pose>& table_poses,
                              const std::vector<solver::OutputRows>& at_tool,
                              const std::vector<solver::OutputRows>& at_table) {
  ReducedOutputs outputs{tool_poses, {}, table_poses, {}, {}};
  for (const solver::OutputRows& rows : at_table) {
    outputs.table_axis.push_back(rows.table_axis);
    outputs.table_own.push_back(rows.table_own);
  }
  for (std::size_t i = 0; i < at_tool.size(); ++i) {
    outputs.tool.push_back(at_tool[i].tool - table_remainder(machine, tool_poses[i], at_tool[i].table_axis,
                                                             at_tool[i].table_own, outputs));
  }
  return outputs;
}

Parts make_parts(const solver::FullModel& full, const Eigen::MatrixXd& basis) {
  const mesh::Machine& machine = full.mesh.machine;
  Parts parts;
  parts.capacity = capacities(full, basis);
  const std::vector<Eigen::MatrixXd> images = full.elastic.unit_images(basis);
  const OutputGrid grid(machine);
  const std::vector<mesh::Pose>&tool_poses = grid.tool_poses(), &table_poses = grid.table_poses();
  std::vector<solver::OutputParts> at_tool(tool_poses.size()), at_table(table_poses.size());
  core::parallel_for(0, at_tool.size() + at_table.size(), [&](std::size_t i) {
    const bool tool = i < at_tool.size();
    const std::size_t k = tool ? i : i - at_tool.size();
    (tool ? at_tool : at_table)[k] = full.elastic.output_parts((tool ? tool_poses : table_poses)[k], basis, images);
  });
  const auto stored = [&](const std::vector<solver::OutputRows> solver::OutputParts::*list, std::size_t item) {
    const auto rows_of = [&](const std::vector<solver::OutputParts>& all) {
      std::vector<solver::OutputRows> rows;
      for (const solver::OutputParts& at : all) rows.push_back((at.*list)[item]);
      // A joint that loses contact somewhere takes no share there.
      for (solver::OutputRows& row : rows) {
        if (row.tool.size() == 0) {
          row = {Eigen::MatrixXd::Zero(6, basis.cols()), Eigen::MatrixXd::Zero(6, basis.cols()),
                 Eigen::MatrixXd::Zero(7, basis.cols())};
        }
      }
      return rows;
    };
    bool any = false;
    for (const auto* all : {&at_tool, &at_table})
      for (const solver::OutputParts& at : *all) any = any || (at.*list)[item].tool.size() > 0;
    if (!any) return ReducedOutputs{};
    ReducedOutputs outputs = stored_outputs(machine, tool_poses, table_poses, rows_of(at_tool), rows_of(at_table));
    outputs.tool_poses.clear();
    outputs.table_poses.clear();
    return outputs;
  };
  for (std::size_t b = 0; b < machine.bodies.size(); ++b)
    parts.bodies.push_back(stored(&solver::OutputParts::bodies, b));
  for (std::size_t i = 0; i < machine.scales.size(); ++i)
    parts.scales.push_back(stored(&solver::OutputParts::scales, i));
  for (std::size_t i = 0; i < machine.screws.size(); ++i)
    parts.screws.push_back(stored(&solver::OutputParts::screws, i));
  parts.stiffness_exponent.setZero(std::ssize(machine.joints));
  for (std::size_t j = 0; j < machine.joints.size(); ++j) {
    parts.stiffness.push_back(stored(&solver::OutputParts::stiffness, j));
    const ReducedOutputs &first = parts.stiffness.back(), second = stored(&solver::OutputParts::curvature, j);
    double product = 0.0, square = 0.0;
    for (const auto rows : {&ReducedOutputs::tool, &ReducedOutputs::table_axis, &ReducedOutputs::table_own}) {
      for (std::size_t i = 0; i < (first.*rows).size(); ++i) {
        product += ((first.*rows)[i].array() * (second.*rows)[i].array()).sum();
        square += (first.*rows)[i].squaredNorm();
      }
    }
    if (square > 0.0) parts.stiffness_exponent[j] = std::clamp(product / square, -steepest, steepest);
  }
  return parts;
}

double Parts::stiffness_amount(Eigen::Index joint, double ln_ratio) const {
  const double n = stiffness_exponent[joint];
  return std::abs(n) < 1e-9 ? ln_ratio : std::expm1(n * ln_ratio) / n;
}

Parts truncated(const Parts& parts, Eigen::Index r) {
  Parts small = parts;
  for (Eigen::MatrixXd& capacity : small.capacity) capacity = capacity.topLeftCorner(r, r).eval();
  for (auto* list : {&small.bodies, &small.scales, &small.screws, &small.stiffness}) {
    for (ReducedOutputs& outputs : *list) {
      for (auto* rows : {&outputs.tool, &outputs.table_axis, &outputs.table_own})
        for (Eigen::MatrixXd& row : *rows) row = row.leftCols(r).eval();
    }
  }
  return small;
}

}  // namespace thermotwin::reduction
