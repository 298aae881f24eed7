// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Outlet temperatures of the chillers. The set point is the guide's reading (a sensor, or an ambient)
// plus guide offset; a volume beside the guide sensor, such as the control cabinet, takes a share of
// the reading. What is held at the set point is the outlet, or the return of the circuit.
//   lag        tau dT/dt = set - T
//   two_point  tau dT/dt = base - pull_down - T while the compressor runs, base + drift_up - T while
//              it rests; base is the set point, or the return where that is controlled. It starts
//              where what is held reaches set + band / 2, and stops at - band / 2.
//   pi         tau dT/dt = return - u - T with u = gain (held - set) + integral, within what the
//              cooling power allows at the flow; the integral waits while u is at a limit.
// lag and two_point on the outlet are exact for readings that are quadratic in time over the step;
// the others go in parts of tau / 8. A measured inlet takes the outlet's place; a circuit that is off
// keeps its temperature.

#include <Eigen/Core>

#include <vector>

#include "core/binary.h"
#include "mesh/machine/machine.h"
#include "solver/operation/channels.h"
#include "solver/operation/layout.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::solver {

/// What the chillers aim at, (coolants) K above the reference.
/// @param readings_K  (sensors + observed) with the sensors' own offsets, see Layout::observed
/// @param guide_K     (coolants) see OperatingModel::guide_K
Eigen::VectorXd chiller_set_points(const mesh::Machine& machine, const Layout& layout,
                                   const Eigen::VectorXd& readings_K, const Eigen::VectorXd& guide_K);

class Chiller {
public:
  /// @param start_K  (coolants) first outlet temperatures above the reference; compressors rest
  Chiller(const mesh::Machine& machine, const Layout& layout, const Channels& channels, Eigen::VectorXd start_K);

  /// Readings over a step: value + slope s + curve s^2, s in seconds from its start. Slope and curve
  /// may be empty: they stand.
  struct Readings {
    Eigen::VectorXd value, slope, curve;  ///< (sensors + observed) K, K/s, K/s^2
    Eigen::VectorXd guide, guide_slope;   ///< (coolants) ambients that guide
  };

  /// A step; compressors switch within it.
  /// @return inlets of the step: the outlet at its end; with two-point or pi control its mean
  const Eigen::VectorXd& advance(const Eigen::VectorXd& row, const Readings& readings, double step_s);
  const Eigen::VectorXd& advance(const Eigen::VectorXd& row, const Eigen::VectorXd& readings_K,
                                 const Eigen::VectorXd& guide_K, double step_s) {
    return advance(row, Readings{readings_K, {}, {}, guide_K, {}}, step_s);
  }
  const Eigen::VectorXd& outlet_K() const { return outlet_K_; }
  /// Whether an outlet depends on the return within the step, which then is iterated.
  bool follows_return() const;

  /// Outlets after a time in which no compressor switches.
  Eigen::VectorXd outlet_after(const Eigen::VectorXd& row, const Readings& readings, double s) const;
  /// How far each then is beyond the end of its band, K; < 0 within, or without a band.
  Eigen::VectorXd beyond_band(const Eigen::VectorXd& row, const Readings& readings, double s) const;
  /// Goes there. @param row  channels at that time
  void move(const Eigen::VectorXd& row, const Readings& readings, double s);
  void toggle(Eigen::Index coolant) { running_[coolant] ^= 1; }
  bool running(Eigen::Index coolant) const { return running_[coolant] != 0; }

  void save(core::BinaryWriter& out) const;
  void load(core::BinaryReader& in);

private:
  struct Circuit {
    int on, inlet;
    int guide, returns, warmed_by;  // places in readings, -1; guide -1: an ambient
    double warmed_share, offset, inlet_offset, time_constant;
    mesh::ChillerControl control;
    bool controls_return;
    double band, pull_down, drift_up, gain, integral_time, heat_flow, power;  // heat_flow: W/K at full flow
  };
  /// Outlet and integral of a circuit.
  struct Walk {
    double outlet, integral;
    bool running;
    double sum = 0;  // of the outlet over time
  };
  double set_point(std::size_t circuit, const Readings& readings, double s) const;
  double held(std::size_t circuit, const Readings& readings, double s, double outlet) const;
  double mean_over_step(std::size_t circuit, double set, double step_s);
  double slope(std::size_t circuit, const Eigen::VectorXd& row, const Readings& readings, double s, const Walk& walk,
               double& integral) const;
  void walk(std::size_t circuit, const Eigen::VectorXd& row, const Readings& readings, double span, bool switches,
            Walk& walk) const;
  bool exact(std::size_t circuit) const;

  std::vector<Circuit> circuits_;
  double reference_C_ = 0;
  Eigen::VectorXd outlet_K_, inlet_K_, integral_K_;
  std::vector<char> running_;
};

}  // namespace thermotwin::solver
