// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/data_models.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

void check_shapes(const VectorXd& time, const MatrixXd& inputs, const std::string& model) {
  if (inputs.rows() != time.size() || inputs.cols() == 0) {
    throw InputError(model, fmt::format("{} x {} temperatures for {} times", inputs.rows(), inputs.cols(), time.size()),
                     "at least one temperature, a row for each time");
  }
}

/// target = intercept + inputs * gains by least squares; the smallest gains where inputs depend on
/// each other (a constant temperature says nothing beside the intercept).
struct Line {
  VectorXd gains;
  double intercept = 0.0, squares = 0.0;
  Index rows = 0;
};

Line fit_line(const MatrixXd& inputs, const VectorXd& target, const std::string& model) {
  std::vector<Index> good;
  for (Index i = 0; i < target.size(); ++i) {
    if (std::isfinite(target[i]) && inputs.row(i).allFinite()) good.push_back(i);
  }
  const Index n = static_cast<Index>(good.size()), k = inputs.cols();
  if (n < k + 2) {
    throw InputError(model, fmt::format("{} complete rows to fit {} parameters", n, k + 1), "more rows than parameters");
  }
  const MatrixXd x = inputs(good, Eigen::all);
  const VectorXd z = target(good);
  const Eigen::RowVectorXd mean = x.colwise().mean();
  const MatrixXd centred = x.rowwise() - mean;
  Line line;
  line.rows = n;
  line.gains = centred.completeOrthogonalDecomposition().solve((z.array() - z.mean()).matrix());
  line.intercept = z.mean() - mean.dot(line.gains);
  line.squares = (z - x * line.gains - VectorXd::Constant(n, line.intercept)).squaredNorm();
  return line;
}

std::string gains_in_words(const VectorXd& gains) {
  std::string text;
  for (Index i = 0; i < gains.size(); ++i) text += fmt::format("{}{:.4g}", i == 0 ? "" : ", ", gains[i]);
  return text;
}

class StaticRegression final : public DataModel {
 public:
  std::string name() const override { return "static_regression"; }

  void fit(const VectorXd& time, const MatrixXd& inputs, const VectorXd& target) override {
    check_shapes(time, inputs, name());
    line_ = fit_line(inputs, target, name());
  }

  VectorXd predict(const VectorXd& time, const MatrixXd& inputs) const override {
    check_shapes(time, inputs, name());
    return (inputs * line_.gains).array() + line_.intercept;  // NaN where a temperature is missing
  }

  std::string explain() const override {
    return fmt::format("gains {} per K, intercept {:.4g}, {} rows", gains_in_words(line_.gains), line_.intercept, line_.rows);
  }

 private:
  Line line_;
};

/// tau y' + y = u from y = u at the first reading, exact for u that is linear between its readings.
VectorXd lagged(const VectorXd& time, const Eigen::Ref<const VectorXd>& input, double tau) {
  VectorXd output = VectorXd::Constant(input.size(), missing);
  Index last = -1;
  double y = 0.0;
  for (Index i = 0; i < input.size(); ++i) {
    if (!std::isfinite(input[i])) continue;  // a gap is bridged by a straight line
    if (last < 0) {
      y = input[i];
    } else {
      const double h = time[i] - time[last], slope = (input[i] - input[last]) / h;
      const double x = h / tau, decay = std::exp(-x);
      // y = u - slope tau + (y0 - u0 + slope tau) e^-x, in a form that does not cancel for small x.
      y = input[i] - slope * tau * -std::expm1(-x) + (y - input[last]) * decay;
    }
    output[i] = y;
    last = i;
  }
  return output;
}

MatrixXd lagged_columns(const VectorXd& time, const MatrixXd& inputs, double tau) {
  MatrixXd outputs(inputs.rows(), inputs.cols());
  for (Index k = 0; k < inputs.cols(); ++k) outputs.col(k) = lagged(time, inputs.col(k), tau);
  return outputs;
}

class FirstOrder final : public DataModel {
 public:
  std::string name() const override { return "first_order"; }

  void fit(const VectorXd& time, const MatrixXd& inputs, const VectorXd& target) override {
    check_shapes(time, inputs, name());
    const double span = time.size() > 1 ? time[time.size() - 1] - time[0] : 0.0;
    if (!(span > 0.0)) throw InputError(name(), fmt::format("a record of {} s", span), "a record with a duration");
    // A lag below half the mean interval cannot be told from none. One beyond a third of the record
    // has not run off in it (95 % take three time constants) and cannot be told from a ramp.
    const double shortest = std::log(0.5 * span / static_cast<double>(time.size() - 1)), longest = std::log(span / 3.0);
    const auto squares = [&](double log_tau) {
      return fit_line(lagged_columns(time, inputs, std::exp(log_tau)), target, name()).squares;
    };
    constexpr int points = 48;
    const double step = (longest - shortest) / (points - 1);
    int best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < points; ++i) {
      const double value = squares(shortest + i * step);
      if (value < least) {
        least = value;
        best = i;
      }
    }
    tau_ = std::exp(golden(squares, shortest + std::max(best - 1, 0) * step, shortest + std::min(best + 1, points - 1) * step));
    at_bound_ = best == 0 || best == points - 1;
    line_ = fit_line(lagged_columns(time, inputs, tau_), target, name());
  }

  VectorXd predict(const VectorXd& time, const MatrixXd& inputs) const override {
    check_shapes(time, inputs, name());
    return (lagged_columns(time, inputs, tau_) * line_.gains).array() + line_.intercept;
  }

  std::string explain() const override {
    return fmt::format("tau {:.4g} s{}, gains {} per K, intercept {:.4g}, {} rows", tau_,
                       at_bound_ ? " (at the bound of the search: the record does not show it)" : "",
                       gains_in_words(line_.gains), line_.intercept, line_.rows);
  }

 private:
  template <class Function>
  static double golden(const Function& function, double low, double high) {
    constexpr double ratio = 0.6180339887498949;
    double a = high - ratio * (high - low), b = low + ratio * (high - low);
    double at_a = function(a), at_b = function(b);
    while (high - low > 1e-6) {
      if (at_a <= at_b) {
        high = b;
        b = a;
        at_b = at_a;
        a = high - ratio * (high - low);
        at_a = function(a);
      } else {
        low = a;
        a = b;
        at_a = at_b;
        b = low + ratio * (high - low);
        at_b = function(b);
      }
    }
    return 0.5 * (low + high);
  }

  double tau_ = 1.0;
  bool at_bound_ = false;
  Line line_;
};

}  // namespace

std::unique_ptr<DataModel> make_static_regression() { return std::make_unique<StaticRegression>(); }
std::unique_ptr<DataModel> make_first_order() { return std::make_unique<FirstOrder>(); }

}  // namespace thermotwin::compensation
