// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/projection.h"

#include <fmt/format.h>

#include <cstddef>

#include "core/error.h"
#include "core/progress.h"
#include "core/thread_pool.h"
#include "reduction/basis/basis.h"
#include "reduction/basis/parameter_parts.h"

namespace thermotwin::reduction {

using solver::TermKind;

namespace {

constexpr double orthonormal_within = 1e-9;

/// All rows at once: the basis is what is large.
solver::OutputRows small(const solver::OutputRows& rows, const Eigen::MatrixXd& basis) {
  Eigen::MatrixXd columns(basis.rows(), rows.tool.rows() + rows.table_axis.rows() + rows.table_own.rows());
  columns << rows.tool.transpose(), rows.table_axis.transpose(), rows.table_own.transpose();
  const Eigen::MatrixXd all = columns.transpose() * basis;
  return {all.topRows(rows.tool.rows()), all.middleRows(rows.tool.rows(), rows.table_axis.rows()),
          all.bottomRows(rows.table_own.rows())};
}

}  // namespace

ReducedSystem project_system(const solver::ThermalSystem& thermal, const Eigen::MatrixXd& basis) {
  const RowMajorMatrix vectors = basis;
  ReducedSystem system;
  system.layout = thermal.layout;
  Eigen::MatrixXd capacity, conduction;
  core::parallel_for(0, 2, [&](std::size_t i) {
    (i == 0 ? capacity : conduction) = project(i == 0 ? thermal.capacity : thermal.conduction, vectors);
  });
  const Eigen::Index r = basis.cols();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(r, r);
  if (!((capacity - identity).cwiseAbs().maxCoeff() < orthonormal_within)) {
    throw core::SolverError(fmt::format("reduced basis of order {}: not orthonormal in the capacity", r));
  }
  system.capacity = identity;
  const auto symmetric = [](const Eigen::MatrixXd& m) { return Eigen::MatrixXd(0.5 * (m + m.transpose())); };
  system.conduction = symmetric(conduction);
  system.terms.resize(thermal.terms.size());
  core::parallel_for(0, thermal.terms.size(), [&](std::size_t j) {
    const Eigen::MatrixXd term = project(thermal.terms[j], vectors);
    system.terms[j] = thermal.layout.terms[j].kind == TermKind::coolant_flow ? term : symmetric(term);
  });
  system.inputs = (thermal.inputs.transpose() * basis).transpose();
  system.sensors = thermal.sensors * basis;
  system.one_kelvin = basis.transpose() * (thermal.capacity * Eigen::VectorXd::Ones(thermal.size));
  return system;
}

ReducedModel truncated(const ReducedModel& model, Eigen::Index r) {
  ReducedModel small = model;
  ReducedSystem& system = small.system;
  const auto corner = [r](Eigen::MatrixXd& m) { m = m.topLeftCorner(r, r).eval(); };
  corner(system.capacity);
  corner(system.conduction);
  for (Eigen::MatrixXd& term : system.terms) corner(term);
  system.inputs = system.inputs.topRows(r).eval();
  system.sensors = system.sensors.leftCols(r).eval();
  system.one_kelvin = system.one_kelvin.head(r).eval();
  for (auto* rows : {&small.outputs.tool, &small.outputs.table_axis, &small.outputs.table_own}) {
    for (Eigen::MatrixXd& row : *rows) row = row.leftCols(r).eval();
  }
  if (small.parts) small.parts = truncated(*model.parts, r);
  if (small.sensor_air) small.sensor_air->volumes = model.sensor_air->volumes.leftCols(r).eval();
  if (!small.patches.items.empty()) small.patches.inputs = model.patches.inputs.topRows(r);
  return small;
}

FullOutputs::FullOutputs(const solver::FullModel& full)
    : full_(full),
      grid_(full.mesh.machine),
      kept_(grid_.grid_count() + grid_.table_grid_places().size()) {
  core::Progress progress("output rows", kept_.size());
  core::parallel_for(0, kept_.size(), [&](std::size_t i) {
    const bool tool = i < grid_.grid_count();
    kept_[i] = full.elastic.output_rows(tool ? grid_.tool_poses()[i]
                                             : grid_.table_poses()[grid_.table_grid_places()[i - grid_.grid_count()]]);
    progress.advance();
  });
}

ReducedOutputs FullOutputs::project(const Eigen::MatrixXd& basis) const {
  std::vector<solver::OutputRows> tool(grid_.tool_count()), table(grid_.table_count());
  std::vector<const solver::OutputRows*> kept(tool.size() + table.size(), nullptr);
  for (std::size_t i = 0; i < grid_.grid_count(); ++i) kept[i] = &kept_[i];
  for (std::size_t i = 0; i < grid_.table_grid_places().size(); ++i)
    kept[tool.size() + grid_.table_grid_places()[i]] = &kept_[grid_.grid_count() + i];
  core::parallel_for(0, kept.size(), [&](std::size_t i) {
    const bool is_tool = i < tool.size();
    const mesh::Pose& pose = is_tool ? grid_.tool_poses()[i] : grid_.table_poses()[i - tool.size()];
    (is_tool ? tool[i] : table[i - tool.size()]) = small(kept[i] ? *kept[i] : full_.elastic.output_rows(pose), basis);
  });
  return stored_outputs(full_.mesh.machine, grid_.tool_poses(), grid_.table_poses(), tool, table);
}

}  // namespace thermotwin::reduction
