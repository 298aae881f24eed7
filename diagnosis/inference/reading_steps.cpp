// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/reading_steps.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/thread_pool.h"
#include "core/units.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int most_together = 3;
constexpr Index fewest_means = 3;                            ///< on either side of a step
constexpr double within[] = {0.0, 0.25, 0.5, 0.75};          ///< an interval, where a step may come
constexpr double means_before = 1.0, means_after = 2.0;      ///< about a change of inputs at an unknown time
constexpr double memories_h[] = {1.0, 2.0, 4.0, 8.0, 16.0};  ///< of what creeps from the beginning on

/// Channels that have the same steps, in groups: those of a group by the same size. One channel, the displacements of
/// one quantity, or all displacements of a record with a group for each quantity.
using Scope = std::vector<std::vector<std::size_t>>;

/// Single channels, then the displacements of one quantity of a record, then all of a record; no channel of an
/// arrangement.
std::vector<Scope> scopes_of(const Problem& problem) {
  std::set<std::size_t> arranged;
  for (const PointTest& test : problem.tests) arranged.insert(test.channels.begin(), test.channels.end());
  std::vector<Scope> scopes;
  std::map<int, std::map<std::string, std::vector<std::size_t>>> of_records;
  const auto& channels = problem.observations.channels;
  for (std::size_t k = 0; k < channels.size(); ++k) {
    if (arranged.count(k) != 0 || channels[k].fitted < 4 * fewest_means) continue;
    scopes.push_back({{k}});
    if (!channels[k].is_temperature()) of_records[channels[k].record][channels[k].channel.quantity].push_back(k);
  }
  for (const auto& [record, quantities] : of_records) {
    Scope all;
    for (const auto& [quantity, alike] : quantities) {
      if (alike.size() > 1) scopes.push_back({alike});
      all.push_back(alike);
    }
    if (all.size() > 1) scopes.push_back(std::move(all));
  }
  return scopes;
}

/// What is left of the normal equations of columns that a scope's channels have in common once all other columns are
/// solved for. Every group has columns of its own, one group after the other.
struct Equations {
  Index each = 0;  ///< columns of a group
  MatrixXd gram;   ///< (groups each x groups each)
  VectorXd right;  ///< (groups each)

  Index groups() const { return right.size() / each; }
};

/// @param value  of a channel's mean in a column of its group
template <typename Value>
Equations equations_of(const Problem& problem, const BesideSteps& beside, const Scope& scope, Index each,
                       const Value& value) {
  const Index count = each * std::ssize(scope);
  Equations left{each, MatrixXd::Zero(count, count), VectorXd::Zero(count)};
  MatrixXd with_others = MatrixXd::Zero(beside.columns.cols(), count);
  for (Index g = 0; g < std::ssize(scope); ++g) {
    const std::size_t group = g;
    for (const std::size_t k : scope[group]) {
      const ObservedChannel& channel = problem.observations.channels[k];
      const Index first = problem.first_row(k), n = channel.fitted;
      const Whitener whitener({beside.covariance[k]});
      const MatrixXd white = whitener.whiten(
          MatrixXd::NullaryExpr(n, each, [&](Index mean, Index column) { return value(channel, mean, column); }));
      left.gram.block(g * each, g * each, each, each) += white.transpose() * white;
      left.right.segment(g * each, each) += white.transpose() * whitener.whiten(beside.residual.segment(first, n));
      with_others.middleCols(g * each, each) +=
          whitener.whiten(beside.columns.middleRows(first, n)).transpose() * white;
    }
  }
  left.gram -= with_others.transpose() * beside.precision.solve(with_others);
  left.right -= with_others.transpose() * beside.mean;
  return left;
}

/// Sizes (groups) of one column in each group, with independent priors: ln Bayes factor, estimate and covariance.
struct Estimate {
  double log_factor = 0;
  VectorXd size;
  MatrixXd covariance;
};

Estimate estimate(const VectorXd& prior_std, const MatrixXd& told, const VectorXd& toward) {
  const Index n = toward.size();
  const MatrixXd scaled = MatrixXd::Identity(n, n) + prior_std.asDiagonal() * told * prior_std.asDiagonal();
  const Eigen::LLT<MatrixXd> factor(scaled);
  Estimate found;
  found.covariance = prior_std.asDiagonal() * factor.solve(MatrixXd(prior_std.asDiagonal()));
  found.size = found.covariance * toward;
  found.log_factor = 0.5 * toward.dot(found.size) - factor.matrixLLT().diagonal().array().log().sum();
  return found;
}

/// A step that comes a share of an interval after the beginning of it: the column between two of the intervals' ones.
struct Place {
  Index column = 0;
  double share = 0;
};

/// Steps at every interval of a scope.
struct Steps : Equations {
  std::vector<Index> interval;  ///< (each) with which a step begins
  /// (each) whether no input changed about this time without a row that tells when: what such a change leaves that came
  /// at another time than assumed looks like one or two steps.
  std::vector<bool> allowed;

