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
constexpr double memories_h[] = {1.0, 2.0, 4.0, 8.0, 16.0};  ///< of what creeps from the beginning on

using Scope = std::vector<std::size_t>;

/// Single channels, then the displacements of one quantity of a record, and no channel of an arrangement.
std::vector<Scope> scopes_of(const Problem& problem) {
  std::set<std::size_t> arranged;
  for (const PointTest& test : problem.tests) arranged.insert(test.channels.begin(), test.channels.end());
  std::vector<Scope> scopes;
  std::map<std::pair<int, std::string>, Scope> alike;
  const auto& channels = problem.observations.channels;
  for (std::size_t k = 0; k < channels.size(); ++k) {
    if (arranged.count(k) != 0 || channels[k].fitted < 4 * fewest_means) continue;
    scopes.push_back({k});
    if (channels[k].is_temperature()) continue;
    alike[{channels[k].record, channels[k].channel.quantity}].push_back(k);
  }
  for (auto& [quantity, scope] : alike)
    if (scope.size() > 1) scopes.push_back(std::move(scope));
  return scopes;
}

/// What is left of the normal equations of columns that a scope's channels have in common once all other columns are
/// solved for.
struct Equations {
  MatrixXd gram;   ///< (columns x columns)
  VectorXd right;  ///< (columns)
};

/// @param value  of a channel's mean in a column
template <typename Value>
Equations equations_of(const Problem& problem, const BesideSteps& beside, const Scope& scope, Index count,
                       const Value& value) {
  Equations left{MatrixXd::Zero(count, count), VectorXd::Zero(count)};
  MatrixXd with_others = MatrixXd::Zero(beside.columns.cols(), count);
  for (const std::size_t k : scope) {
    const ObservedChannel& channel = problem.observations.channels[k];
    const Index first = problem.first_row(k), n = channel.fitted;
    const Whitener whitener({beside.covariance[k]});
    const MatrixXd white = whitener.whiten(
        MatrixXd::NullaryExpr(n, count, [&](Index mean, Index column) { return value(channel, mean, column); }));
    const VectorXd residual = whitener.whiten(beside.residual.segment(first, n));
    left.gram += white.transpose() * white;
    left.right += white.transpose() * residual;
    with_others += whitener.whiten(beside.columns.middleRows(first, n)).transpose() * white;
  }
  left.gram -= with_others.transpose() * beside.precision.solve(with_others);
  left.right -= with_others.transpose() * beside.mean;
  return left;
}

/// ln Bayes factor of one column whose factor has a prior of this precision.
double log_factor(double precision, double told, double toward) {
  return 0.5 * toward * toward / (precision + told) - 0.5 * std::log1p(told / precision);
}

/// A step that comes a share of an interval after the beginning of it: the column between two of the intervals' ones.
struct Place {
  Index column = 0;
  double share = 0;
};

/// Steps at every interval of a scope.
struct Steps : Equations {
  std::vector<Index> interval;  ///< (columns) with which a step begins

  VectorXd times(const Place& at) const {
    if (at.share == 0.0) return gram.col(at.column);
    return (1.0 - at.share) * gram.col(at.column) + at.share * gram.col(at.column + 1);
  }
  static double at(const VectorXd& values, const Place& place) {
    const double first = values[place.column];
    return place.share == 0.0 ? first : (1.0 - place.share) * first + place.share * values[place.column + 1];
  }
  double square(const Place& place) const {
    const Index j = place.column;
    if (place.share == 0.0) return gram(j, j);
    const double before = 1.0 - place.share, after = place.share;
    return before * before * gram(j, j) + 2.0 * before * after * gram(j, j + 1) + after * after * gram(j + 1, j + 1);
  }
};

Steps steps_of(const Problem& problem, const BesideSteps& beside, const Scope& scope) {
  const ObservedChannel& leading = problem.observations.channels[scope.front()];
  Steps steps;
  steps.interval.assign(leading.interval.begin() + fewest_means,
                        leading.interval.begin() + leading.fitted - fewest_means);
  Equations& left = steps;
  left = equations_of(problem, beside, scope, std::ssize(steps.interval),
                      [&](const ObservedChannel& channel, Index mean, Index column) {
                        const std::size_t one = mean, step = column;
                        return channel.interval[one] >= steps.interval[step] ? 1.0 : 0.0;
                      });
  return steps;
}

