// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/off_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <random>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/statistics.h"
#include "core/thread_pool.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Translations at one pose of states given as columns, (3 x states) in um.
Eigen::Matrix3Xd translations(const mesh::Machine& machine, const mesh::Pose& pose, const MatrixXd& tool,
                              const MatrixXd& axis, const MatrixXd& own) {
  Eigen::Matrix3Xd all(3, tool.cols());
  for (Index k = 0; k < tool.cols(); ++k) {
    all.col(k) =
        solver::tcp_error(machine, pose, tool.col(k), axis.col(k), own.col(k)).error.head<3>() / core::units::um;
  }
  return all;
}

}  // namespace

std::vector<mesh::Pose> random_poses(const mesh::Machine& machine, int count, std::uint64_t seed) {
  std::vector<std::pair<double, double>> range;
  for (const mesh::Axis& axis : machine.axes)
    range.emplace_back(axis.endless ? std::pair{0.0, 2.0 * std::numbers::pi} : std::pair{axis.low, axis.high});
  const mesh::Workspace& workspace = machine.workspace;
  for (const auto& [axes, positions] :
       {std::pair{&workspace.axes, &workspace.positions}, {&workspace.table_axes, &workspace.table_positions}}) {
    for (std::size_t i = 0; i < axes->size(); ++i) {
      const std::size_t at = machine.axis_index((*axes)[i]);
      if (machine.axes[at].endless) continue;
      const auto [low, high] = std::minmax_element((*positions)[i].begin(), (*positions)[i].end());
      range[at] = {*low, *high};
    }
  }
  std::mt19937_64 engine(seed);
  std::vector<mesh::Pose> poses(count, mesh::home_pose(machine));
  for (mesh::Pose& pose : poses) {
    for (std::size_t i = 0; i < range.size(); ++i) {
      const double share = core::uniform(engine);
      pose(i) = range[i].first + share * (range[i].second - range[i].first);
    }
  }
  return poses;
}

FullRows full_rows(const solver::FullModel& full, std::vector<mesh::Pose> poses) {
  FullRows made{std::move(poses), {}};
  made.rows.resize(made.poses.size());
  core::Progress progress("output rows off the grid", made.poses.size());
  core::parallel_for(0, made.poses.size(), [&](std::size_t i) {
    made.rows[i] = full.elastic.output_rows(made.poses[i]);
    progress.advance();
  });
  return made;
}

std::vector<Eigen::Matrix3Xd> off_grid_truth(const mesh::Machine& machine, const FullRows& full,
                                             const MatrixXd& snapshots) {
  std::vector<Eigen::Matrix3Xd> truth(full.poses.size());
  core::parallel_for(0, full.poses.size(), [&](std::size_t i) {
    const solver::OutputRows& rows = full.rows[i];
    truth[i] = translations(machine, full.poses[i], rows.tool * snapshots, rows.table_axis * snapshots,
                            rows.table_own * snapshots);
  });
  return truth;
}

OffGridErrors off_grid_errors(const ReducedModel& model, const MatrixXd& basis, const mesh::Machine& machine,
                              const solver::LoadProgram& load, const std::vector<Eigen::Matrix3Xd>& truth,
                              const FullRows& full) {
  RunRecord record;
  const solver::LoadResult run = simulate_reduced(model, machine, load, full.poses, {.tell = false, .record = &record});
  const auto times = std::ssize(record.outputs), count = std::ssize(full.poses);
  if (truth.size() != full.poses.size() || truth.empty() || truth.front().cols() != times ||
      basis.cols() != model.system.order()) {
    throw core::InputError(
        "off the grid, load '" + load.name() + "'",
        fmt::format("{} poses, a basis of {} columns", truth.size(), basis.cols()),
        fmt::format("{} poses of {} times, {} columns", full.poses.size(), times, model.system.order()));
  }
  MatrixXd states(model.system.order(), times);
  for (Index t = 0; t < times; ++t) states.col(t) = record.outputs[t].state;
  MatrixXd interpolated(run.tcp.rows(), 3);
  for (const auto& [name, k] : {std::pair{"dx_um", 0}, {"dy_um", 1}, {"dz_um", 2}})
    interpolated.col(k) = run.tcp.column(name);
  OffGridErrors errors{load.name(), VectorXd(count), VectorXd(count), VectorXd(count), VectorXd(count)};
  core::parallel_for(0, full.poses.size(), [&](std::size_t i) {
    const Index at = i;
    const solver::OutputRows& rows = full.rows[i];
    const Eigen::Matrix3Xd own = translations(machine, full.poses[i], (rows.tool * basis) * states,
                                              (rows.table_axis * basis) * states, (rows.table_own * basis) * states);
    VectorXd off(times);
    for (Index t = 0; t < times; ++t) off(t) = (interpolated.row(t * count + at).transpose() - truth[i].col(t)).norm();
    errors.peak(at) = truth[i].colwise().norm().maxCoeff();
    errors.max(at) = off.maxCoeff();
    errors.rms(at) = std::sqrt(off.squaredNorm() / times);
    errors.own_rows(at) = (own - truth[i]).colwise().norm().maxCoeff();
  });
  return errors;
}

void write_off_grid(const std::filesystem::path& path, const mesh::Machine& machine,
                    const std::vector<mesh::Pose>& poses, const std::vector<OffGridErrors>& errors) {
  std::string text = "load";
  for (const std::string& axis : mesh::pose_columns(machine)) text += "," + axis;
  text += ",peak_um,max_um,rms_um,own_rows_max_um\n";
  for (const OffGridErrors& load : errors) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Index k = i;
      text += load.load;
      for (const double value : mesh::pose_values(machine, poses[i])) text += fmt::format(",{:.6g}", value);
      text += fmt::format(",{:.6g},{:.6g},{:.6g},{:.6g}\n", load.peak(k), load.max(k), load.rms(k), load.own_rows(k));
    }
  }
  core::write_file(path, text);
}

}  // namespace thermotwin::reduction
