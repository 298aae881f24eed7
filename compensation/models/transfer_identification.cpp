// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/transfer_identification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "compensation/models/least_squares.h"
#include "core/error.h"
#include "core/minimum_norm.h"
#include "core/missing.h"

namespace thermotwin::compensation {

using core::missing;
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int thirds = 3;
constexpr double settled_share = 1.3;  ///< of the free fit's RMS: the record starts at rest

/// past(k, j) = values(k - j); before the record as at its start.
double past(const VectorXd& values, Index k, Index j) { return values[std::max<Index>(k - j, 0)]; }
/// The same with nothing before the record.
double past_or_nought(const VectorXd& values, Index k, Index j) { return k >= j ? values[k - j] : 0.0; }

/// y + f1 y(-1) + ... = u, before the record settled or at nought
VectorXd filtered_by_poles(const VectorXd& u, const VectorXd& f, bool settled = true) {
  VectorXd y(u.size());
  const double start = settled && u.size() > 0 ? u[0] / (1.0 + f.sum()) : 0.0;
  for (Index k = 0; k < u.size(); ++k) {
    y[k] = u[k];
    for (Index j = 1; j <= f.size(); ++j) y[k] -= f[j - 1] * (k >= j ? y[k - j] : start);
  }
  return y;
}

class Identification {
public:
  Identification(const Grid& grid, std::vector<InputInfo> info, const VectorXd& target,
                 const TransferStructure& structure, double radius, const std::string& label)
      : grid_(grid),
        target_(target),
        order_(structure.order),
        starts_(structure.settled ? 0 : structure.order),
        radius_(radius),
        label_(label) {
    set_.step = grid.step;
    set_.info = std::move(info);
    const Index inputs = grid.inputs.cols();
    set_.reference = grid.inputs.colwise().mean().transpose();
    set_.b = MatrixXd::Zero(inputs, order_ + 1);
    set_.f = MatrixXd::Zero(inputs, order_);
    start_ = MatrixXd::Zero(inputs, starts_);
  }

  TransferSet run(TransferMethod method) {
    least_squares_fit(method == TransferMethod::armax ? order_ : 0);
    if (method == TransferMethod::output_error) simulate_fit();
    return set_;
  }
  /// Sum of squares of what the output error fit leaves.
  double left() const { return left_; }

private:
  Index inputs() const { return grid_.inputs.cols(); }

  /// y(k) = -sum a y(k-j) + sum b u(k-j) + sum c e(k-j) + constant
  void least_squares_fit(Index noise) {
    std::vector<Index> rows;
    for (Index k = order_; k < target_.size(); ++k) {
      if (target_.segment(k - order_, order_ + 1).allFinite()) rows.push_back(k);
    }
    const Index unknowns = order_ + inputs() * (order_ + 1) + noise + 1;
    if (std::ssize(rows) < 2 * unknowns) {
      throw InputError(label_, fmt::format("{} samples without gap for {} parameters", rows.size(), unknowns),
                       "at least twice as many");
    }
    VectorXd innovation = VectorXd::Zero(target_.size());
    VectorXd a = VectorXd::Zero(order_);
    MatrixXd b = set_.b;
    double constant = 0.0, least = std::numeric_limits<double>::infinity();
    const int passes = noise > 0 ? 12 : 1;
    for (int pass = 0; pass < passes; ++pass) {
      const Index noise_terms = pass == 0 ? 0 : noise;  // the first pass has no innovations yet
      MatrixXd x(std::ssize(rows), unknowns - noise + noise_terms);
      VectorXd z(x.rows());
      for (Index r = 0; r < x.rows(); ++r) {
        const Index k = rows[r];
        Index column = 0;
        for (Index j = 1; j <= order_; ++j) x(r, column++) = -target_[k - j];
        for (Index i = 0; i < inputs(); ++i) {
          for (Index j = 0; j <= order_; ++j) x(r, column++) = grid_.inputs(k - j, i) - set_.reference[i];
        }
        x(r, column++) = 1.0;
        for (Index j = 1; j <= noise_terms; ++j) x(r, column++) = past(innovation, k, j);
        z[r] = target_[k];
      }
      const VectorXd found = core::minimum_norm_solution(x, z);
      const VectorXd residual = z - x * found;
      innovation.setZero();
      for (Index r = 0; r < x.rows(); ++r) innovation[rows[r]] = residual[r];
      if (!found.allFinite() || (pass > 1 && residual.squaredNorm() > least * (1.0 - 1e-6))) break;
      least = residual.squaredNorm();
      a = found.head(order_);
      for (Index i = 0; i < inputs(); ++i) b.row(i) = found.segment(order_ + i * (order_ + 1), order_ + 1).transpose();
      constant = found[order_ + inputs() * (order_ + 1)];
    }
    VectorXd stable = a;
    const bool moved = stabilise(stable, radius_);
    set_.f = stable.transpose().replicate(inputs(), 1);
    set_.b = b;
    set_.constant = constant / (1.0 + stable.sum());
    if (moved) refit_numerators();
  }

