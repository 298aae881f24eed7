// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The detectability of the observer's disturbance states with the given sensors. With disturbances d (powers, films,
// contacts, surroundings) and sensor offsets b as constants beside the thermal state,
//   E dx/dt = -A x + G d,  dd/dt = 0,  db/dt = 0,  z = H x + b,
// the Popov-Belevitch-Hautus test requires full column rank of [lambda - M; C] for every eigenvalue with Re lambda >=
// 0. A machine whose parts all have a path for their heat has no such eigenvalue but the zeros of d and b. There the
// test is the column rank of [H A^-1 G, 1], the stationary effect of each disturbance on the readings. So at one
// constant operating point at most as many disturbances are detectable as there are sensors.
//
// Each disturbance is scaled to its prior and the readings to their standard deviations. The states are then chosen one
// by one, the largest effect first. A state is not detectable if its effect, beyond the span of those before it, is
// below one standard deviation; the state with the most similar effect is named. The filter keeps such a state with its
// prior, and std_um includes its uncertainty. Varying loads identify more states: the standard deviation after the run
// follows from the observability Gramian of that run, weighted by the priors.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/online/error_model.h"

namespace thermotwin::compensation {

struct AugmentedState {
  ErrorModel::State state;
  double reach = 0;   ///< change of the stationary readings per prior standard deviation, in their deviations
  double beyond = 0;  ///< the part of it outside the span of the states before
  bool detectable = false;
  std::string like;  ///< if not: the detectable state with the most similar effect
};

struct Detectability {
  double slowest_s = 0;  ///< slowest thermal time constant at the operating point; infinite: a part does not decay
  Eigen::Index sensors = 0, detectable = 0;
  double margin = 0;  ///< smallest singular value of the static gain of the detectable states, deviations
  std::vector<AugmentedState> states;  ///< detectable ones first, in order of their effect
  std::string brief() const;
};

/// @param operator_matrix  A (r x r)  @param rates  G (r x disturbances)
/// @param sensors          H (sensors x r)
/// @param states           of the disturbances, then the offset of each sensor
/// @param reading_std      (sensors) K; NaN for a sensor without readings
Detectability detectability(const Eigen::MatrixXd& capacity, const Eigen::MatrixXd& operator_matrix,
                            const Eigen::MatrixXd& rates, const Eigen::MatrixXd& sensors,
                            const std::vector<ErrorModel::State>& states, const Eigen::VectorXd& reading_std);

}  // namespace thermotwin::compensation
