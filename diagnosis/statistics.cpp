// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace thermotwin::diagnosis {

using Eigen::Index;

namespace {

/// Upper regularised incomplete gamma function: series below, Lentz's continued fraction above a + 1.
double gamma_q(double a, double x) {
  if (x <= 0.0) return 1.0;
  const double front = std::exp(-x + a * std::log(x) - std::lgamma(a));
  if (x < a + 1.0) {
    double term = 1.0 / a, sum = term;
    for (int i = 1; i < 10000 && std::abs(term) > 1e-15 * std::abs(sum); ++i) {
      term *= x / (a + i);
      sum += term;
    }
    return std::clamp(1.0 - front * sum, 0.0, 1.0);
  }
  constexpr double tiny = 1e-300;
  double b = x + 1.0 - a, c = 1.0 / tiny, d = 1.0 / b, h = d;
  for (int i = 1; i < 10000; ++i) {
    const double an = -i * (i - a);
    b += 2.0;
    d = an * d + b;
    if (std::abs(d) < tiny) d = tiny;
    c = b + an / c;
    if (std::abs(c) < tiny) c = tiny;
    d = 1.0 / d;
    h *= d * c;
    if (std::abs(d * c - 1.0) < 1e-15) break;
  }
  return std::clamp(front * h, 0.0, 1.0);
}

}  // namespace

double chi_square_tail(double value, double degrees_of_freedom) {
  return gamma_q(0.5 * degrees_of_freedom, 0.5 * value);
}

double white_noise_p_value(const Eigen::VectorXd& series, int lags) {
  const Index n = series.size();
  const Index used = std::min<Index>(lags, n / 4);
  if (used < 1) return 1.0;
  const Eigen::VectorXd x = series.array() - series.mean();
  const double power = x.squaredNorm();
  if (!(power > 0.0)) return 1.0;
  double q = 0.0;
  for (Index lag = 1; lag <= used; ++lag) {
    const double correlation = x.head(n - lag).dot(x.tail(n - lag)) / power;
    q += correlation * correlation / static_cast<double>(n - lag);
  }
  return chi_square_tail(static_cast<double>(n) * static_cast<double>(n + 2) * q, static_cast<double>(used));
}

double root_mean_square(const Eigen::VectorXd& values) {
  double sum = 0.0;
  Index count = 0;
  for (const double value : values)
    if (std::isfinite(value)) sum += value * value, ++count;
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

double reduction_percent(double before, double after) {
  return before > 0.0 ? 100.0 * (1.0 - after / before) : 0.0;
}

Interval reduction_interval(const Eigen::VectorXd& before, const Eigen::VectorXd& after, Index block,
                            int draws, std::uint64_t seed) {
  const Index n = before.size();
  if (n == 0) return {};
  block = std::clamp<Index>(block, 1, std::max<Index>(1, n / 4));
  const Index starts = n - block + 1, blocks = (n + block - 1) / block;
  std::mt19937_64 random(seed);
  std::vector<double> drawn;
  drawn.reserve(static_cast<std::size_t>(draws));
  for (int k = 0; k < draws; ++k) {
    double b = 0.0, a = 0.0;
    for (Index i = 0; i < blocks; ++i) {
      // Plain modulo: the same draws with every standard library; its bias is below 1e-15.
      const auto first = static_cast<Index>(random() % static_cast<std::uint64_t>(starts));
      b += before.segment(first, block).sum();
      a += after.segment(first, block).sum();
    }
    drawn.push_back(reduction_percent(std::sqrt(b), std::sqrt(a)));
  }
  std::sort(drawn.begin(), drawn.end());
  const auto at = [&](double share) {
    return drawn[static_cast<std::size_t>(share * static_cast<double>(draws - 1))];
  };
  const Interval drawn_between{at(0.025), at(0.975)};
  if (n >= least_means) return drawn_between;
  return {std::min(0.0, drawn_between.low), std::max(0.0, drawn_between.high)};
}

}  // namespace thermotwin::diagnosis
