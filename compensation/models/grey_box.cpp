// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/grey_box.h"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "compensation/measurement/stretch.h"
#include "compensation/models/lag_bank.h"
#include "compensation/models/least_squares.h"
#include "core/error.h"
#include "core/units.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index most_grey_box_blocks = 160;
constexpr int lags = 5;
constexpr double longest_shortest = 300.0;  ///< s, upper limit of the shortest time constant
constexpr double drift_s = 20000.0;         ///< s, prior of the drift's time constant
constexpr double intercept_std = 10.0;      ///< of the intercept, in standard deviations of the target
constexpr int most_evaluations = 220;

/// Standard deviations of the parts, as logarithms; which are there depends on the inputs.
struct Deviations {
  double temperature, activity, drift, drift_time, noise, start;
};
constexpr Index deviations_count = 6;

Deviations deviations_of(const VectorXd& x) {
  return {std::exp(x[0]), std::exp(x[1]), std::exp(x[2]), std::exp(x[3]), std::exp(x[4]), std::exp(x[5])};
}

class GreyBox final : public ChannelModel {
public:
  void fit(const TrainingData& whole) override {
    const double span = longest_stretch(whole);
    if (!(span > 0.0))
      throw InputError(whole.label, fmt::format("displacements over {} s", span), "a record with a duration");
    // Blocks resolve the part with displacements; a long record around it does not make them longer.
    const double share = std::max(span / whole.measured_time(), 0.05);
    const Blocks blocks = make_blocks(whole, static_cast<Index>(most_grey_box_blocks / share));
    const TrainingData& data = blocks.data;
    info_ = data.info;
    set_scales(data);
    const double slowest = span / 3.0, fastest = std::min(longest_shortest, slowest / 10.0);
    tau_.clear();
    for (int m = 0; m < lags; ++m) tau_.push_back(fastest * std::pow(slowest / fastest, m / (lags - 1.0)));

    MatrixXd features = lagged_features(data, tau_, blocks.averaged);
    for (Index k = 0; k < features.cols(); ++k) {
      const Index input = k % data.inputs.cols();
      features.col(k) = (features.col(k).array() - reference_[input]) / (scale_[input] * std::sqrt(lags));
    }
    std::vector<Index> rows;
    for (Index i = 0; i < data.target.size(); ++i) {
      if (std::isfinite(data.target[i]) && features.row(i).allFinite()) rows.push_back(i);
    }
    // Rows that crowd in a short time cost more than they tell.
    const std::size_t stride = rows.size() / (2 * most_grey_box_blocks) + 1;
    for (std::size_t i = 0; i * stride < rows.size(); ++i) rows[i] = rows[i * stride];
    rows.resize((rows.size() + stride - 1) / stride);
    if (rows.size() < 12) throw InputError(data.label, fmt::format("{} complete blocks", rows.size()), "at least 12");
    infer(data, features(rows, Eigen::all), rows, span);
  }

  std::unique_ptr<RowPredictor> start() const override { return std::make_unique<Predictor>(*this); }

  std::string explain(const std::string& unit) const override {
    std::string text = fmt::format("noise {:.3g}, drift {:.3g} {} over {:.3g} h;", noise_, drift_, unit,
                                   drift_time_ / core::units::hour);
    for (Index i = 0; i < gains_.rows(); ++i) {
      text += fmt::format(" {}:", info_[i].id);
      for (Index m = 0; m < gains_.cols(); ++m) text += fmt::format(" {:+.3g}", gains_(i, m));
      text += fmt::format(" (sum {:+.3g});", gains_.row(i).sum());
    }
    text += " per unit after";
    for (const double tau : tau_) text += fmt::format(" {:.3g}", tau / core::units::hour);
    return text + fmt::format(" h; intercept {:.4g} {}", intercept_, unit);
  }

  void save(ParameterStore& store) const override {
    store.put("tau_s", Eigen::Map<const VectorXd>(tau_.data(), std::ssize(tau_)));
    store.put("gains", gains_);
    store.put("intercept", intercept_);
    store.put("noise", noise_);
    store.put("drift", drift_);
    store.put("drift_time_s", drift_time_);
  }

  void load(const ParameterStore& store, const std::vector<InputInfo>& info) override {
    info_ = info;
    const VectorXd tau = store.vector("tau_s");
    if (!(tau.array() > 0.0).all())
      throw InputError(store.place() + " tau_s", "a time constant that is not above 0", "positive numbers");
    tau_.assign(tau.begin(), tau.end());
    gains_ = store.matrix("gains", std::ssize(info), tau.size());
    intercept_ = store.number("intercept");
    noise_ = store.number("noise", 0.0);
    drift_ = store.number("drift", 0.0);
    drift_time_ = store.number("drift_time_s", 0.0);
  }

private:
  class Predictor final : public RowPredictor {
  public:
    explicit Predictor(const GreyBox& model) : model_(model), bank_(model.info_, model.tau_) {}
    double step(double time, const Eigen::Ref<const Eigen::RowVectorXd>& inputs) override {
      return model_.intercept_ + bank_.step(time, inputs).cwiseProduct(model_.gains_).sum();
    }

  private:
    const GreyBox& model_;
    LagBank bank_;
  };

