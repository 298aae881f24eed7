// SPDX-License-Identifier: GPL-3.0-or-later
// The guaranteed bound beside the true error on held-out loads.
#include <fmt/format.h>

#include "core/progress.h"
#include "core/statistics.h"
#include "core/text.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/load_result.h"
#include "tools/chain.h"

namespace thermotwin::tools {
namespace {

constexpr double small_share = 0.01;  ///< of the largest error: below, a ratio says nothing
constexpr double same_place = 1e-9;   ///< m, rad

const char* outputs[] = {"dx_um", "dy_um", "dz_um", "ra_um_per_m", "rb_um_per_m", "rc_um_per_m"};

}  // namespace

std::vector<Eigen::Index> rows_at(const std::vector<mesh::Pose>& poses, const mesh::Pose& pose, Eigen::Index rows) {
  const auto same = [&](const mesh::Pose& other) { return (other - pose).lpNorm<Eigen::Infinity>() <= same_place; };
  const auto at = std::find_if(poses.begin(), poses.end(), same);
  std::vector<Eigen::Index> list;
  if (at == poses.end()) return list;
  for (Eigen::Index row = at - poses.begin(); row < rows; row += std::ssize(poses)) list.push_back(row);
  return list;
}

std::vector<BoundedLoad> evaluate_bound(const reduction::ReducedModel& model, const reduction::BoundModel& bound,
                                        const mesh::Machine& machine, const std::vector<solver::LoadProgram>& loads,
                                        const std::vector<solver::LoadResult>& full) {
  std::vector<BoundedLoad> all;
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const std::vector<mesh::Pose> poses = reduction::poses_of(machine, full[i].tcp);
    reduction::RunRecord record;
    reduction::ReducedRun how;
    how.tell = false;
    how.record = &record;
    const solver::LoadResult reduced = reduction::simulate_reduced(model, machine, loads[i], poses, how);
    const Stopwatch watch;
    const reduction::ErrorBound stated = reduction::error_bound(model, bound, machine, record);
    const double seconds = watch.seconds();
    const auto places = std::ssize(bound.poses);
    for (Eigen::Index place = 0; place < places; ++place) {
      const mesh::Pose& pose = bound.poses[place];
      BoundedLoad of{loads[i].name(), mesh::format_pose(machine, pose), 0, 0, 0, stated.remainder_um, 0, 0, seconds};
      const std::vector<Eigen::Index> rows = rows_at(poses, pose, full[i].tcp.rows());
      const auto times = std::ssize(record.outputs);
      Eigen::MatrixXd error(std::ssize(rows), 6), limit(times, 6), truth = error;
      for (Eigen::Index k = 0; k < 6; ++k) {
        const Eigen::VectorXd of_full = full[i].tcp.column(outputs[k]), of_reduced = reduced.tcp.column(outputs[k]),
                              of_bound = stated.table.column(outputs[k]);
        for (Eigen::Index t = 0; t < times; ++t) limit(t, k) = of_bound(t * places + place);
        if (rows.empty()) continue;  // no truth at a pose off the campaign's grid
        error.col(k) = (of_full - of_reduced)(rows).cwiseAbs();
        truth.col(k) = of_full(rows);
      }
      of.bound_um = limit.leftCols(3).rowwise().norm().maxCoeff();
      if (!rows.empty()) {
        of.peak_um = truth.leftCols(3).rowwise().norm().maxCoeff();
        of.error_um = error.leftCols(3).rowwise().norm().maxCoeff();
        std::vector<double> ratios;
        for (Eigen::Index k = 0; k < 6; ++k) {
          for (Eigen::Index t = 0; t < times; ++t)
            if (error(t, k) > small_share * error.col(k).maxCoeff()) ratios.push_back(limit(t, k) / error(t, k));
        }
        if (!ratios.empty()) {
          of.least_ratio = core::quantile(ratios, 0.0);
          of.median_ratio = core::quantile(ratios, 0.5);
        }
      }
      all.push_back(of);
    }
  }
  return all;
}

void tell_what_no_bound_covers(const mesh::Machine& machine) {
  std::string list;
  const auto add = [&](const std::string& name) { list += (list.empty() ? "" : ", ") + name; };
  for (const mesh::CoolantSpec& coolant : machine.coolants) {
    if (!coolant.guide_sensor.empty() || coolant.controls_return)
      add(fmt::format("coolant '{}' (its chiller follows temperatures of the machine)", coolant.id));
  }
  for (const mesh::FilmSpec& film : machine.films)
    if (film.of_temperature) add(fmt::format("film '{}' (of_temperature)", film.id));
  for (const mesh::JointSpec& joint : machine.joints)
    if (!joint.law.by_temperature.at.empty()) add(fmt::format("joint '{}' (temperature_factor)", joint.id));
  if (list.empty()) return;
  core::warn(
      fmt::format("the bound holds for the coefficients and coolant temperatures of the reduced run. It does not "
                  "include the effect of the reduced run's error on: {}",
                  list));
}

std::string bound_table(const ReducedCase& made) {
  std::vector<std::vector<std::string>> table{
      {"held-out load", "pose", "peak um", "error um", "bound um", "of peak %", "bound/error, least", "median", "s"}};
  for (const BoundedLoad& b : made.bounded) {
    const bool known = b.peak_um > 0.0;
    table.push_back({b.load, b.pose.empty() ? "-" : b.pose, known ? fmt::format("{:.2f}", b.peak_um) : "-",
                     known ? fmt::format("{:.3f}", b.error_um) : "-", fmt::format("{:.3f}", b.bound_um),
                     known ? fmt::format("{:.2f}", 100 * b.bound_um / b.peak_um) : "-",
                     known ? fmt::format("{:.2f}", b.least_ratio) : "-",
                     known ? fmt::format("{:.2f}", b.median_ratio) : "-", fmt::format("{:.1f}", b.seconds)});
  }
  return fmt::format("{}bound: order {}, of which {} for the outputs; {} probes; built in {:.0f} s\n",
                     core::format_table(table), made.bound->terms.order(), made.bound->terms.dual(),
                     made.bound->terms.probes(), made.bound_seconds);
}

}  // namespace thermotwin::tools