  /// How a machine that does not start settled comes to rest: 1/F of an impulse at the start.
  VectorXd free_motion(const VectorXd& f) const {
    VectorXd impulse = VectorXd::Zero(target_.size());
    impulse[0] = 1.0;
    return filtered_by_poles(impulse, f, false);
  }

  /// Numerators and constant on the simulated output, poles (the same for all inputs) as they are.
  void refit_numerators() {
    const Index n = order_ + 1;
    MatrixXd x(target_.size(), inputs() * n + starts_);
    const VectorXd rest = free_motion(set_.f.row(0).transpose());
    for (Index j = 0; j < starts_; ++j) {
      for (Index k = 0; k < x.rows(); ++k) x(k, inputs() * n + j) = past_or_nought(rest, k, j);
    }
    for (Index i = 0; i < inputs(); ++i) {
      const VectorXd filtered =
          filtered_by_poles(grid_.inputs.col(i).array() - set_.reference[i], set_.f.row(i).transpose());
      for (Index j = 0; j < n; ++j) {
        for (Index k = 0; k < x.rows(); ++k) x(k, i * n + j) = past(filtered, k, j);
      }
    }
    const Line line = fit_ridge(x, target_, 1e-8, label_);
    start_.setZero();
    if (starts_ > 0) start_.row(0) = line.gains.tail(starts_).transpose();
    for (Index i = 0; i < inputs(); ++i) set_.b.row(i) = line.gains.segment(i * n, n).transpose();
    set_.constant = line.intercept;
  }

  /// Parameters of an input: numerator, denominator, start.
  Index width() const { return 2 * order_ + 1 + starts_; }

  VectorXd packed() const {
    VectorXd x(inputs() * width() + 1);
    for (Index i = 0; i < inputs(); ++i) {
      x.segment(i * width(), width()) << set_.b.row(i).transpose(), set_.f.row(i).transpose(),
          start_.row(i).transpose();
    }
    x[x.size() - 1] = set_.constant;
    return x;
  }

  void unpack(const VectorXd& x) {
    for (Index i = 0; i < inputs(); ++i) {
      set_.b.row(i) = x.segment(i * width(), order_ + 1).transpose();
      set_.f.row(i) = x.segment(i * width() + order_ + 1, order_).transpose();
      start_.row(i) = x.segment(i * width() + 2 * order_ + 1, starts_).transpose();
    }
    set_.constant = x[x.size() - 1];
  }

