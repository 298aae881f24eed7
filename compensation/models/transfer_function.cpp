// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/transfer_function.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <complex>

#include "core/missing.h"

namespace thermotwin::compensation {

using core::missing;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

/// What an input was before the record: as at its start, or at rest.
double before_start(const TransferSet& set, Index input, double first) {
  return set.info[input].activity ? 0.0 : first;
}

/// The filters of all inputs at one grid time after the other.
class Filters {
public:
  explicit Filters(const TransferSet& set)
      : set_(set),
        u_(set.b.rows(), set.order()),
        y_(set.b.rows(), set.order()),
        out_(set.b.rows()) {}

  void settle(const RowVectorXd& inputs) {
    for (Index i = 0; i < u_.rows(); ++i) {
      const double u = before_start(set_, i, inputs[i]) - set_.reference[i];
      u_.row(i).setConstant(u);
      y_.row(i).setConstant(set_.static_gain(i) * u);
    }
  }

  const RowVectorXd& step(const RowVectorXd& inputs) {
    const Index n = set_.order();
    for (Index i = 0; i < u_.rows(); ++i) {
      const double u = inputs[i] - set_.reference[i];
      double y = set_.b(i, 0) * u;
      for (Index j = 0; j < n; ++j) y += set_.b(i, j + 1) * u_(i, j) - set_.f(i, j) * y_(i, j);
      for (Index j = n - 1; j > 0; --j) {
        u_(i, j) = u_(i, j - 1);
        y_(i, j) = y_(i, j - 1);
      }
      if (n > 0) {
        u_(i, 0) = u;
        y_(i, 0) = y;
      }
      out_[i] = y;
    }
    return out_;
  }

private:
  const TransferSet& set_;
  MatrixXd u_, y_;
  RowVectorXd out_;
};

class GridPredictor final : public RowPredictor {
public:
  explicit GridPredictor(const TransferSet& set)
      : set_(set),
        filters_(set),
        sum_(RowVectorXd::Zero(set.b.rows())),
        count_(sum_),
        last_(RowVectorXd::Constant(set.b.rows(), missing)) {}

  double step(double time, const Eigen::Ref<const RowVectorXd>& inputs) override {
    if (!started_) {
      if (!inputs.allFinite()) return missing;
      start(time, inputs);
    } else {
      if (time - end_ > longest_gap * set_.step) {  // nothing is left of what was before
        close_bin();
        start(time, inputs.allFinite() ? RowVectorXd(inputs) : last_);
      }
      while (time > end_ + 1e-6 * set_.step) close_bin();
      add(inputs);
      if (time >= end_ - 1e-6 * set_.step) close_bin();
    }
    if (!inputs.allFinite()) return missing;
    // Ahead of the last bin's end by at most one step: at the rate of the last two outputs.
    const double ahead = (time - (end_ - set_.step)) / set_.step;
    return output_ + std::clamp(ahead, 0.0, 1.0) * (output_ - earlier_);
  }

private:
  static constexpr double longest_gap = 20000.0;

  void start(double time, const RowVectorXd& inputs) {
    last_ = inputs;
    filters_.settle(inputs);
    output_ = earlier_ = set_.constant + filters_.step(inputs).sum();
    end_ = time + set_.step;
    sum_.setZero();
    count_.setZero();
    started_ = true;
  }

  void add(const Eigen::Ref<const RowVectorXd>& inputs) {
    for (Index i = 0; i < inputs.size(); ++i) {
      if (!std::isfinite(inputs[i])) continue;
      sum_[i] += inputs[i];
      count_[i] += 1.0;
    }
  }

  void close_bin() {
    for (Index i = 0; i < sum_.size(); ++i) {
      if (count_[i] > 0.0) last_[i] = sum_[i] / count_[i];
    }
    sum_.setZero();
    count_.setZero();
    earlier_ = output_;
    output_ = set_.constant + filters_.step(last_).sum();
    end_ += set_.step;
  }

  const TransferSet& set_;
  Filters filters_;
  RowVectorXd sum_, count_, last_;
  double end_ = 0, output_ = 0, earlier_ = 0;
  bool started_ = false;
};

}  // namespace

double TransferSet::static_gain(Index input) const { return b.row(input).sum() / (1.0 + f.row(input).sum()); }

VectorXd TransferSet::step_response(Index input, Index samples) const {
  VectorXd response(samples);
  for (Index k = 0; k < samples; ++k) {
    double y = b(input, 0);
    for (Index j = 1; j <= order(); ++j)
      y += (k >= j ? b(input, j) : 0.0) - (k >= j ? f(input, j - 1) * response[k - j] : 0.0);
    response[k] = y;
  }
  return response;
}

