// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Normal random numbers by Box and Muller from the engine's bits: std::normal_distribution differs between libraries,
// and a seed should mean the same numbers everywhere.

#include <Eigen/Core>

#include <cstdint>
#include <random>

namespace thermotwin::core {

class NormalDraws {
public:
  explicit NormalDraws(std::uint64_t seed) : engine_(seed) {}
  double operator()();
  Eigen::Vector3d vector() { return {(*this)(), (*this)(), (*this)()}; }

private:
  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace thermotwin::core