  /// Rows (groups) of values over all columns, of the steps at a place.
  template <typename Values>
  MatrixXd at(const Eigen::MatrixBase<Values>& values, const Place& place) const {
    MatrixXd rows(groups(), values.cols());
    for (Index g = 0; g < groups(); ++g) {
      const Index j = g * each + place.column;
      rows.row(g) = values.row(j);
      if (place.share > 0.0) rows.row(g) += place.share * (values.row(j + 1) - values.row(j));
    }
    return rows;
  }
  /// (groups each x groups) products of all columns with the steps at a place.
  MatrixXd times(const Place& place) const { return at(gram, place).transpose(); }
};

Steps steps_of(const Problem& problem, const BesideSteps& beside, const Scope& scope) {
  const ObservedChannel& leading = problem.observations.channels[scope.front().front()];
  Steps steps;
  steps.interval.assign(leading.interval.begin() + fewest_means,
                        leading.interval.begin() + leading.fitted - fewest_means);
  Equations& left = steps;
  left = equations_of(problem, beside, scope, std::ssize(steps.interval),
                      [&](const ObservedChannel& channel, Index mean, Index column) {
                        const std::size_t one = mean, step = column;
                        return channel.interval[one] >= steps.interval[step] ? 1.0 : 0.0;
                      });
  const double mean_s = problem.observations.interval;
  for (Index mean = fewest_means; mean < leading.fitted - fewest_means; ++mean) {
    const auto& changes = problem.observations.open_changes;
    const double time = leading.time[mean];
    steps.allowed.push_back(std::none_of(changes.begin(), changes.end(), [&](const auto& change) {
      return time > change.from - means_before * mean_s && time < change.shown + means_after * mean_s;
    }));
  }
  return steps;
}

/// A step from the beginning of the record on that comes with each of the time constants.
Equations creep_of(const Problem& problem, const BesideSteps& beside, const Scope& scope) {
  const double start = problem.observations.channels[scope.front().front()].time[0];
  return equations_of(problem, beside, scope, std::size(memories_h),
                      [&](const ObservedChannel& channel, Index mean, Index column) {
                        return -std::expm1((start - channel.time[mean]) / (memories_h[column] * core::units::hour));
                      });
}

/// Steps found one after another with one prior standard deviation.
struct Found {
  std::vector<Place> places;
  double log_evidence = 0;  ///< mean over the time of the last one
};

/// The next step beside those that are in the equations.
/// @param prior_std  (groups)  @param log_of_places  ln Bayes factor of the steps at their places, with their prior
void add_step(Steps& steps, const VectorXd& prior_std, Found& found, double& log_of_places) {
  std::vector<double> logs;
  Place best;
  double most = 0.0;
  for (Index j = 0; j < steps.each; ++j) {
    const std::size_t one = j;
    if (!steps.allowed[one]) continue;
    for (const double share : within) {
      if (share > 0.0 && j + 1 == steps.each) continue;
      const Place place{j, share};
      MatrixXd columns(steps.groups(), steps.groups());
      for (Index g = 0; g < steps.groups(); ++g) {
        const Index c = g * steps.each + j;
        VectorXd column = steps.at(steps.gram.col(c), place);
        if (share > 0.0) column += share * (steps.at(steps.gram.col(c + 1), place) - column).eval();
        columns.col(g) = column;
      }
      logs.push_back(estimate(prior_std, columns, steps.at(steps.right, place)).log_factor);
      if (logs.size() == 1 || logs.back() > most) most = logs.back(), best = place;
    }
  }
  if (logs.empty()) return;
  found.places.push_back(best);
  found.log_evidence = log_of_places + log_mean_exp(logs);
  log_of_places += most - std::log(1.0 * logs.size());
  const MatrixXd along = steps.times(best);
  const Estimate there = estimate(prior_std, steps.at(along, best), steps.at(steps.right, best));
  steps.right -= along * there.size;
  steps.gram -= along * there.covariance * along.transpose();
}

