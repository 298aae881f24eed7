// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/changing_size.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "core/units.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/inference/evidence.h"
#include "diagnosis/inference/hypothesis_fit.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t most_tried = 24;  ///< sources and joints
constexpr int coarse_times = 16, finer_times = 9, finer_passes = 3;
constexpr std::size_t most_laws = 3;  ///< of the sources and joints, with a size in each of many intervals
constexpr int law_intervals = 60;
constexpr double law_std = 1.0, law_memory_s = 2.0 * core::units::hour;  ///< of a size that wanders or jumps
constexpr std::size_t most_steps = 3;
constexpr double no_step_std = 0.01;  ///< of the factor, where nothing happened
constexpr double unseen_std = 1e-4;   ///< of the factor: of columns that are not asked for
constexpr double least_step_evidence = 5.0;
constexpr double much_better = 1.5;                      ///< evidence of a law over that of a simple cause at its place
constexpr double as_probable = 0.5;                      ///< ln, by which times may differ
constexpr double told_apart_by = 5.0;                    ///< nats over a constant change
constexpr double may_compete = 0.8, within_nats = 10.0;  ///< of the evidence of what leads

struct Tried {
  int parameter = -1;
  double cause_std = 0;
};

bool may_change(Kind kind) {
  return kind == Kind::source_power || kind == Kind::process_heat || kind == Kind::contact_conductance;
}

