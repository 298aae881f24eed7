// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Outlet temperatures of the chillers, dT/dt = (s(t) - T) / time_constant, exact for a guide reading
// that is a quadratic in time over the step. s is the set point (guide reading + guide offset);
// with two-point control it is set point - pull_down while the compressor runs, set point +
// drift_up while it rests; it starts where T - set point reaches band / 2, and stops at - band / 2.
// A measured inlet takes the outlet's place; a circuit that is off keeps its temperature.

#include <Eigen/Core>
#include <vector>

#include "core/binary.h"
#include "mesh/machine.h"
#include "solver/channels.h"

namespace thermotwin::solver {

/// What the chillers aim at, K above the reference: reading of the guide sensor (air where there is
/// none) plus guide offset.
/// @param sensors_K  (sensors) readings, with the sensors' own offsets
Eigen::VectorXd chiller_set_points(const mesh::Machine& machine, const Eigen::VectorXd& sensors_K,
                                   double air_K);

class Chiller {
 public:
  /// @param start_K  (coolants) first outlet temperatures above the reference; compressors rest
  Chiller(const mesh::Machine& machine, const Channels& channels, Eigen::VectorXd start_K);

  /// A step in which the guide readings stand; compressors switch within it.
  /// @param sensors_K  (sensors) readings with the sensors' own offsets, at the start of the step
  /// @return inlets of the step: the outlet at its end; with two-point control its mean
  const Eigen::VectorXd& advance(const Eigen::VectorXd& row, const Eigen::VectorXd& sensors_K,
                                 double air_K, double step_s);
  const Eigen::VectorXd& outlet_K() const { return outlet_K_; }

  /// Readings over a step that is tried: value + slope s + curve s^2, s in seconds from now.
  struct Readings {
    Eigen::VectorXd value, slope, curve;   ///< (sensors) K, K/s, K/s^2
    double air = 0, air_slope = 0;
  };
  /// Outlets after a time in which no compressor switches.
  Eigen::VectorXd outlet_after(const Eigen::VectorXd& row, const Readings& readings, double s) const;
  /// How far each outlet then is beyond the end of its band, K; < 0 within, or without a band.
  Eigen::VectorXd beyond_band(const Eigen::VectorXd& row, const Readings& readings, double s) const;
  /// Goes there. @param row  channels at that time
  void move(const Eigen::VectorXd& row, const Readings& readings, double s);
  void toggle(Eigen::Index coolant) { running_[static_cast<std::size_t>(coolant)] ^= 1; }
  bool running(Eigen::Index coolant) const { return running_[static_cast<std::size_t>(coolant)] != 0; }

  void save(core::BinaryWriter& out) const;
  void load(core::BinaryReader& in);

 private:
  struct Circuit {
    int on, inlet, guide;   // guide -1: the air
    double offset, time_constant;
    bool two_point;
    double band, pull_down, drift_up;
  };
  double aim(std::size_t circuit) const;   // of the outlet, relative to the set point
  double mean_over_step(std::size_t circuit, double set, double step_s);

  std::vector<Circuit> circuits_;
  double reference_C_ = 0;
  Eigen::VectorXd outlet_K_, inlet_K_;
  std::vector<char> running_;
};

}  // namespace thermotwin::solver