/// Sizes of steps that are there together, of the group that moves most.
/// @param group  is set to this group
std::vector<ReadingStep> sizes_of(const Problem& problem, const Steps& steps, const std::vector<Place>& places,
                                  const VectorXd& prior_std, const ObservedChannel& channel, Index& group) {
  const Index count = std::ssize(places), groups = steps.groups();
  MatrixXd told(count * groups, count * groups);
  VectorXd right(count * groups);
  for (Index a = 0; a < count; ++a) {
    const std::size_t one = a;
    const MatrixXd along = steps.times(places[one]);
    right.segment(a * groups, groups) = steps.at(steps.right, places[one]);
    for (Index b = 0; b < count; ++b) {
      const std::size_t other = b;
      told.block(b * groups, a * groups, groups, groups) = steps.at(along, places[other]);
    }
  }
  const double offset_s = problem.observations.each()[channel.record].offset.time;
  const Estimate all = estimate(prior_std.replicate(count, 1), told, right);
  const MatrixXd sizes = all.size.reshaped(groups, count);
  sizes.cwiseAbs().rowwise().sum().maxCoeff(&group);
  const auto mean_at = [&](Index column) {  // index of the first mean with a step there
    const std::size_t step = column;
    return std::lower_bound(channel.interval.begin(), channel.interval.end(), steps.interval[step]) -
           channel.interval.begin();
  };
  std::vector<ReadingStep> found;
  for (Index a = 0; a < count; ++a) {
    const std::size_t one = a;
    const Index first = mean_at(places[one].column), next = std::min<Index>(first + 1, channel.size() - 1);
    // Between the samples of the mean before and those of the first one with the step, or within these.
    const double between = 0.5 * (channel.time[first - 1] + channel.time[first]),
                 after = places[one].share * (channel.time[next] - channel.time[first]);
    const Index at = a * groups + group;
    found.push_back({between + after - offset_s, all.size[at], std::sqrt(all.covariance(at, at))});
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.from_s < b.from_s; });
  return found;
}

/// A creep, and the evidence of its time constants together.
struct Crept {
  ReadingStep step;
  Index group = 0;  ///< that moves most
  double most = 0;  ///< ln Bayes factor with the best time constant

  /// @return ln Bayes factor, mean over the time constants  @param start_s  in the time of the record
  double add(const Equations& creep, const VectorXd& prior_std, double start_s) {
    std::vector<double> logs;
    const Index groups = creep.groups();
    for (Index i = 0; i < creep.each; ++i) {
      MatrixXd told(groups, groups);
      VectorXd toward(groups);
      for (Index g = 0; g < groups; ++g) {
        toward[g] = creep.right[g * creep.each + i];
        for (Index h = 0; h < groups; ++h) told(g, h) = creep.gram(g * creep.each + i, h * creep.each + i);
      }
      const Estimate found = estimate(prior_std, told, toward);
      logs.push_back(found.log_factor);
      if (step.memory_s > 0.0 && logs.back() <= most) continue;
      most = logs.back();
      found.size.cwiseAbs().maxCoeff(&group);
      step = {start_s, found.size[group], std::sqrt(found.covariance(group, group)), memories_h[i] * core::units::hour};
    }
    return log_mean_exp(logs);
  }
};

/// @param seen  (groups)
ReadingSteps best_steps(const Problem& problem, const BesideSteps& beside, const Scope& scope, const VectorXd& seen,
                        const std::vector<double>& levels) {
  ReadingSteps result;
  if (!(seen.minCoeff() > 0.0)) return result;
  const Steps steps = steps_of(problem, beside, scope);
  const Equations creep = creep_of(problem, beside, scope);
  std::vector<double> logs;
  Found best;
  VectorXd best_std;
  Crept crept;
  const ObservedChannel& leading = problem.observations.channels[scope.front().front()];
  const double start = leading.time[0] - problem.observations.each()[leading.record].offset.time;
  for (const double level : levels) {
    const VectorXd std = level * seen;
    Steps left = steps;
    Found found;
    double log_of_places = 0.0;
    for (int count = 0; count < most_together; ++count) {
      add_step(left, std, found, log_of_places);
      logs.push_back(found.log_evidence);
      if (best.places.empty() || found.log_evidence > best.log_evidence) best = found, best_std = std;
    }
    logs.push_back(crept.add(creep, std, start));
  }
  result.log_evidence = log_mean_exp(logs);
  Index group = crept.group;
  result.steps = {crept.step};
  if (!best.places.empty() && best.log_evidence >= crept.most - std::log(1.0 * std::size(memories_h)))
    result.steps = sizes_of(problem, steps, best.places, best_std, leading, group);
  for (const auto& alike : scope) result.channels.insert(result.channels.end(), alike.begin(), alike.end());
  const std::size_t most = group;
  if (scope.size() > 1) result.quantity = problem.observations.channels[scope[most].front()].channel.quantity;
  return result;
}

}  // namespace

std::vector<ReadingSteps> find_reading_steps(const Problem& problem, const BesideSteps& beside, const VectorXd& seen,
                                             const std::vector<double>& levels) {
  const std::vector<Scope> scopes = scopes_of(problem);
  std::vector<ReadingSteps> found(scopes.size());
  core::parallel_for(0, scopes.size(), [&](std::size_t i) {
    VectorXd mean = VectorXd::Zero(std::ssize(scopes[i]));
    for (std::size_t g = 0; g < scopes[i].size(); ++g) {
      const std::vector<std::size_t>& alike = scopes[i][g];
      for (const std::size_t k : alike) mean[g] += seen[k] / alike.size();
    }
    found[i] = best_steps(problem, beside, scopes[i], mean, levels);
  });
  std::erase_if(found, [](const ReadingSteps& one) { return one.steps.empty(); });  // channels that do not move
  return found;
}

}  // namespace thermotwin::diagnosis
