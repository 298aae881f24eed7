// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/residual_analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/first_order_lag.h"
#include "core/interpolation.h"
#include "core/units.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

using core::units::hour;
constexpr double delays[] = {0.0, 0.25 * hour, hour, 4.0 * hour, 12.0 * hour};
constexpr double follows_above = 0.6;  ///< correlation that is worth telling

double correlation(const VectorXd& a, const VectorXd& b) {
  const VectorXd x = a.array() - a.mean(), y = b.array() - b.mean();
  const double size = x.norm() * y.norm();
  return size > 1e-12 * (1.0 + a.norm() * b.norm()) ? x.dot(y) / size : 0.0;
}

/// From the decay of the correlation over the gaps that there are, by least squares of its logarithm.
double memory_of(const VectorXd& time, const VectorXd& residual) {
  const VectorXd x = residual.array() - residual.mean();
  const double power = x.squaredNorm() / std::max<Index>(x.size(), 1);
  if (x.size() < 8 || !(power > 0.0)) return 0.0;
  double product = 0.0, gap = 0.0;
  for (Index i = 1; i < x.size(); ++i) product += x[i] * x[i - 1], gap += time[i] - time[i - 1];
  const double n = x.size() - 1, r = product / n / power;
  const double length = time[time.size() - 1] - time[0];  // no record shows a longer memory than it lasts
  return r > 0.0 && r < 1.0 ? std::min(-(gap / n) / std::log(r), length) : 0.0;
}

}  // namespace

ResidualAnalysis analyse(const std::string& id, const VectorXd& time, const VectorXd& residual,
                         const VectorXd& expected_std, const InputHistory& inputs) {
  ResidualAnalysis result;
  result.id = id;
  if (residual.size() == 0) return result;
  Index at = 0;
  residual.cwiseAbs().maxCoeff(&at);
  result.peak = residual[at];
  result.peak_time_s = time[at];
  result.mean = residual.mean();
  result.ratio = root_mean_square(residual) / std::max(root_mean_square(expected_std), 1e-12);
  result.memory_s = memory_of(time, residual);
  for (Index k = 0; k < inputs.values.cols(); ++k) {
    VectorXd series(inputs.points.size());
    series.head(inputs.values.rows()) = inputs.values.col(k);
    series[series.size() - 1] = series[std::max<Index>(series.size() - 2, 0)];
    // A range that is not given, or an input that stands, is followed by nothing.
    if (!series.allFinite() || series.maxCoeff() - series.minCoeff() < 1e-9) continue;
    const VectorXd from_start = series.cwiseAbs().array() - std::abs(series[0]);
    for (const double delay : delays) {
      const VectorXd followed = core::lagged_lines(inputs.points, from_start, delay);
      VectorXd seen(time.size());
      for (Index i = 0; i < time.size(); ++i) seen[i] = core::linear_at(inputs.points, followed, time[i]);
      const double r = correlation(seen, residual);
      if (std::abs(r) <= std::abs(result.correlation)) continue;
      result.correlation = r;
      result.follows = inputs.names[k];
      result.delay_s = delay;
    }
  }
  if (std::abs(result.correlation) < follows_above) result.follows.clear();
  return result;
}

std::string residual_unit(const std::string& unit) { return unit == "degC" ? "K" : unit; }

std::vector<ResidualAnalysis> analyse(const Problem& problem, const solver::Channels& channels) {
  const Observations& obs = problem.observations;
  std::vector<InputHistory> inputs;
  for (const Observations& record : obs.each()) inputs.push_back({channels.names(), record.points, record.rows});
  std::vector<ResidualAnalysis> all;
  for (std::size_t k = 0; k < obs.channels.size(); ++k) {
    const ObservedChannel& channel = obs.channels[k];
    const Index first = problem.first_row(k), n = channel.size();
    const VectorXd time = channel.time.array() - obs.each()[channel.record].offset.time;
    all.push_back(analyse(channel.channel.id, time, (problem.measured - problem.predicted).segment(first, n),
                          problem.expected_std.segment(first, n), inputs[channel.record]));
  }
  return all;
}

std::vector<std::string> in_words(const std::vector<ResidualAnalysis>& analysis) {
  std::vector<std::string> words;
  for (const ResidualAnalysis& a : analysis) {
    if (a.ratio < unexpected) continue;
    std::string text =
        fmt::format("{}: RMS {:.1f} times the expected one, largest {:+.3g} at {:.1f} h, correlation time {:.1f} h",
                    a.id, a.ratio, a.peak, a.peak_time_s / hour, a.memory_s / hour);
    if (!a.follows.empty()) {
      text += fmt::format(", follows {}{} (correlation {:+.2f})", a.follows,
                          a.delay_s > 0.0 ? fmt::format(" after {:.2g} h", a.delay_s / hour) : std::string(),
                          a.correlation);
    }
    words.push_back(text + ".");
  }
  return words;
}

}  // namespace thermotwin::diagnosis