  /// All temperatures count in one unit (they are alike), every other input in its own deviation.
  void set_scales(const TrainingData& data) {
    const Index n = data.inputs.cols();
    scale_ = reference_ = VectorXd::Zero(n);
    double squares = 0.0, count = 0.0;
    for (Index k = 0; k < n; ++k) {
      double sum = 0.0, sum2 = 0.0, known = 0.0;
      const Index first = known_range(data.inputs.col(k)).first;
      const double origin = first < 0 ? 0.0 : data.inputs(first, k);
      for (Index i = 0; i < data.inputs.rows(); ++i) {
        const double value = data.inputs(i, k) - origin;
        if (!std::isfinite(value) || !std::isfinite(data.target[i])) continue;
        sum += value;
        sum2 += value * value;
        known += 1.0;
      }
      const double variance = known > 0.0 ? std::max(0.0, sum2 / known - sum / known * (sum / known)) : 0.0;
      const InputInfo& info = data.info[k];
      reference_[k] = info.activity ? 0.0 : origin;
      scale_[k] = variance > 0.0 ? std::sqrt(variance) : 1.0;
      if (info.temperature) {
        squares += variance;
        count += 1.0;
      }
    }
    for (Index k = 0; k < n; ++k) {
      if (data.info[k].temperature) scale_[k] = squares > 0.0 ? std::sqrt(squares / count) : 1.0;
    }
  }

  void infer(const TrainingData& data, const MatrixXd& features, const std::vector<Index>& rows, double span) {
    const auto n = std::ssize(rows);
    const VectorXd time = data.time(rows);
    VectorXd target = data.target(rows);
    const double mean = target.mean();
    target.array() -= mean;
    const double spread = std::sqrt(target.squaredNorm() / n);
    if (!(spread > 1e-12 * (1.0 + std::abs(mean))) || !std::isfinite(spread)) {
      throw InputError(data.label, fmt::format("a displacement that is constant at {}", mean),
                       "a displacement that varies");
    }
    target /= spread;

    // Kernels of the parts between the training rows.
    std::vector<Index> sampled, others;
    for (Index k = 0; k < features.cols(); ++k) {
      (info_[k % reference_.size()].temperature ? sampled : others).push_back(k);
    }
    const auto kernel = [&](const std::vector<Index>& columns) {
      const MatrixXd chosen = features(Eigen::all, columns);
      return MatrixXd(chosen * chosen.transpose());
    };
    const MatrixXd by_temperature = kernel(sampled), by_activity = kernel(others);
    MatrixXd by_start = MatrixXd::Zero(n, n), distance(n, n);
    for (const double tau : tau_) {
      const VectorXd decay = (-(time.array() - data.time[0]) / tau).exp();
      by_start += decay * decay.transpose() / static_cast<double>(lags);
    }
    for (Index j = 0; j < n; ++j) distance.col(j) = (time.array() - time[j]).abs();

    const auto covariance = [&](const Deviations& deviations) {
      MatrixXd sum = (deviations.drift * deviations.drift * (-distance.array() / deviations.drift_time).exp()).matrix();
      sum += deviations.temperature * deviations.temperature * by_temperature +
             deviations.activity * deviations.activity * by_activity + deviations.start * deviations.start * by_start;
      sum.array() += intercept_std * intercept_std;
      sum.diagonal().array() += deviations.noise * deviations.noise;
      return sum;
    };
    VectorXd centre(deviations_count);
    centre << std::log(1.0), std::log(1.0), std::log(0.2), std::log(std::min(drift_s, span)), std::log(0.05),
        std::log(0.5);
    constexpr double narrowest = -4.6, fast = 300.0, slow = 1e6;  // log of noise over spread; s
    const auto cost = [&](const VectorXd& x) {
      const Deviations deviations = deviations_of(x);
      if (x[4] < narrowest || deviations.drift_time < fast || deviations.drift_time > slow || x.maxCoeff() > 20.0 ||
          x.minCoeff() < -20.0) {
        return std::numeric_limits<double>::infinity();
      }
      const Eigen::LLT<MatrixXd> factor(covariance(deviations));
      if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
      const double misfit = factor.matrixL().solve(target).squaredNorm();
      const double volume = factor.matrixLLT().diagonal().array().log().sum();
      VectorXd prior = x - centre;
      prior[4] = 0.0;
      return 0.5 * misfit + volume + 0.5 * prior.squaredNorm();
    };
    const Minimum best =
        simplex_search(cost, centre, VectorXd::Constant(deviations_count, 0.7), most_evaluations, 1e-6);
    const Deviations deviations = deviations_of(best.at);
    const Eigen::LLT<MatrixXd> factor(covariance(deviations));
    if (!std::isfinite(best.value) || factor.info() != Eigen::Success) {
      throw InputError(data.label, "a record that does not identify the gains",
                       "finite inputs and displacements of usual size");
    }
    const VectorXd weights = factor.solve(target);
    gains_ = MatrixXd::Zero(reference_.size(), lags);
    intercept_ = mean + spread * intercept_std * intercept_std * weights.sum();
    for (Index k = 0; k < features.cols(); ++k) {
      const Index input = k % reference_.size(), m = k / reference_.size();
      const double std = info_[input].temperature ? deviations.temperature : deviations.activity;
      const double gain = spread * std * std * features.col(k).dot(weights) / (scale_[input] * std::sqrt(lags));
      gains_(input, m) = gain;
      intercept_ -= gain * reference_[input];
    }
    noise_ = spread * deviations.noise;
    drift_ = spread * deviations.drift;
    drift_time_ = deviations.drift_time;
  }

  std::vector<InputInfo> info_;
  std::vector<double> tau_;
  MatrixXd gains_;  ///< (inputs x lags)
  double intercept_ = 0, noise_ = 0, drift_ = 0, drift_time_ = 0;
  VectorXd scale_, reference_;  ///< (inputs) of the fit only
};

}  // namespace

std::unique_ptr<ChannelModel> make_grey_box() { return std::make_unique<GreyBox>(); }

}  // namespace thermotwin::compensation