  /// Gradient search on the simulated output from several first poles. A start's free motion is
  /// part of the fit only: a prediction starts settled.
  void simulate_fit() {
    std::vector<Index> rows;
    for (Index k = 0; k < target_.size(); ++k) {
      if (std::isfinite(target_[k])) rows.push_back(k);
    }
    SquaresProblem problem;
    problem.residuals = [&](const VectorXd& x, MatrixXd* jacobian) {
      unpack(x);
      const MatrixXd contributions = simulate(set_, grid_.inputs);
      VectorXd residual = ((contributions.rowwise().sum() - target_).array() + set_.constant).matrix();
      if (jacobian) jacobian->resize(std::ssize(rows), x.size());
      for (Index i = 0; i < inputs(); ++i) {
        const VectorXd f = set_.f.row(i).transpose(), rest = free_motion(f);
        VectorXd free = VectorXd::Zero(rest.size());
        for (Index j = 0; j < starts_; ++j) {
          for (Index k = j; k < free.size(); ++k) free[k] += start_(i, j) * rest[k - j];
        }
        residual += free;
        if (!jacobian) continue;
        const VectorXd du = filtered_by_poles(grid_.inputs.col(i).array() - set_.reference[i], f);
        const VectorXd dy = filtered_by_poles(contributions.col(i), f), dfree = filtered_by_poles(free, f, false);
        for (std::size_t r = 0; r < rows.size(); ++r) {
          const Index k = rows[r], first = i * width();
          const Index row = r;
          for (Index j = 0; j <= order_; ++j) (*jacobian)(row, first + j) = past(du, k, j);
          for (Index j = 1; j <= order_; ++j)
            (*jacobian)(row, first + order_ + j) = -past(dy, k, j) - past_or_nought(dfree, k, j);
          for (Index j = 0; j < starts_; ++j) (*jacobian)(row, first + 2 * order_ + 1 + j) = past_or_nought(rest, k, j);
        }
      }
      if (jacobian) jacobian->rightCols(1).setOnes();
      return VectorXd(residual(rows));
    };
    problem.admit = [&](VectorXd& x) {
      for (Index i = 0; i < inputs(); ++i) {
        VectorXd f = x.segment(i * width() + order_ + 1, order_);
        if (f.allFinite() && stabilise(f, radius_)) x.segment(i * width() + order_ + 1, order_) = f;
      }
    };
    std::vector<VectorXd> starts{packed()};  // ARX's poles
    const double samples = target_.size();
    for (const double share : {0.02, 0.1}) {
      // Real poles, the further ones faster: z - e^(-1/(share samples 4^-j))
      VectorXd f = VectorXd::Zero(order_ + 1);
      f[0] = 1.0;
      for (Index j = 0; j < order_; ++j) {
        const double pole = std::exp(-std::pow(4.0, j) / (share * samples));
        for (Index m = order_; m > 0; --m) f[m] -= std::min(pole, radius_) * f[m - 1];
      }
      set_.f = f.tail(order_).transpose().replicate(inputs(), 1);
      refit_numerators();
      starts.push_back(packed());
    }
    Minimum best;
    best.value = std::numeric_limits<double>::infinity();
    for (const VectorXd& start : starts) {
      const Minimum found = least_squares_search(problem, start, 40);
      if (found.value < best.value) best = found;
    }
    if (!std::isfinite(best.value))
      throw InputError(label_, "no finite output error", "inputs and displacements of usual size");
    unpack(best.at);
    left_ = best.value;
  }

  const Grid& grid_;
  const VectorXd& target_;
  Index order_, starts_;
  double radius_;
  const std::string& label_;
  TransferSet set_;
  MatrixXd start_;  ///< (inputs x starts) numerators of the free motion
  double left_ = 0;
};

}  // namespace

double held_out_error(const Grid& grid, const std::vector<InputInfo>& info, TransferMethod method,
                      const TransferStructure& structure, double radius, const std::string& label) {
  std::vector<Index> known;
  for (Index k = 0; k < grid.target.size(); ++k) {
    if (std::isfinite(grid.target[k])) known.push_back(k);
  }
  const std::size_t n = known.size();
  double squares = 0.0;
  for (std::size_t fold = 0; fold < thirds; ++fold) {
    VectorXd target = grid.target;
    for (std::size_t i = fold * n / thirds; i < (fold + 1) * n / thirds; ++i) target[known[i]] = missing;
    const TransferSet set = Identification(grid, info, target, structure, radius, label).run(method);
    const VectorXd output = simulate(set, grid.inputs).rowwise().sum().array() + set.constant;
    for (std::size_t i = fold * n / thirds; i < (fold + 1) * n / thirds; ++i)
      squares += std::pow(output[known[i]] - grid.target[known[i]], 2);
  }
  return std::isfinite(squares) ? squares / n : std::numeric_limits<double>::infinity();
}

std::pair<TransferStructure, TransferSet> fit_transfer(const Grid& grid, const std::vector<InputInfo>& info,
                                                       Index order, double radius, const std::string& label,
                                                       TransferMethod method) {
  Identification free(grid, info, grid.target, {order, false}, radius, label);
  TransferSet set = free.run(method);
  if (method != TransferMethod::output_error) return {{order, false}, std::move(set)};
  Identification settled(grid, info, grid.target, {order, true}, radius, label);
  TransferSet from_rest = settled.run(method);
  const bool rests = settled.left() <= settled_share * settled_share * free.left();
  return {{order, rests}, std::move(rests ? from_rest : set)};
}

}  // namespace thermotwin::compensation
