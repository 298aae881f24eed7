// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Drift still to come in a series of equal parts (workpieces). Over the period T of a part the reduced model obeys
//   E (x(t + T) - x(t)) / T = mean(inputs q - K(p) x),
// and the left side is zero in an endless series. With the mean state m of the period, the right side is taken to be
//   f(m) + rest,  f(m) = inputs q(m) - K(p(m)) m,
// with f at the mean row of the period and a constant rest. In f, p and q follow temperatures by laws and by the set
// points of chillers. Newton's method finds the mean state of the endless series.

#include <Eigen/Core>

#include <optional>

#include "reduction/model/reduced_model.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::nc {

class CycleDrift {
public:
  /// @param model  must outlive this
  explicit CycleDrift(const reduction::ReducedModel& model);

  /// A row of the program. @param row  (channels) NaN: the default  @param before, after  (order) states at its ends
  void row(double duration, const Eigen::VectorXd& row, const Eigen::VectorXd& before, const Eigen::VectorXd& after);
  /// A period begins within the last row. @param share  of the row
  void begin_period(double share);
  /// (order) change of the mean state from the last whole period to the last one of an endless series; none before two
  /// periods have begun, and where the model has no steady state
  std::optional<Eigen::VectorXd> ahead() const;

private:
  /// Integrals over time up to a moment.
  struct Sums {
    double time = 0;
    Eigen::VectorXd row, p, state;
    void add(double seconds, const Sums& rates);
  };
  struct Mark {
    Sums sums;
    Eigen::VectorXd state;
  };
  struct Balance;

  const reduction::ReducedModel& model_;
  solver::OperatingModel operating_;
  Eigen::VectorXd defaults_;
  Sums sums_, rates_;    ///< up to the last row; of it
  double duration_ = 0;  ///< s, of the last row
  Eigen::VectorXd before_, after_;
  std::optional<Mark> last_, first_;
};

}  // namespace thermotwin::nc