double TransferSet::settling_time(Index input) const {
  const double radius = std::clamp(poles_of(f.row(input).transpose()).cwiseAbs().maxCoeff(), 1e-6, 1.0 - 1e-9);
  const auto samples = static_cast<Index>(std::clamp(-12.0 / std::log(radius), 10.0, 1e5));
  const VectorXd response = step_response(input, samples);
  const double end = static_gain(input);
  Index last = -1;
  for (Index k = 0; k < samples; ++k) {
    if (std::abs(response[k] - end) > 0.05 * std::abs(end)) last = k;
  }
  return (last + 1) * step;
}

double TransferSet::largest_pole(Index input) const {
  return order() == 0 ? 0.0 : poles_of(f.row(input).transpose()).cwiseAbs().maxCoeff();
}

double TransferSet::largest_pole() const {
  double largest = 0.0;
  for (Index i = 0; i < f.rows(); ++i) largest = std::max(largest, largest_pole(i));
  return largest;
}

Eigen::VectorXcd poles_of(const VectorXd& f) {
  const Index n = f.size();
  if (n == 1) return Eigen::VectorXcd::Constant(1, -f[0]);
  MatrixXd companion = MatrixXd::Zero(n, n);
  companion.row(0) = -f.transpose();
  for (Index i = 1; i < n; ++i) companion(i, i - 1) = 1.0;
  return Eigen::EigenSolver<MatrixXd>(companion, false).eigenvalues();
}

bool stabilise(VectorXd& f, double radius) {
  if (f.size() == 0) return false;
  Eigen::VectorXcd poles = poles_of(f);
  bool moved = false;
  for (std::complex<double>& pole : poles) {
    if (std::abs(pole) <= radius) continue;
    moved = true;
    if (std::abs(pole) > 1.0) pole = 1.0 / std::conj(pole);
    if (std::abs(pole) > radius) pole *= radius / std::abs(pole);
  }
  if (!moved) return false;
  Eigen::VectorXcd polynomial = Eigen::VectorXcd::Zero(f.size() + 1);
  polynomial[0] = 1.0;
  for (Index i = 0; i < poles.size(); ++i) {
    for (Index j = i + 1; j > 0; --j) polynomial[j] -= poles[i] * polynomial[j - 1];
  }
  f = polynomial.tail(f.size()).real();
  return true;
}

Grid make_grid(const TrainingData& data, double step) {
  const Index n = data.time.size();
  const auto samples = static_cast<Index>(std::floor((data.time[n - 1] - data.time[0]) / step + 1e-6)) + 1;
  Grid grid{step, MatrixXd::Constant(samples, data.inputs.cols(), missing), VectorXd::Constant(samples, missing)};
  MatrixXd count = MatrixXd::Zero(samples, data.inputs.cols());
  VectorXd target_count = VectorXd::Zero(samples);
  for (Index i = 0; i < n; ++i) {
    const auto k = static_cast<Index>(std::ceil((data.time[i] - data.time[0]) / step - 1e-6));
    if (k >= samples) break;
    for (Index j = 0; j < data.inputs.cols(); ++j) {
      if (!std::isfinite(data.inputs(i, j))) continue;
      grid.inputs(k, j) = (count(k, j) > 0.0 ? grid.inputs(k, j) : 0.0) + data.inputs(i, j);
      count(k, j) += 1.0;
    }
    if (std::isfinite(data.target[i])) {
      grid.target[k] = (target_count[k] > 0.0 ? grid.target[k] : 0.0) + data.target[i];
      target_count[k] += 1.0;
    }
  }
  for (Index k = 0; k < samples; ++k) {
    if (target_count[k] > 0.0) grid.target[k] /= target_count[k];
    for (Index j = 0; j < data.inputs.cols(); ++j) {
      if (count(k, j) > 0.0)
        grid.inputs(k, j) /= count(k, j);
      else if (k > 0)
        grid.inputs(k, j) = grid.inputs(k - 1, j);  // as the predictor does
    }
  }
  // Before an input's first reading: as it then is found.
  for (Index j = 0; j < data.inputs.cols(); ++j) {
    const Index first = known_range(grid.inputs.col(j)).first;
    for (Index k = 0; k < first; ++k) grid.inputs(k, j) = grid.inputs(first, j);
  }
  return grid;
}

MatrixXd simulate(const TransferSet& set, const MatrixXd& inputs) {
  Filters filters(set);
  MatrixXd contributions(inputs.rows(), inputs.cols());
  if (inputs.rows() == 0) return contributions;
  filters.settle(inputs.row(0));
  for (Index k = 0; k < inputs.rows(); ++k) contributions.row(k) = filters.step(inputs.row(k));
  return contributions;
}

std::unique_ptr<RowPredictor> make_predictor(const TransferSet& set) { return std::make_unique<GridPredictor>(set); }

}  // namespace thermotwin::compensation
