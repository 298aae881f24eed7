// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The steady state of an operating state: the temperature T that a machine tends to while its channels stand,
//   (K0 + sum p K) T = S q(u),   of each chiller one of
//   u = set point (T),   return (T) = set point (T),   u = return (T) - limit of its cooling,
// with the inlets u of the coolants. T is affine in u, so one factorisation serves the machine and its chillers
// together, whatever the guide of a chiller. Where p follows the temperature, or materials and radiation do, solutions
// are repeated until T stands. A compressor that switches has no steady state: its set point stands for the mean over
// its cycle. Factors are direct ones, whatever solver the system has been given.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "solver/operation/load_program.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/local_terms.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

struct SteadyState {
  Eigen::VectorXd temperature;  ///< (size) K above the reference
  Eigen::VectorXd sensors_K;    ///< (sensors) readings above the reference, with the sensors' own offsets
  Eigen::VectorXd inlet_K;      ///< (coolants) inlets above the reference
  Coefficients coefficients;    ///< of the last solution
  LocalTerms::Change local;     ///< of the last solution; empty: nothing depends on temperature from place to place
  int passes = 0;               ///< solutions
  std::vector<int> switching;   ///< coolants whose compressors would switch
  std::vector<int> at_limit;    ///< coolants whose chiller cools as much, or as little, as it can
};

/// @param row  (channels) the operating state; not_given where the model supplies the value itself
/// @throws SolverError: a body without a path to any ambient; no state that stands
SteadyState steady_state(const ThermalSystem& thermal, const OperatingModel& model, const Eigen::VectorXd& row);

/// The end of a phase of a load program, as an operating state.
struct SteadyPhase {
  std::string name;
  double start = 0, end = 0;  ///< s
  Eigen::VectorXd row;        ///< (channels) at its end: values that it ramps to
};
/// The phases in order; one that a coolant's after-run divides counts as two.
std::vector<SteadyPhase> steady_phases(const LoadProgram& program);

}  // namespace thermotwin::solver
