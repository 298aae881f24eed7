// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Order statistics of a handful of numbers, and random numbers that are the same with every standard library
// (the library's distributions are its own).

#include <cstddef>
#include <random>
#include <vector>

namespace thermotwin::core {

/// @param values  finite or infinite, more than n  @param n  0: the smallest
double nth_smallest(std::vector<double> values, std::ptrdiff_t n);

/// Of an even number of values the larger one in the middle. @param values  at least one
double median(std::vector<double> values);

/// Linear between the sorted values, the smallest at share 0 and the largest at 1; NaN of none.
double quantile(std::vector<double> values, double share);

/// In [0, 1), of 53 bits.
inline double uniform(std::mt19937_64& engine) { return (engine() >> 11U) * 0x1p-53; }

}  // namespace thermotwin::core
