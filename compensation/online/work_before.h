// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What work before the start has left in a machine. Each cause l of heat (standing losses, spindle, axes,
// fluid, surroundings), of the size that a day's work has it, acted for t_on and ended t_idle ago:
//   x_l = V_off exp(-D_off t_idle) V_off^T E V_on (1 - exp(-D_on t_on)) / D_on V_on^T s_l,
// (V, D) modes and decays of the pencil (K, E) at work and switched off. All causes alike or one alone, each of
// several sizes and times since, are weighted by the evidence of the first readings z, Gaussian with
//   cov z = uniform^2 + size^2 H X X^T H^T + std^2 (of each reading, see reading_std).

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <vector>

#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

/// Standard deviation of the noise and model error of a mean reading, K. @param deviation_K  from the start
double reading_std(double uncertainty_K, double deviation_K);

/// A sensor's reading at the start minus the uniform temperature of the start, K.
struct FirstReading {
  Eigen::Index sensor = 0;
  double value = 0;
};

/// The temperature of a machine that has rested, to which work before adds, K above the reference.
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

  /// Where the axes stand at the start: to be told before all else. @param row  (channels)
  void ends_at(const Eigen::VectorXd& row);

  /// Logarithm of the probability density of first readings about a uniform temperature of this deviation.
  double log_evidence(double uniform_K, const std::vector<FirstReading>& readings) const {
    return weigh(uniform_K, readings).log_evidence;
  }
  /// Probability that a first reading is as far off as this one from what the others foretell of it.
  /// @param starts  that are possible  @param others, reading  values above the reference
  double chance(const std::vector<UniformStart>& starts, std::vector<FirstReading> others,
                const FirstReading& reading) const;
  /// Patterns of unit deviation for these readings, (order x patterns). @param readings  none: nothing is known
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
