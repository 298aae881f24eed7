// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/stated_fit.h"

#include <fmt/format.h>

#include <cmath>

#include "diagnosis/causes/parameter.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double most_times_expected = 3.0;  ///< RMS of a channel without a cause where there is no discrepancy

}  // namespace

bool nothing_fits(const Problem& problem, const SearchResult& found) {
  if (found.fitted == 0 || found.chi_square_none > found.fitted || found.stretch.too_far()) return false;
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const Index first = problem.first_row(k), n = problem.observations.channels[k].fitted;
    const double off = (problem.measured - problem.predicted).segment(first, n).norm();
    if (off > problem.expected_std.segment(first, n).norm()) return false;
  }
  return true;
}

std::pair<std::size_t, double> furthest_channel(const Problem& problem) {
  std::pair<std::size_t, double> furthest{0, 0.0};
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const Index first = problem.first_row(k), n = problem.observations.channels[k].fitted;
    const double expected = problem.expected_std.segment(first, n).norm();
    const double off = (problem.measured - problem.predicted).segment(first, n).norm();
    if (expected > 0.0 && off > furthest.second * expected) furthest = {k, off / expected};
  }
  return furthest;
}

bool lessens_furthest(const Problem& problem, const RankedCause& cause) {
  constexpr double clearly = 0.8;
  if (problem.observations.channels.empty()) return false;
  const std::size_t k = furthest_channel(problem).first;
  const Index first = problem.first_row(k), n = problem.observations.channels[k].fitted;
  const VectorXd off = (problem.measured - problem.predicted).segment(first, n);
  for (std::size_t i = 0; i < problem.parameters.size(); ++i) {
    const Parameter& p = problem.parameters[i];
    if (p.kind != cause.parameter.kind || p.where != cause.parameter.where) continue;
    const VectorXd change = (cause.value - problem.nominal[i]) * problem.columns.col(i).segment(first, n);
    if ((off - change).norm() < clearly * off.norm()) return true;
  }
  return false;
}

std::string why_none_does_not_fit(const Problem& problem, const SearchResult& found) {
  const Stretch& stretch = found.stretch;
  if (stretch.beyond()) {
    return fmt::format("without a cause, {} would have to deviate by {:.1f} stated standard deviations",
                       name_of(problem.parameters[stretch.which]), std::abs(stretch.deviations));
  }
  if (stretch.too_far()) {
    return fmt::format(
        "without a cause, the parameters together would have to deviate more than stated (sum of squares {:.0f}, "
        "expected {:.0f})",
        stretch.squares, stretch.squares_mean);
  }
  const auto [channel, times] = furthest_channel(problem);
  if (times <= most_times_expected) return "";
  return fmt::format("without a cause, {} is {:.1f} times as far off as expected",
                     problem.observations.channels[channel].channel.id, times);
}

}  // namespace thermotwin::diagnosis
