// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Order statistics of a few numbers, and random numbers that are the same with every standard library, whose own
// distributions differ.

#include <cstddef>
#include <random>
#include <vector>

namespace thermotwin::core {

/// @param values  finite or infinite, more than n  @param n  0: the smallest
double nth_smallest(std::vector<double> values, std::ptrdiff_t n);

/// @return the median; of an even number of values the larger middle one  @param values  at least one
double median(std::vector<double> values);

/// @return the quantile, linear between the sorted values, the smallest at share 0 and the largest at 1; NaN of none
double quantile(std::vector<double> values, double share);

/// @return a number in [0, 1) with 53 random bits
inline double uniform(std::mt19937_64& engine) { return (engine() >> 11U) * 0x1p-53; }

}  // namespace thermotwin::core
