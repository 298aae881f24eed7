// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/statistics/statistics.h"

#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <limits>
#include <random>

namespace thermotwin::diagnosis {

using Eigen::Index;

double chi_square_tail(double value, double degrees_of_freedom) {
  return value > 0.0 ? boost::math::gamma_q(0.5 * degrees_of_freedom, 0.5 * value) : 1.0;
}

double f_tail(double ratio, double above, double below) {
  return ratio > 0.0 ? boost::math::ibeta(0.5 * below, 0.5 * above, below / (below + above * ratio)) : 1.0;
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
    q += correlation * correlation / (n - lag);
  }
  return chi_square_tail(n * (n + 2.0) * q, used);
}

double log_sum_exp(const std::vector<double>& logs) {
  const double top = *std::max_element(logs.begin(), logs.end());
  double sum = 0.0;
  for (const double value : logs) sum += std::exp(value - top);
  return top + std::log(sum);
}

double log_mean_exp(const std::vector<double>& logs) { return log_sum_exp(logs) - std::log(1.0 * logs.size()); }

double root_mean_square(const Eigen::VectorXd& values) {
  double sum = 0.0;
  Index count = 0;
  for (const double value : values)
    if (std::isfinite(value)) sum += value * value, ++count;
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

double spread_of(const Eigen::VectorXd& values) {
  std::vector<double> good;
  for (const double value : values)
    if (std::isfinite(value)) good.push_back(value);
  if (good.size() < 2) return 0.0;
  const Eigen::VectorXd finite = Eigen::Map<Eigen::VectorXd>(good.data(), std::ssize(good));
  return root_mean_square(finite.array() - finite.mean());
}

double reduction_percent(double before, double after) { return before > 0.0 ? 100.0 * (1.0 - after / before) : 0.0; }

Interval reduction_interval(const Eigen::VectorXd& before, const Eigen::VectorXd& after, Index block, int draws,
                            std::uint64_t seed) {
  const Index n = before.size();
  if (n == 0) return {};
  block = std::clamp<Index>(block, 1, std::max<Index>(1, n / 4));
  const Index starts = n - block + 1, blocks = (n + block - 1) / block;
  std::mt19937_64 random(seed);
  std::vector<double> drawn;
  drawn.reserve(draws);
  for (int k = 0; k < draws; ++k) {
    double b = 0.0, a = 0.0;
    for (Index i = 0; i < blocks; ++i) {
      // Plain modulo: the same draws with every standard library; its bias is below 1e-15.
      const Index first = random() % starts;
      b += before.segment(first, block).sum();
      a += after.segment(first, block).sum();
    }
    drawn.push_back(reduction_percent(std::sqrt(b), std::sqrt(a)));
  }
  std::sort(drawn.begin(), drawn.end());
  const auto at = [&](double share) { return drawn[static_cast<Index>(share * (draws - 1))]; };
  const Interval drawn_between{at(0.025), at(0.975)};
  if (n >= least_means) return drawn_between;
  return {std::min(0.0, drawn_between.low), std::max(0.0, drawn_between.high)};
}

}  // namespace thermotwin::diagnosis
