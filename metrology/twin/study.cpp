// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/twin/study.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "metrology/plan/sphere.h"
#include "metrology/rtest/error_choice.h"
#include "metrology/twin/signals.h"

namespace thermotwin::metrology {

using core::units::um;
using Eigen::Index;

namespace {

/// Sums of squares of lengths and angles.
struct Squares {
  double sum[2] = {0, 0};
  long count[2] = {0, 0};
  void add(bool turns, double value) {
    if (std::isnan(value)) return;
    sum[turns] += value * value;
    ++count[turns];
  }
  Figures rms() const {
    Figures figures;
    if (count[0] > 0) figures.um = std::sqrt(sum[0] / count[0]);
    if (count[1] > 0) figures.um_per_m = std::sqrt(sum[1] / count[1]);
    return figures;
  }
};

RTestAnalysis analysed(RTestRecord record, bool drift) {
  record.drift = drift;
  return analyse(record);
}

Figures difference_to(const RTestAnalysis& left, const RTestAnalysis& right) {
  Squares squares;
  for (std::size_t c = 1; c < left.cycles.size(); ++c) {
    for (std::size_t e = 0; e < left.errors.size(); ++e) {
      squares.add(left.turns(e), (left.cycles[c].value[e] - right.cycles[c].value[e]) / um);
    }
  }
  return squares.rms();
}

/// Largest over the cycles, in um or um/m. NaN: the run has no functional of it, or it is not observable.
double largest_difference(const RTestAnalysis& analysis, const VirtualRun& run, const std::string& error) {
  const auto of = std::find(run.quantities.begin(), run.quantities.end(), error);
  const auto e = std::find(analysis.errors.begin(), analysis.errors.end(), error) - analysis.errors.begin();
  if (of == run.quantities.end()) return std::numeric_limits<double>::quiet_NaN();
  const Index q = of - run.quantities.begin();
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (Index c = 1; c < std::ssize(analysis.cycles); ++c) {
    const double functional = run.functionals(c, q) - run.functionals(0, q);
    largest = std::fmax(largest, std::abs(analysis.cycles[c].value[e] / um - functional));
  }
  return largest;
}

/// Root of the sum of squares of all residuals over their degrees of freedom, um.
double pooled_residual(const RTestAnalysis& analysis) {
  double squares = 0.0;
  Index degrees = 0;
  for (const CycleResult& cycle : analysis.cycles) {
    squares += cycle.residual.squaredNorm();
    degrees += cycle.degrees_of_freedom;
  }
  return degrees > 0 ? std::sqrt(squares / degrees) / um : std::numeric_limits<double>::quiet_NaN();
}

void raise(double& largest, double value) { largest = std::fmax(largest, value); }  // NaN counts as none

}  // namespace

RTestRecord record_of(const mesh::Machine& machine, const std::vector<PlannedPoint>& points,
                      const std::vector<solver::Vector6>& deviations, double std) {
  RTestRecord record;
  record.source = "virtual R-Test";
  record.chain = chain_of(machine);
  if (machine.tcp.table_radius > 0) record.table_radius = machine.tcp.table_radius;
  record.std = std;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const PlannedPoint& point = points[i];
    if (i == 0 || point.cycle != points[i - 1].cycle)
      record.cycles.push_back({"cycle " + std::to_string(point.cycle), {}});
    record.cycles.back().points.push_back(
        {point.time, positions_of(machine, point.pose), point.sphere, deviations[i].head<3>()});
  }
  record.errors = default_errors(record).chosen;
  return record;
}

RTestStudy study(const mesh::Machine& machine, const std::vector<PlannedPoint>& points, const VirtualRun& run,
                 const ProbeSetup& setup, double std, int draws, std::uint64_t seed) {
  const RTestRecord drifting = record_of(machine, points, run.error, std);
  const RTestAnalysis frozen = analysed(record_of(machine, points, run.frozen, std), false);
  const RTestAnalysis table = analysed(record_of(machine, points, run.table, std), false);
  RTestStudy result;
  result.errors = frozen.errors;
  for (const std::string& error : frozen.errors) result.difference.push_back(largest_difference(table, run, error));
  for (std::size_t e = 0; e < frozen.errors.size(); ++e) {
    const bool turns = frozen.turns(e);
    raise(turns ? result.largest_difference.um_per_m : result.largest_difference.um, result.difference[e]);
    raise(turns ? result.largest_with_tool.um_per_m : result.largest_with_tool.um,
          largest_difference(frozen, run, frozen.errors[e]));
  }
  result.drift_adds = difference_to(analysed(drifting, false), frozen);
  const RTestAnalysis corrected = analysed(drifting, true);
  result.drift_leaves = difference_to(corrected, frozen);
  result.residual = pooled_residual(frozen);
  result.residual_of_table = pooled_residual(table);
  result.draws = draws;
  long inside = 0, all = 0;
  for (int draw = 0; draw < draws; ++draw) {
    RTestRecord record = drifting;
    take_displacements(
        record, setup,
        sphere_displacements(probe_signals(machine, points, run.error, setup, seed + draw), setup, std::ssize(points)));
    const RTestAnalysis found = analyse(record);
    for (std::size_t c = 1; c < found.cycles.size(); ++c) {
      for (Index e = 0; e < std::ssize(found.errors); ++e) {
        if (std::isnan(found.cycles[c].value[e])) continue;
        ++all;
        inside += std::abs(found.cycles[c].value[e] - corrected.cycles[c].value[e]) <= 2.0 * found.cycles[c].std[e];
      }
    }
  }
  if (all > 0) result.covered_percent = 100.0 * inside / all;
  return result;
}

}  // namespace thermotwin::metrology
