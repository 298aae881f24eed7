// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/lag_bank.h"

#include <cmath>
#include <iterator>
#include <limits>

namespace thermotwin::compensation {

using Eigen::Index;

namespace {
constexpr double missing = std::numeric_limits<double>::quiet_NaN();
}

LagBank::LagBank(std::vector<InputInfo> info, std::vector<double> tau, bool averaged)
    : info_(std::move(info)),
      tau_(std::move(tau)),
      averaged_(averaged) {
  const auto inputs = std::ssize(info_), lags = std::ssize(tau_);
  state_ = output_ = Eigen::MatrixXd::Zero(inputs, lags);
  last_value_ = last_time_ = Eigen::VectorXd::Constant(inputs, missing);
  decay_ = rest_ = Eigen::VectorXd::Zero(lags);
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
      if (h != factor_for_) {
        factor_for_ = h;
        for (Index k = 0; k < decay_.size(); ++k) {
          const double tau_k = tau_[k];
          decay_[k] = tau_k > 0.0 ? std::exp(-h / tau_k) : 0.0;
          rest_[k] = tau_k > 0.0 ? -std::expm1(-h / tau_k) : 1.0;
        }
      }
      const double before = last_value_[j];
      if (info.temperature || averaged_) {
        // y = u - slope tau + (y0 - u0 + slope tau) e^-x, in a form that does not cancel for small x.
        const double slope = (u - before) / h;
        for (Index k = 0; k < decay_.size(); ++k) {
          const double tau_k = tau_[k];
          state_(j, k) = u - slope * tau_k * rest_[k] + (state_(j, k) - before) * decay_[k];
        }
      } else {
        for (Index k = 0; k < decay_.size(); ++k) state_(j, k) = before * rest_[k] + state_(j, k) * decay_[k];
      }
    }
    last_time_[j] = time;
    last_value_[j] = u;
    for (Index k = 0; k < decay_.size(); ++k) output_(j, k) = tau_[k] > 0.0 ? state_(j, k) : u;
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
