// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/switch_times.h"

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "diagnosis/inference/evidence.h"
#include "diagnosis/inference/hypothesis_fit.h"
#include "diagnosis/record/diagnose_options.h"

namespace thermotwin::diagnosis {

using Eigen::Index;

namespace {

constexpr double least_share = 0.2,
                 least_sure = 2.0;  ///< of a while, and standard deviations, by which a change is moved
constexpr double least_gain = 5.0;  ///< ln of the likelihood of no cause that it has to bring
constexpr double in_time_s = 1.0;
constexpr int most_rounds = 4;

/// The changes that are told to have come elsewhere than where they are taken to, by the time of the row that shows
/// them.
std::map<double, double> moved_changes(const Problem& problem, const LinearEvidence& none) {
  struct Told {
    double came = 0.0, earlier_s = 0.0, later_s = 0.0;
    Eigen::VectorXd weights;
  };
  const std::vector<Observations::MayHold>& whiles = problem.observations.may_hold;
  const Index first = problem.columns.cols() - std::ssize(whiles);
  std::map<double, Told> changes;
  for (std::size_t k = 0; k < whiles.size(); ++k) {
    const Observations::MayHold& held = whiles[k];
    if (held.in_pause) continue;
    const double length = held.to - held.from, sign = held.earlier ? -1.0 : 1.0;
    Told& told = changes[held.shown];
    told.came = held.earlier ? held.to : held.from;
    (held.earlier ? told.earlier_s : told.later_s) = length;
    if (told.weights.size() == 0) told.weights.setZero(none.mean().size());
    told.weights[first + k] = sign * length;
  }
  std::map<double, double> moved;
  for (const auto& [shown, told] : changes) {
    const double by = told.weights.dot(none.mean()),
                 std = std::sqrt(told.weights.dot(none.covariance() * told.weights));
    const double room = by < 0.0 ? told.earlier_s : told.later_s;
    if (room > 0.0 && std::abs(by) > least_share * room && std::abs(by) > least_sure * std)
      moved[shown] = told.came + by;
  }
  return moved;
}

/// No cause, clocks and sensors taken to be in time: a log that is late at all changes and clocks that are fast look
/// alike.
LinearEvidence none_in_time(const Problem& problem, const White& white) {
  Eigen::VectorXd prior_std = problem.prior_std;
  for (std::size_t i = 0; i < problem.parameters.size(); ++i)
    if (acts_in_time(problem.parameters[i].kind)) prior_std[i] = in_time_s;
  return {white.columns, white.residual, prior_std};
}

Seen see_one(const reduction::ReducedModel& model, const compensation::Measurement& measurement,
             const DiagnoseOptions& options) {
  const mesh::Machine& machine = model.machine;
  const solver::Channels channels(machine);
  Seen best;
  std::map<double, double> changes;
  double reached = 0.0;
  for (int round = 0; round < most_rounds; ++round) {
    Seen now;
    now.observations = std::make_unique<const Observations>(
        observe(measurement, machine, channels,
                {.interval_s = options.interval_s, .heldout_share = options.heldout_share, .changes = changes}));
    now.response = std::make_unique<const Response>(model, *now.observations);
    now.problem = make_problem(machine, measurement, *now.observations, *now.response, options);
    if (now.observations->may_hold.empty()) return now;
    const White white(now.problem);
    const LinearEvidence none = none_in_time(now.problem, white);
    // Of the data alone: what is told is not more likely for having been told before.
    const double log_likelihood =
        -0.5 * ((white.residual - white.columns * none.mean()).squaredNorm() + white.whitener.log_determinant());
    if (round > 0 && log_likelihood < reached + least_gain) break;
    reached = log_likelihood;
    best = std::move(now);
    const std::map<double, double> moved = moved_changes(best.problem, none);
    if (moved.empty()) break;
    for (const auto& [shown, came] : moved) changes[shown] = came;
  }
  return best;
}

}  // namespace

Seen see(const reduction::ReducedModel& model, Records records, const DiagnoseOptions& options) {
  if (records.size() == 1) return see_one(model, records.front(), options);
  DiagnoseOptions alike = options;
  alike.interval_s = common_interval_s(records, options.interval_s);
  std::vector<Observations> each;
  for (const compensation::Measurement& record : records) each.push_back(*see_one(model, record, alike).observations);
  Seen seen;
  seen.observations = std::make_unique<const Observations>(joined(std::move(each), record_names(records)));
  seen.response = std::make_unique<const Response>(model, *seen.observations);
  seen.problem = make_problem(model.machine, records, *seen.observations, *seen.response, options);
  return seen;
}

}  // namespace thermotwin::diagnosis
