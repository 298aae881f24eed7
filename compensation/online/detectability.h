// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Which of the observer's augmented states its sensors can tell. With disturbances d (powers, films,
// contacts, surroundings) and sensor offsets b as constants beside the thermal state,
//   E dx/dt = -A x + G d,  dd/dt = 0,  db/dt = 0,  z = H x + b,
// the test of Popov, Belevitch and Hautus asks that [lambda - M; C] has full column rank for every
// eigenvalue with Re lambda >= 0. A machine that gives its heat to anything has none but the zeros of d
// and b, and there the test is the column rank of [H A^-1 G, 1]: what each moves the standing readings
// by. So at one standing operating point no more of them are detectable than there are sensors. Each is
// scaled to its prior and the readings to their deviations, and the states are taken one by one, the most
// telling first; one that moves the readings by less than one deviation beyond what those before it can
// imitate is not detectable, and the one that it is taken for is named. The filter keeps such a state
// with its prior: it fades, is hardly moved by readings, and its uncertainty stays in std_um. Where
// loads change, more can be told: the standard deviation after the run is the observability Gramian of
// that run, weighted by the priors.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/online/error_model.h"

namespace thermotwin::compensation {

struct AugmentedState {
  ErrorModel::State state;
  double reach = 0;   ///< standing readings move by so many deviations for one prior deviation
  double beyond = 0;  ///< of which no state before it can imitate
  bool detectable = false;
  std::string like;  ///< where not: the detectable state whose effect is nearest
};

struct Detectability {
  double slowest_s = 0;  ///< slowest thermal time constant at the operating point; infinite: none
  Eigen::Index sensors = 0, detectable = 0;
  double margin = 0;                   ///< smallest singular value of the detectable ones' static gain, deviations
  std::vector<AugmentedState> states;  ///< detectable ones first, the most telling first
  std::string brief() const;
};

/// @param operator_matrix  A (r x r)  @param rates  G (r x disturbances)
/// @param sensors          H (sensors x r)
/// @param states           of the disturbances, then the offset of each sensor
/// @param reading_std      (sensors) K; NaN where a sensor gives nothing
Detectability detectability(const Eigen::MatrixXd& capacity, const Eigen::MatrixXd& operator_matrix,
                            const Eigen::MatrixXd& rates, const Eigen::MatrixXd& sensors,
                            const std::vector<ErrorModel::State>& states, const Eigen::VectorXd& reading_std);

}  // namespace thermotwin::compensation