/// Sources and joints whose constant change describes the record best.
std::vector<Tried> leading(const Problem& problem, const SearchResult& found) {
  std::vector<std::pair<double, Tried>> all;
  for (int i = 0; i < std::ssize(problem.parameters); ++i) {
    const Parameter& p = problem.parameters[i];
    const Hypothesis* single = may_change(p.kind) ? found.single(i) : nullptr;
    if (single != nullptr) all.emplace_back(single->log_evidence, Tried{i, p.cause_std});
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  all.resize(std::min(all.size(), most_tried));
  std::vector<Tried> tried;
  for (const auto& one : all) tried.push_back(one.second);
  return tried;
}

Parameter step_of(const Problem& problem, const Tried& tried, double from_s) {
  const Parameter& constant = problem.parameters[tried.parameter];
  const bool joint = constant.kind == Kind::contact_conductance;
  Parameter step = make_parameter(joint ? Kind::contact_step : Kind::source_step, constant.where);
  step.nominal_std = no_step_std;
  step.cause_std = tried.cause_std;
  step.from_s = from_s;
  return step;
}

/// Evenly over the fitted part, without its ends: a step there is a constant change, or nothing.
std::vector<double> step_times(const Observations& obs, int count) {
  std::vector<double> all;
  for (int k = 1; k <= count; ++k) all.push_back(obs.start + (obs.split - obs.start) * k / (count + 1));
  return all;
}

/// ln Bayes factors against none of columns beside those of a problem.
class Beside {
public:
  /// @param columns  (observations x any)
  Beside(const Problem& problem, const White& white, const MatrixXd& columns)
      : first_(problem.columns.cols()),
        evidence_(joined_columns(white.columns, white.of(problem, columns)), white.residual,
                  joined_std(problem.prior_std, columns.cols())) {}

  double of_step(const Parameter& step, Index column) const {
    const int at = first_ + column;
    const LinearEvidence::Widened wide = evidence_.widen({&at, 1}, {&step.cause_std, 1});
    return share_ * (wide.log_ratio + log_within_bounds(step, step.nominal + wide.mean[0], wide.std[0]));
  }
  double of_constant(const Parameter& constant, int parameter) const {
    const LinearEvidence::Widened wide = evidence_.widen({&parameter, 1}, {&constant.cause_std, 1});
    return share_ * (wide.log_ratio + log_within_bounds(constant, constant.nominal + wide.mean[0], wide.std[0]));
  }
  /// All of some columns with the same prior.
  double of_many(Index first, Index count, double std) const {
    std::vector<int> which(count);
    std::iota(which.begin(), which.end(), first_ + first);
    return share_ * evidence_.widen(which, std::vector<double>(count, std)).log_ratio;
  }

private:
  static MatrixXd joined_columns(const MatrixXd& a, const MatrixXd& b) {
    MatrixXd both(a.rows(), a.cols() + b.cols());
    both << a, b;
    return both;
  }
  static VectorXd joined_std(const VectorXd& prior, Index columns) {
    VectorXd both = VectorXd::Constant(prior.size() + columns, unseen_std);
    both.head(prior.size()) = prior;
    return both;
  }

  int first_;
  LinearEvidence evidence_;
  double share_ = SearchOptions{}.evidence_share;
};

/// The size in each interval between the times is its own: differences of steps. (observations x intervals)
MatrixXd intervals(const VectorXd& constant, const MatrixXd& steps) {
  MatrixXd each(steps.rows(), steps.cols() + 1);
  each << constant, steps;
  each.leftCols(steps.cols()) -= steps;
  return each;
}

struct Timed {
  std::vector<double> from_s;
  std::vector<double> evidence;
  double log_share = 0;  ///< of the best time in the prior of all times
  std::size_t best() const { return std::max_element(evidence.begin(), evidence.end()) - evidence.begin(); }
  /// Of the times without a gap about the best one that are about as probable, s.
  std::pair<double, double> best_range() const {
    const double least = evidence[best()] - as_probable;
    std::size_t first = best(), last = first;
    while (first > 0 && evidence[first - 1] > least) --first;
    while (last + 1 < evidence.size() && evidence[last + 1] > least) ++last;
    return {from_s[first], from_s[last]};
  }
};

/// The time of a step by its probability, s.
struct TimeOfStep {
  double mean = 0, std = 0;

  /// RMS distance from the stated time, and half of the means' interval.
  double std_about(double stated_s, double interval_s) const {
    return std::hypot(std, mean - stated_s, 0.5 * interval_s);
  }
};

/// @param evidence  ln, over the time
TimeOfStep time_by(const std::map<double, double>& evidence) {
  double most = -std::numeric_limits<double>::infinity(), sum = 0.0, first = 0.0, squares = 0.0;
  for (const auto& [when, log] : evidence) most = std::max(most, log);
  const double origin = evidence.begin()->first;
  for (auto right = std::next(evidence.begin()); right != evidence.end(); ++right) {
    const auto left = std::prev(right);
    const double width = right->first - left->first;
    for (const auto& [when, log] : {*left, *right}) {
      const double weight = 0.5 * width * std::exp(log - most);
      sum += weight;
      first += weight * (when - origin);
      squares += weight * (when - origin) * (when - origin);
    }
  }
  const double mean = first / sum;
  return {origin + mean, std::sqrt(std::max(0.0, squares / sum - mean * mean))};
}

/// Steps at times about one, and what the record says of each.
struct TriedTimes {
  std::vector<Parameter> steps;
  MatrixXd columns;
  VectorXd evidence;
  double constant = 0;  ///< of a constant change
};

/// The best time is refined. Where several times are about as probable, the step is in their mean.
ChangingSizes::Step at_its_time(const Problem& problem, const Response& response, const MachineInTime& base,
                                const White& white, const Tried& tried, const Timed& coarse, std::size_t places) {
  std::map<double, double> everywhere;  // evidence over the time
  const auto about = [&](double middle, double width) {
    TriedTimes times;
    for (int k = 0; k < finer_times; ++k)
      times.steps.push_back(step_of(problem, tried, middle + width * (2.0 * k / (finer_times - 1) - 1.0)));
    times.columns = response.linearise(base, times.steps, VectorXd::Ones(std::ssize(times.steps)), false).sensitivity;
    const Beside beside(problem, white, times.columns);
    times.evidence.resize(finer_times);
    for (Index k = 0; k < finer_times; ++k) times.evidence[k] = beside.of_step(times.steps[k], k);
    times.constant = beside.of_constant(problem.parameters[tried.parameter], tried.parameter);
    return times;
  };
  // The first pass spans the coarse times that are about as probable as the best one, and one beyond at either end.
  const auto [first, last] = coarse.best_range();
  double middle = 0.5 * (first + last), width = 0.5 * (last - first) + coarse.from_s[1] - coarse.from_s[0];
  for (std::size_t k = 0; k < coarse.from_s.size(); ++k) everywhere[coarse.from_s[k]] = coarse.evidence[k];
  TriedTimes times;
  Index best = 0;
  for (int pass = 0; pass < finer_passes; ++pass, width *= 2.0 / (finer_times - 1)) {
    times = about(middle, width);
    for (std::size_t k = 0; k < times.steps.size(); ++k) everywhere[times.steps[k].from_s] = times.evidence[k];
    times.evidence.maxCoeff(&best);
    middle = times.steps[best].from_s;
  }
  const TimeOfStep time = time_by(everywhere);
  if (time.std > width) {
    TriedTimes at_mean = about(time.mean, width);
    const Index centre = finer_times / 2;
    if (at_mean.evidence[centre] > times.evidence[best] - as_probable) {
      times = std::move(at_mean);
      best = centre;
    }
  }
  const Index before = std::max<Index>(best - 1, 0), after = std::min<Index>(best + 1, times.columns.cols() - 1);
  ChangingSizes::Step found;
  found.parameter = times.steps[best];
  found.parameter.from_std_s = time.std_about(found.parameter.from_s, problem.observations.interval);
  found.parameter.prior_share = std::exp(coarse.log_share) / places;
  found.column = times.columns.col(best);
  found.freedom = found.parameter.from_std_s / (times.steps[after].from_s - times.steps[before].from_s) *
                  (times.columns.col(before) - times.columns.col(after));
  found.log_evidence = times.evidence[best];
  found.over_constant = found.log_evidence - times.constant;
  return found;
}

/// ln Bayes factor of a size that wanders or jumps in the course of the record: an Ornstein-Uhlenbeck process.
double evidence_of_law(const Problem& problem, const Response& response, const MachineInTime& base, const White& white,
                       const Tried& tried) {
  const std::vector<double> when = step_times(problem.observations, law_intervals - 1);
  std::vector<Parameter> steps;
  for (const double from_s : when) steps.push_back(step_of(problem, tried, from_s));
  const MatrixXd each =
      intervals(problem.columns.col(tried.parameter),
                response.linearise(base, steps, VectorXd::Ones(std::ssize(steps)), false).sensitivity);
  const double length = when[1] - when[0];
  const MatrixXd covariance = MatrixXd::NullaryExpr(law_intervals, law_intervals, [&](Index i, Index j) {
    return std::exp(-std::abs(i - j) * length / law_memory_s);
  });
  const MatrixXd root = covariance.llt().matrixL();
  MatrixXd columns(white.columns.rows(), white.columns.cols() + law_intervals);
  columns << white.columns, white.of(problem, each * root);
  VectorXd std = VectorXd::Constant(columns.cols(), law_std);
  std.head(problem.prior_std.size()) = problem.prior_std;
  return SearchOptions{}.evidence_share *
         (LinearEvidence(columns, white.residual, std).log_evidence() -
          LinearEvidence(white.columns, white.residual, problem.prior_std).log_evidence());
}

}  // namespace

