// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Models the heat that earlier work has left in a machine at the start. Each heat source l (standing losses, spindle,
// axes, fluid, surroundings), of the size of a day's work, acted for t_on and ended t_idle ago:
//   x_l = V_off exp(-D_off t_idle) V_off^T E V_on (1 - exp(-D_on t_on)) / D_on V_on^T s_l,
// with (V, D) the modes and decay rates of the pencil (K, E) at work and switched off. Combinations (all sources alike,
// or one alone) of several sizes and idle times are weighted by the evidence of the first readings z, Gaussian with
//   cov z = uniform^2 + size^2 H X X^T H^T + std^2 (of each reading, see reading_std).

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <vector>

#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

/// @return the standard deviation of noise and model error of a mean reading, K  @param deviation_K  from the start
double reading_std(double uncertainty_K, double deviation_K);

/// A sensor's reading at the start minus the uniform initial temperature, K.
struct FirstReading {
  Eigen::Index sensor = 0;
  double value = 0;
};

/// The uniform temperature of a rested machine, to which earlier work adds, K above the reference.
struct UniformStart {
  double middle, std;
};

class WorkBefore {
public:
  /// Inputs that an ambient's temperature acts by.
  struct Ambient {
    int ambient;
    std::vector<int> inputs;
  };
  /// @param model  must outlive it
  WorkBefore(const reduction::ReducedModel& model, std::vector<Ambient> ambients);

  /// States the initial positions of the axes; to be called first. @param row  (channels)
  void ends_at(const Eigen::VectorXd& row);

  /// @return the log probability density of first readings, with this standard deviation of the uniform temperature
  double log_evidence(double uniform_K, const std::vector<FirstReading>& readings) const {
    return weigh(uniform_K, readings).log_evidence;
  }
  /// @return the probability of a first reading at least as far from the prediction by the others as this one
  /// @param starts  possible initial temperatures  @param others, reading  values above the reference
  double chance(const std::vector<UniformStart>& starts, std::vector<FirstReading> others,
                const FirstReading& reading) const;
  /// @return state patterns of unit standard deviation, (order x patterns)  @param readings  none: nothing is known
  Eigen::MatrixXd patterns(double uniform_K, const std::vector<FirstReading>& readings) const;

private:
  struct Weighed {
    Eigen::MatrixXd sizes;  ///< (heats x times since it ended) root mean squares
    double log_evidence;    ///< of the readings, all together
  };
  Weighed weigh(double uniform_K, const std::vector<FirstReading>& readings) const;
  Weighed unmeasured() const;
  /// Calls visit(idle, heat or -1, size, log_prior, covariance of the readings) for each of them.
  template <class Visit>
  void each(const Eigen::MatrixXd& rest, const Eigen::MatrixXd& rows, const Visit& visit) const;
  Eigen::MatrixXd covariance(double uniform_K, const std::vector<FirstReading>& readings) const;
  Eigen::MatrixXd rows_of(const std::vector<FirstReading>& readings) const;

  const reduction::ReducedModel& model_;
  std::vector<Ambient> ambients_;
  std::vector<Eigen::MatrixXd> left_;  ///< for each time since: (order x heats, kinds and hours of work)
};

}  // namespace thermotwin::compensation
