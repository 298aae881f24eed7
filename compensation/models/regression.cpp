// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/regression.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <limits>

#include "compensation/measurement/stretch.h"
#include "compensation/models/lag_bank.h"
#include "compensation/models/least_squares.h"
#include "core/error.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int selection_folds = 5;

const std::vector<double>& ridges() {
  static const std::vector<double> all = {1e-6, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0};
  return all;
}

/// intercept + gains on the inputs, each past one lag (0: none). Inputs without gain may be missing.
class LaggedLine : public ChannelModel {
public:
  std::unique_ptr<RowPredictor> start() const override { return std::make_unique<Predictor>(*this); }

  std::string explain(const std::string& unit) const override {
    std::string text = tau_ > 0.0 ? fmt::format("tau {:.4g} s, ", tau_) : std::string();
    text += "gains";
    if (line_.gains.size() == 0 || line_.gains.isZero(0.0)) text += " none";
    for (std::size_t k = 0; k < info_.size(); ++k) {
      const double gain = line_.gains[k];
      if (gain != 0.0) text += fmt::format(" {} {:.4g}", info_[k].id, gain);
    }
    return text +
           fmt::format(" {}/K, intercept {:.4g} {}, {} rows{}", unit, line_.intercept, unit, line_.rows, remark_);
  }

  void save(ParameterStore& store) const override {
    store.put("tau_s", tau_);
    store.put("gains", line_.gains);
    store.put("intercept", line_.intercept);
    store.put("rows", line_.rows);
  }

  void load(const ParameterStore& store, const std::vector<InputInfo>& info) override {
    info_ = info;
    tau_ = store.number("tau_s", 0.0, 1e12);
    line_.gains = store.vector("gains", std::ssize(info));
    line_.intercept = store.number("intercept");
    line_.rows = static_cast<Index>(store.number("rows", 0.0, 1e15));
  }

protected:
  std::vector<InputInfo> info_;
  double tau_ = 0.0;
  Line line_;
  std::string remark_;

  /// All inputs. @return the strength of the ridge, the best one on held-out blocks
  double fit_ridge_by_blocks(const TrainingData& data) {
    Index best = 0;
    block_errors(data.inputs, data.target, ridges(), selection_folds, data.label).minCoeff(&best);
    const double ridge = ridges()[best];
    line_ = fit_ridge(data.inputs, data.target, ridge, data.label);
    remark_ = fmt::format(", ridge {:g}", ridge);
    return ridge;
  }

private:
  class Predictor final : public RowPredictor {
  public:
    explicit Predictor(const LaggedLine& model) : model_(model), bank_(model.info_, {model.tau_}) {}
    double step(double time, const Eigen::Ref<const Eigen::RowVectorXd>& inputs) override {
      const MatrixXd& lagged = bank_.step(time, inputs);
      double sum = model_.line_.intercept;
      for (Index k = 0; k < lagged.rows(); ++k) {
        if (model_.line_.gains[k] != 0.0) sum += model_.line_.gains[k] * lagged(k, 0);
      }
      return sum;
    }

  private:
    const LaggedLine& model_;
    LagBank bank_;
  };
};

class StaticRegression final : public LaggedLine {
public:
  void fit(const TrainingData& data) override {
    info_ = data.info;
    line_ = fit_line(data.inputs, data.target, data.label);
  }
};

class RidgeRegression final : public LaggedLine {
public:
  std::string caution() const override { return caution_; }

  void fit(const TrainingData& data) override {
    info_ = data.info;
    caution_ = fit_ridge_by_blocks(data) < ridges().back()
                   ? ""
                   : "the ridge is at its upper bound: the displacement hardly depends on the inputs";
  }

private:
  std::string caution_;
};

class SelectedRegression final : public LaggedLine {
public:
  std::string caution() const override { return caution_; }

