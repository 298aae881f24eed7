// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Small statistics of residuals.

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace thermotwin::diagnosis {

/// Probability that a chi-square variable of so many degrees of freedom exceeds the value.
double chi_square_tail(double value, double degrees_of_freedom);

/// Probability that a variance ratio F exceeds `ratio`. @param above, below  its degrees of freedom
double f_tail(double ratio, double above, double below);

/// Ljung-Box test of white noise: p value. 1 where the series is too short or constant.
/// @param lags  at most a quarter of the length is used
double white_noise_p_value(const Eigen::VectorXd& series, int lags = 10);

/// Logarithm of the sum, and of the mean, of exp(logs), of at least one.
double log_sum_exp(const std::vector<double>& logs);
double log_mean_exp(const std::vector<double>& logs);

double root_mean_square(const Eigen::VectorXd& values);  ///< of the finite ones; 0 if there is none

double spread_of(const Eigen::VectorXd& values);  ///< standard deviation of the finite ones; 0 of fewer than two

struct Interval {
  double low = 0, high = 0;
};

/// With fewer means, reduction_interval() widens its result to contain 0.
inline constexpr Eigen::Index least_means = 4;

/// Reduction of the root mean square, percent, with the 95 % interval of a moving block bootstrap:
/// residuals of one block stay together, so that their correlation in time counts.
/// @param before, after  (n) sums of squares per interval of time
/// @param block          intervals in a block, at most a quarter of n
Interval reduction_interval(const Eigen::VectorXd& before, const Eigen::VectorXd& after, Eigen::Index block,
                            int draws = 2000, std::uint64_t seed = 20240607);
double reduction_percent(double before, double after);  ///< of root mean squares; 0 where before is 0

}  // namespace thermotwin::diagnosis
