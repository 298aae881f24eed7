// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Random numbers of the tests.

#include <cstdint>
#include <random>

namespace thermotwin::compensation::test {

/// Uniform numbers, the same on every machine.
class Uniform {
public:
  explicit Uniform(std::uint64_t seed) : engine_(seed) {}
  /// @return a number in [0, 1)
  double operator()() { return static_cast<double>(engine_() >> 11U) * 0x1p-53; }
  double operator()(double low, double high) { return low + (high - low) * (*this)(); }
  /// Sum of twelve: near to normal.
  double normal() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += (*this)();
    return sum;
  }

private:
  std::mt19937_64 engine_;
};

}  // namespace thermotwin::compensation::test