  void fit(const TrainingData& data) override {
    info_ = data.info;
    caution_.clear();
    const VectorXd constant = VectorXd::Zero(data.target.size());
    double error = block_errors(constant, data.target, {1.0}, selection_folds, data.label)[0];
    std::vector<Index> taken;
    while (std::ssize(taken) < data.inputs.cols()) {
      Index best = -1;
      double least = error * (1.0 - least_gain);
      for (Index k = 0; k < data.inputs.cols(); ++k) {
        if (std::find(taken.begin(), taken.end(), k) != taken.end()) continue;
        std::vector<Index> trial = taken;
        trial.push_back(k);
        const double found =
            block_errors(data.inputs(Eigen::all, trial), data.target, {1e-6}, selection_folds, data.label)[0];
        if (found < least) {
          least = found;
          best = k;
        }
      }
      if (best < 0) break;
      taken.push_back(best);
      error = least;
    }
    if (taken.empty()) {
      fit_ridge_by_blocks(data);
      caution_ = fmt::format(
          "no single input improves held-out blocks by {:g} %; ridge regression on all inputs is used instead",
          100.0 * least_gain);
      return;
    }
    line_.gains = VectorXd::Zero(data.inputs.cols());
    const Line chosen = fit_line(data.inputs(Eigen::all, taken), data.target, data.label);
    for (std::size_t i = 0; i < taken.size(); ++i) line_.gains[taken[i]] = chosen.gains[i];
    line_.intercept = chosen.intercept;
    line_.rows = chosen.rows;
  }

private:
  static constexpr double least_gain = 0.02;
  std::string caution_;
};

class FirstOrder final : public LaggedLine {
public:
  std::string caution() const override { return caution_; }

  void fit(const TrainingData& whole) override {
    const Blocks blocks = make_blocks(whole, most_blocks);
    const TrainingData& data = blocks.data;
    info_ = data.info;
    const double span = longest_stretch(data);
    if (!(span > 0.0)) throw InputError(data.label, fmt::format("a record of {} s", span), "a record with a duration");
    // A lag below half the mean interval cannot be told from none. One beyond a third of the record
    // has not run off in it (95 % take three time constants) and cannot be told from a ramp.
    const double shortest = std::log(std::min(
                     0.5 * (data.time[data.time.size() - 1] - data.time[0]) / (data.time.size() - 1), span / 6.0)),
                 longest = std::log(span / 3.0);
    const auto squares = [&](double log_tau) {
      return fit_line(lagged_features(data, {std::exp(log_tau)}, blocks.averaged), data.target, data.label).squares;
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
    tau_ = std::exp(
        golden(squares, shortest + std::max(best - 1, 0) * step, shortest + std::min(best + 1, points - 1) * step));
    line_ = fit_line(lagged_features(data, {tau_}, blocks.averaged), data.target, data.label);
    const bool at_bound = best == 0 || best == points - 1;
    caution_ =
        at_bound ? fmt::format(
                       "time constant of {:.4g} s is at the bound of the search; the record does not identify it", tau_)
                 : std::string();
  }

private:
  static constexpr Index most_blocks = 20000;  ///< large gains remember how the record started
  std::string caution_;

  template <class Function>
  static double golden(const Function& function, double low, double high) {
    constexpr double ratio = 0.6180339887498949;
    double a = high - ratio * (high - low), b = low + ratio * (high - low);
    double at_a = function(a), at_b = function(b);
    while (high - low > 1e-6) {
      const bool left = at_a <= at_b;
      (left ? high : low) = left ? b : a;
      (left ? b : a) = left ? a : b;
      (left ? at_b : at_a) = left ? at_a : at_b;
      double& inner = left ? a : b;
      inner = left ? high - ratio * (high - low) : low + ratio * (high - low);
      (left ? at_a : at_b) = function(inner);
    }
    return 0.5 * (low + high);
  }
};

}  // namespace

std::unique_ptr<ChannelModel> make_static_regression() { return std::make_unique<StaticRegression>(); }
std::unique_ptr<ChannelModel> make_ridge_regression() { return std::make_unique<RidgeRegression>(); }
std::unique_ptr<ChannelModel> make_selected_regression() { return std::make_unique<SelectedRegression>(); }
std::unique_ptr<ChannelModel> make_first_order() { return std::make_unique<FirstOrder>(); }

}  // namespace thermotwin::compensation
