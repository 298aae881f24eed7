// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/composite.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "compensation/models/lag_bank.h"
#include "compensation/models/least_squares.h"
#include "compensation/models/temperature_history.h"
#include "core/error.h"
#include "core/missing.h"
#include "core/statistics.h"
#include "core/units.h"

namespace thermotwin::compensation {

using core::missing;
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr double mode_K = 1.6;
constexpr std::array<double, 2> filter_s{3600.0, 10800.0};
constexpr Index ambient_features = 7;
constexpr int folds = 5;

/// The features of one row after the other.
class Features {
public:
  Features(const std::vector<InputInfo>& info, double tau, const VectorXd& bend, bool averaged)
      : info_(info),
        bend_(bend),
        ambient_(ambient_input(info)) {
    internal_ = std::ssize(info) - (ambient_ >= 0 ? 1 : 0);
    bank_.emplace_back(std::vector<InputInfo>(internal_, InputInfo{"", true, false, false}), std::vector<double>{tau},
                       averaged);
  }
  Index size() const { return ambient_features + 3 * internal_; }

  RowVectorXd step(double time, const Eigen::Ref<const RowVectorXd>& inputs) {
    RowVectorXd row = RowVectorXd::Constant(size(), missing);
    if (!inputs.allFinite()) return row;
    const double ambient = ambient_ >= 0 ? inputs[ambient_] : inputs.mean();
    history_.add(time, ambient);
    const double base = history_.mean(), deviation = ambient - base;
    const double stable = std::max(0.0, 1.0 - std::pow(deviation / mode_K, 6));
    row[0] = base;
    row[1] = stable * deviation;
    for (std::size_t k = 0; k < filter_s.size(); ++k) row[2 + k] = history_.filtered(filter_s[k]) - base;
    row[4] = deviation < 0.0 ? (1.0 - stable) * deviation : 0.0;
    row[5] = deviation >= 0.0 ? (1.0 - stable) * deviation : 0.0;
    row[6] = stable * deviation * std::abs(deviation);
    RowVectorXd above(internal_);
    for (Index i = 0, k = 0; i < inputs.size(); ++i) {
      if (i != ambient_) above[k++] = inputs[i] - ambient;
    }
    const RowVectorXd lagged = bank_.front().step(time, above).col(0).transpose();
    row.segment(ambient_features, internal_) = above;
    row.segment(ambient_features + internal_, internal_) = lagged;
    for (Index k = 0; k < internal_; ++k)
      row[ambient_features + 2 * internal_ + k] = std::max(0.0, above[k] - (bend_.size() > k ? bend_[k] : 0.0));
    return row;
  }

private:
  const std::vector<InputInfo>& info_;
  const VectorXd& bend_;
  Index ambient_ = -1, internal_ = 0;
  std::vector<LagBank> bank_;
  TemperatureHistory history_;
};

class Composite final : public ChannelModel {
public:
  void fit(const TrainingData& data) override {
    info_ = data.info;
    // Features of every row, as at work, then means over blocks.
    const auto rows_of = [&](double tau) {
      Features features(info_, tau, bend_, false);
      TrainingData row_data{data.label,  {},         data.time, MatrixXd(data.time.size(), features.size()),
                            data.target, data.breaks};
      row_data.info.resize(features.size());
      for (Index i = 0; i < data.time.size(); ++i)
        row_data.inputs.row(i) = features.step(data.time[i], data.inputs.row(i));
      return make_blocks(row_data, most_blocks).data;
    };
    bend_ = VectorXd();
    const MatrixXd first = rows_of(TemperatureHistory::cell_s).inputs;
    const Index internal = (first.cols() - ambient_features) / 3;
    bend_ = VectorXd::Zero(internal);
    for (Index k = 0; k < internal; ++k) {
      std::vector<double> values;
      for (const double value : first.col(ambient_features + k)) {
        if (std::isfinite(value)) values.push_back(value);
      }
      if (values.empty()) continue;
      bend_[k] = core::median(std::move(values));
    }
    const std::vector<double> ridges{1e-4, 1e-3, 1e-2, 0.1, 1.0};
    double least = std::numeric_limits<double>::infinity();
    for (const double tau : {1800.0, 7200.0}) {
      const TrainingData blocks = rows_of(tau);
      Index best = 0;
      const double error = block_errors(blocks.inputs, blocks.target, ridges, folds, data.label).minCoeff(&best);
      if (!(error < least)) continue;
      least = error;
      tau_ = tau;
      ridge_ = ridges[best];
      line_ = fit_ridge(blocks.inputs, blocks.target, ridge_, data.label);
    }
    if (!std::isfinite(least))
      throw InputError(data.label, "no finite fit", "temperatures and displacements of usual size");
  }

  std::unique_ptr<RowPredictor> start() const override { return std::make_unique<Predictor>(*this); }

  std::string explain(const std::string& unit) const override {
    std::string text = fmt::format(
        "baseline {:.3g}; stable {:.3g}, past 1 h {:.3g} and 3 h {:.3g}, cold {:.3g}, warm {:.3g} {}/K;",
        line_.gains[0], line_.gains[1], line_.gains[2], line_.gains[3], line_.gains[4], line_.gains[5], unit);
    const Index internal = (line_.gains.size() - ambient_features) / 3;
    Index k = 0;
    const Index ambient = ambient_input(info_);
    for (Index i = 0; i < std::ssize(info_); ++i) {
      if (i == ambient) continue;
      const Index at = ambient_features + k++;
      text += fmt::format(" {} {:.3g}, past {:.3g} h {:.3g}, above {:.3g} K {:+.3g};", info_[i].id, line_.gains[at],
                          tau_ / core::units::hour, line_.gains[at + internal], bend_[at - ambient_features],
                          line_.gains[at + 2 * internal]);
    }
    return text + fmt::format(" intercept {:.4g} {}, ridge {:g}", line_.intercept, unit, ridge_);
  }

  void save(ParameterStore& store) const override {
    store.put("tau_s", tau_);
    store.put("bend_K", bend_);
    store.put("gains", line_.gains);
    store.put("intercept", line_.intercept);
    store.put("ridge", ridge_);
  }

  void load(const ParameterStore& store, const std::vector<InputInfo>& info) override {
    info_ = info;
    tau_ = store.number("tau_s", 1e-3, 1e9);
    bend_ = store.vector("bend_K");
    const VectorXd none;
    line_.gains = store.vector("gains", Features(info_, tau_, none, false).size());
    if (3 * bend_.size() != line_.gains.size() - ambient_features) {
      throw InputError(store.place() + " bend_K", fmt::format("{} values", bend_.size()),
                       fmt::format("{}", (line_.gains.size() - ambient_features) / 3));
    }
    line_.intercept = store.number("intercept");
    ridge_ = store.number("ridge", 0.0);
  }

private:
  static constexpr Index most_blocks = 400;

  class Predictor final : public RowPredictor {
  public:
    explicit Predictor(const Composite& model)
        : model_(model),
          features_(model.info_, model.tau_, model.bend_, false) {}
    double step(double time, const Eigen::Ref<const RowVectorXd>& inputs) override {
      return model_.line_.intercept + features_.step(time, inputs).dot(model_.line_.gains);
    }

  private:
    const Composite& model_;
    Features features_;
  };

  std::vector<InputInfo> info_;
  VectorXd bend_;  ///< K above ambient, of each internal temperature
  double tau_ = 0, ridge_ = 0;
  Line line_;
};

}  // namespace

std::unique_ptr<ChannelModel> make_composite() { return std::make_unique<Composite>(); }

}  // namespace thermotwin::compensation
