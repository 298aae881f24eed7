// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/operator_factors.h"

#include <algorithm>

#include "solver/thermal/integrator.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t kept_factors = 6;  ///< programs alternate between a few states
constexpr int most_changes = 100;        ///< of a sum of matrices, until rounding is taken out

}  // namespace

const OperatorFactors::Entry& OperatorFactors::get(const VectorXd& p, double step, Index columns) {
  auto at =
      std::find_if(kept_.begin(), kept_.end(), [&](const Entry& entry) { return entry.step == step && entry.p == p; });
  if (at != kept_.end()) {
    kept_.splice(kept_.begin(), kept_, at);
  } else {
    if (kept_.size() >= kept_factors) kept_.pop_back();
    Entry& entry = kept_.emplace_front();
    entry.p = p;
    entry.step = step;
    entry.lu.compute(capacity_ + solver::sdirk_gamma * step * conduction(p));
  }
  Entry& entry = kept_.front();
  entry.solved += columns;
  if (entry.inverse.size() == 0 && entry.solved > system_.order()) entry.inverse = entry.lu.inverse();
  return entry;
}

const MatrixXd& OperatorFactors::conduction(const VectorXd& p) {
  const bool anew = sum_.size() == 0 || ++changes_ > most_changes;
  if (anew) {
    sum_ = system_.conduction;
    sum_p_ = VectorXd::Zero(p.size());
    changes_ = 0;
  }
  for (Index j = 0; j < p.size(); ++j)
    if (p[j] != sum_p_[j]) sum_ += (p[j] - sum_p_[j]) * system_.terms[j];
  sum_p_ = p;
  return sum_;
}

}  // namespace thermotwin::diagnosis