ChangingSizes find_changing_sizes(const Problem& problem, const Response& response, const mesh::Machine& machine,
                                  const SearchResult& found) {
  ChangingSizes result;
  const std::vector<Tried> tried = leading(problem, found);
  if (tried.empty()) return result;
  const std::vector<double> when = step_times(problem.observations, coarse_times);
  std::vector<Parameter> steps;
  for (const Tried& one : tried)
    for (const double from_s : when) steps.push_back(step_of(problem, one, from_s));
  const MachineInTime base = problem.machine_around(machine, {});
  const MatrixXd columns = response.linearise(base, steps, VectorXd::Ones(std::ssize(steps)), false).sensitivity;
  const White white(problem);
  const Index count = std::ssize(when);
  MatrixXd each(columns.rows(), std::ssize(tried) * (count + 1));
  for (Index i = 0; i < std::ssize(tried); ++i) {
    const std::size_t at = i;
    each.middleCols(i * (count + 1), count + 1) =
        intervals(problem.columns.col(tried[at].parameter), columns.middleCols(i * count, count));
  }
  const Beside steps_beside(problem, white, columns), intervals_beside(problem, white, each);
  std::vector<Timed> timed(tried.size(), {when, std::vector<double>(when.size()), 0.0});
  for (std::size_t i = 0; i < tried.size(); ++i) {
    for (std::size_t k = 0; k < when.size(); ++k) {
      const std::size_t column = i * when.size() + k;
      timed[i].evidence[k] = steps_beside.of_step(steps[column], column);
    }
    timed[i].log_share = log_mean_exp(timed[i].evidence) - timed[i].evidence[timed[i].best()];
    const Index first = i * (count + 1);
    result.laws.push_back({tried[i].parameter, intervals_beside.of_many(first, count + 1, tried[i].cause_std), 0.0});
  }
  std::stable_sort(result.laws.begin(), result.laws.end(),
                   [](const ChangingLaw& a, const ChangingLaw& b) { return a.log_evidence > b.log_evidence; });
  for (std::size_t i = 0; i < std::min(most_laws, result.laws.size()); ++i) {
    ChangingLaw& law = result.laws[i];
    law.log_evidence =
        std::max(law.log_evidence, evidence_of_law(problem, response, base, white, {law.parameter, law_std}));
  }
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < tried.size(); ++i)
    if (timed[i].evidence[timed[i].best()] > least_step_evidence) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return timed[a].evidence[timed[a].best()] > timed[b].evidence[timed[b].best()];
  });
  order.resize(std::min(order.size(), most_steps));
  for (const std::size_t i : order) {
    const std::size_t places = std::count_if(problem.parameters.begin(), problem.parameters.end(), [&](const auto& p) {
      return may_change(p.kind) && row_of(p.kind).target == row_of(problem.parameters[tried[i].parameter].kind).target;
    });
    result.steps.push_back(at_its_time(problem, response, base, white, tried[i], timed[i], places));
  }
  return result;
}

std::vector<ChangingLaw> clear_laws(const Problem& problem, const SearchResult& found, std::vector<ChangingLaw> laws) {
  std::erase_if(laws, [&](const ChangingLaw& law) {
    const Parameter& own = problem.parameters[law.parameter];
    return std::any_of(found.hypotheses.begin(), found.hypotheses.end(), [&](const Hypothesis& h) {
      if (h.members.size() != 1) return false;
      const Parameter& simple = problem.parameters[h.members.front()];
      return simple.where == own.where && row_of(simple.kind).target == row_of(own.kind).target &&
             law.log_evidence < much_better * h.log_evidence;
    });
  });
  return laws;
}

bool add_steps(Problem& problem, const std::vector<ChangingSizes::Step>& steps, const SearchResult& found) {
  const double leads = found.hypotheses.front().log_evidence;
  bool any = false;
  for (const ChangingSizes::Step& step : steps) {
    // One before a source does anything is a constant change.
    if (step.over_constant < told_apart_by || step.log_evidence < may_compete * leads - within_nats) continue;
    problem.place_freedom[problem.parameters.size()] = step.freedom;
    add_parameter(problem, step.parameter, step.column);
    any = true;
  }
  return any;
}

}  // namespace thermotwin::diagnosis