/// A step from the beginning of the record on that comes with each of the time constants.
Equations creep_of(const Problem& problem, const BesideSteps& beside, const Scope& scope) {
  const double start = problem.observations.channels[scope.front()].time[0];
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
/// @param log_of_places  ln Bayes factor of the steps at their places, with the prior of these
void add_step(Steps& steps, double std, Found& found, double& log_of_places) {
  const double precision = 1.0 / (std * std);
  std::vector<double> logs;
  Place best;
  double most = 0.0;
  for (Index j = 0; j < steps.right.size(); ++j) {
    for (const double share : within) {
      if (share > 0.0 && j + 1 == steps.right.size()) continue;
      const Place place{j, share};
      const double told = steps.square(place), toward = Steps::at(steps.right, place);
      logs.push_back(log_factor(precision, told, toward));
      if (logs.size() == 1 || logs.back() > most) most = logs.back(), best = place;
    }
  }
  found.places.push_back(best);
  found.log_evidence = log_of_places + log_mean_exp(logs);
  log_of_places += most - std::log(1.0 * logs.size());
  const VectorXd along = steps.times(best);
  const double all = precision + Steps::at(along, best);
  steps.right -= along * (Steps::at(steps.right, best) / all);
  steps.gram -= along * along.transpose() / all;
}

/// Sizes of steps that are there together.
std::vector<ReadingStep> sizes_of(const Problem& problem, const Steps& steps, const std::vector<Place>& places,
                                  double std, const ObservedChannel& channel) {
  const Index count = std::ssize(places);
  MatrixXd precision = MatrixXd::Identity(count, count) / (std * std);
  VectorXd right(count);
  for (Index a = 0; a < count; ++a) {
    const std::size_t one = a;
    const VectorXd along = steps.times(places[one]);
    right[a] = Steps::at(steps.right, places[one]);
    for (Index b = 0; b < count; ++b) precision(a, b) += Steps::at(along, places[static_cast<std::size_t>(b)]);
  }
  const double offset_s = problem.observations.each()[channel.record].offset.time;
  const MatrixXd covariance = precision.llt().solve(MatrixXd::Identity(count, count));
  const VectorXd size = covariance * right;
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
    found.push_back({between + after - offset_s, size[a], std::sqrt(covariance(a, a))});
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.from_s < b.from_s; });
  return found;
}

ReadingSteps best_steps(const Problem& problem, const BesideSteps& beside, const Scope& scope, double seen,
                        const std::vector<double>& levels) {
  const Steps steps = steps_of(problem, beside, scope);
  const Equations creep = creep_of(problem, beside, scope);
  std::vector<double> logs;
  Found best;
  double best_std = 0.0, most_creep = 0.0;
  ReadingStep crept;
  const ObservedChannel& leading = problem.observations.channels[scope.front()];
  const double start = leading.time[0] - problem.observations.each()[leading.record].offset.time;
  for (const double level : levels) {
    const double std = level * seen;
    if (!(std > 0.0)) continue;
    Steps left = steps;
    Found found;
    double log_of_places = 0.0;
    for (int count = 0; count < most_together; ++count) {
      add_step(left, std, found, log_of_places);
      logs.push_back(found.log_evidence);
      if (logs.size() == 1 || found.log_evidence > best.log_evidence) best = found, best_std = std;
    }
    std::vector<double> of_memories;
    for (Index i = 0; i < creep.right.size(); ++i) {
      const double precision = 1.0 / (std * std), all = precision + creep.gram(i, i);
      of_memories.push_back(log_factor(precision, creep.gram(i, i), creep.right[i]));
      if (crept.memory_s > 0.0 && of_memories.back() <= most_creep) continue;
      most_creep = of_memories.back();
      crept = {start, creep.right[i] / all, 1.0 / std::sqrt(all), memories_h[i] * core::units::hour};
    }
    logs.push_back(log_mean_exp(of_memories));
  }
  ReadingSteps result;
  if (logs.empty()) return result;
  result.channels = scope;
  result.log_evidence = log_mean_exp(logs);
  result.steps = {crept};
  if (best.log_evidence >= most_creep - std::log(1.0 * std::size(memories_h)))
    result.steps = sizes_of(problem, steps, best.places, best_std, leading);
  return result;
}

}  // namespace

std::vector<ReadingSteps> find_reading_steps(const Problem& problem, const BesideSteps& beside, const VectorXd& seen,
                                             const std::vector<double>& levels) {
  const std::vector<Scope> scopes = scopes_of(problem);
  std::vector<ReadingSteps> found(scopes.size());
  core::parallel_for(0, scopes.size(), [&](std::size_t i) {
    double mean = 0.0;
    for (const std::size_t k : scopes[i]) mean += seen[static_cast<Index>(k)] / scopes[i].size();
    found[i] = best_steps(problem, beside, scopes[i], mean, levels);
  });
  std::erase_if(found, [](const ReadingSteps& one) { return one.steps.empty(); });  // channels that do not move
  return found;
}

}  // namespace thermotwin::diagnosis
