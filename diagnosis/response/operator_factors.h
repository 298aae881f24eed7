// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Factors of the operators of steps on a reduced model, kept for the next steps.

#include <Eigen/Core>
#include <Eigen/LU>

#include <list>

#include "reduction/model/reduced_model.h"

namespace thermotwin::diagnosis {

/// The last few operators E + gamma h A. Products with an inverse are faster than solves, once it is
/// used for as many columns as it has.
class OperatorFactors {
public:
  OperatorFactors(const reduction::ReducedSystem& system, const Eigen::MatrixXd& capacity)
      : system_(system),
        capacity_(capacity) {}

  struct Entry {
    Eigen::VectorXd p;
    double step = 0;
    Eigen::PartialPivLU<Eigen::MatrixXd> lu;
    Eigen::MatrixXd inverse;
    Eigen::Index solved = 0;  ///< columns so far

    template <class Columns>
    Eigen::MatrixXd solve(const Columns& columns) const {
      return inverse.size() > 0 ? Eigen::MatrixXd(inverse * columns) : Eigen::MatrixXd(lu.solve(columns));
    }
  };
  /// @param columns  that will be solved for
  const Entry& get(const Eigen::VectorXd& p, double step, Eigen::Index columns);

private:
  /// K0 + sum p K. From step to step few coefficients change; reading all terms would take longer than a factor.
  const Eigen::MatrixXd& conduction(const Eigen::VectorXd& p);

  const reduction::ReducedSystem& system_;
  const Eigen::MatrixXd& capacity_;
  std::list<Entry> kept_;
  Eigen::MatrixXd sum_;
  Eigen::VectorXd sum_p_;
  int changes_ = 0;
};

}  // namespace thermotwin::diagnosis
