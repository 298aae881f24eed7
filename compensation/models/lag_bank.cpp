// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/lag_bank.h"

#include <cmath>
#include <iterator>

#include "core/missing.h"

namespace thermotwin::compensation {

using core::missing;
using Eigen::Index;

namespace {}

LagBank::LagBank(std::vector<InputInfo> info, std::vector<double> tau, bool averaged)
    : info_(std::move(info)),
      tau_(std::move(tau)),
      averaged_(averaged) {
  const auto inputs = std::ssize(info_), lags = std::ssize(tau_);
  state_ = output_ = Eigen::MatrixXd::Zero(inputs, lags);
  last_value_ = last_time_ = Eigen::VectorXd::Constant(inputs, missing);
  steps_.resize(tau_.size());
}

const Eigen::MatrixXd& LagBank::step(double time, const Eigen::Ref<const Eigen::RowVectorXd>& inputs) {
  for (Index j = 0; j < state_.rows(); ++j) {
    const InputInfo& info = info_[j];
    const double u = inputs[j];
    if (!std::isfinite(u)) {
      output_.row(j).setConstant(missing);
      continue;
    }
    if (std::isnan(last_time_[j])) {
      state_.row(j).setConstant(info.activity ? 0.0 : u);
    } else if (const double h = time - last_time_[j]; h > 0.0) {
      if (h != steps_for_) {
        steps_for_ = h;
        for (std::size_t k = 0; k < tau_.size(); ++k) steps_[k] = core::LagStep(h, tau_[k]);
      }
      const double before = last_value_[j];
      const bool straight = info.temperature || averaged_;
      for (Index k = 0; k < state_.cols(); ++k) {
        const core::LagStep& step_k = steps_[k];
        state_(j, k) = straight ? step_k.straight(state_(j, k), before, u) : step_k.standing(state_(j, k), before);
      }
    }
    last_time_[j] = time;
    last_value_[j] = u;
    for (Index k = 0; k < state_.cols(); ++k) output_(j, k) = tau_[k] > 0.0 ? state_(j, k) : u;
  }
  return output_;
}

Eigen::MatrixXd lagged_features(const TrainingData& data, const std::vector<double>& tau, bool averaged) {
  const Index inputs = data.inputs.cols();
  LagBank bank(data.info, tau, averaged);
  Eigen::MatrixXd features(data.time.size(), inputs * std::ssize(tau));
  for (Index i = 0; i < features.rows(); ++i) {
    features.row(i) = bank.step(data.time[i], data.inputs.row(i)).reshaped().transpose();
  }
  return features;
}

}  // namespace thermotwin::compensation
