// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/connection_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "compensation/measurement/unit_hint.h"
#include "diagnosis/judge/residual_analysis.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double most_left = 0.5;     ///< of the residual of two, once they are exchanged
constexpr double most_of_each = 0.7;  ///< of the residual of either
constexpr Index least_means = 8;

/// The means that two channels have of the same intervals.
struct Common {
  VectorXd measured_a, measured_b, predicted_a, predicted_b;
};

Common common_means(const Problem& problem, std::size_t a, std::size_t b) {
  const ObservedChannel &one = problem.observations.channels[a], &other = problem.observations.channels[b];
  std::vector<Index> of_a, of_b;
  for (Index i = 0, j = 0; i < one.size() && j < other.size();) {
    const std::size_t at = i, there = j;
    if (one.interval[at] == other.interval[there]) {
      of_a.push_back(problem.first_row(a) + i++);
      of_b.push_back(problem.first_row(b) + j++);
    } else if (one.interval[at] < other.interval[there]) {
      ++i;
    } else {
      ++j;
    }
  }
  return {problem.measured(of_a), problem.measured(of_b), problem.predicted(of_a), problem.predicted(of_b)};
}

double difference(const VectorXd& measured, const VectorXd& predicted, bool about_mean) {
  VectorXd left = measured - predicted;
  if (about_mean) left.array() -= left.mean();
  return root_mean_square(left);
}

struct Exchange {
  std::size_t a = 0, b = 0;
  double stated = 0, exchanged = 0;  ///< RMS of both channels together
};

std::optional<Exchange> exchange_of(const Problem& problem, std::size_t a, std::size_t b) {
  const ObservedChannel &one = problem.observations.channels[a], &other = problem.observations.channels[b];
  if (one.record != other.record || one.is_temperature() != other.is_temperature()) return std::nullopt;
  const bool gauges = !one.is_temperature();
  if (gauges && one.channel.unit != other.channel.unit) return std::nullopt;
  const Common both = common_means(problem, a, b);
  if (both.measured_a.size() < least_means) return std::nullopt;
  const double own_a = difference(both.measured_a, both.predicted_a, gauges),
               own_b = difference(both.measured_b, both.predicted_b, gauges),
               as_b = difference(both.measured_a, both.predicted_b, gauges),
               as_a = difference(both.measured_b, both.predicted_a, gauges);
  const Exchange found{a, b, std::sqrt(0.5) * std::hypot(own_a, own_b), std::sqrt(0.5) * std::hypot(as_a, as_b)};
  // What a reads belongs to b: that has to fit b better than what b reads does.
  if (found.exchanged > most_left * found.stated || as_b > most_of_each * own_b || as_a > most_of_each * own_a)
    return std::nullopt;
  return found;
}

std::vector<ConnectionDoubt> exchanges(const Problem& problem, const std::vector<std::size_t>& off) {
  std::vector<Exchange> found;
  for (std::size_t i = 0; i < off.size(); ++i) {
    for (std::size_t j = i + 1; j < off.size(); ++j)
      if (const auto one = exchange_of(problem, off[i], off[j])) found.push_back(*one);
  }
  std::sort(found.begin(), found.end(),
            [](const Exchange& x, const Exchange& y) { return x.exchanged * y.stated < y.exchanged * x.stated; });
  std::set<std::size_t> taken;
  std::vector<ConnectionDoubt> doubts;
  for (const Exchange& one : found) {
    if (taken.count(one.a) != 0 || taken.count(one.b) != 0) continue;
    taken.insert({one.a, one.b});
    const compensation::MeasuredChannel &a = problem.observations.channels[one.a].channel,
                                        &b = problem.observations.channels[one.b].channel;
    const std::string unit = residual_unit(a.unit);
    doubts.push_back(
        {fmt::format("{} and {} seem to be exchanged", a.id, b.id),
         fmt::format("Channels {} and {} may be exchanged: with each in the place of the other they differ "
                     "from the simulation by {:.3g} {} RMS, as stated by {:.3g} {}.",
                     a.id, b.id, one.exchanged, unit, one.stated, unit),
         true});
  }
  return doubts;
}

}  // namespace

std::vector<ConnectionDoubt> connection_doubts(const Problem& problem) {
  std::set<std::size_t> arranged;
  for (const PointTest& test : problem.tests) arranged.insert(test.channels.begin(), test.channels.end());
  std::vector<std::size_t> off;
  std::vector<ConnectionDoubt> doubts;
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const ObservedChannel& observed = problem.observations.channels[k];
    const Index first = problem.first_row(k), n = observed.size();
    const VectorXd measured = problem.measured.segment(first, n), predicted = problem.predicted.segment(first, n);
    if (root_mean_square(measured - predicted) < unexpected * root_mean_square(problem.expected_std.segment(first, n)))
      continue;
    if (arranged.count(k) == 0) off.push_back(k);
    const auto hint = compensation::unit_hint(observed.channel, measured, predicted);
    if (!hint) continue;
    doubts.push_back({observed.channel.id + ": " + hint->words, compensation::in_words(*hint, observed.channel),
                      hint->rms_changed <= most_left * hint->rms_stated});
  }
  for (ConnectionDoubt& exchange : exchanges(problem, off)) doubts.push_back(std::move(exchange));
  return doubts;
}

}  // namespace thermotwin::diagnosis
