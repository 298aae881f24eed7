// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/channel_model.h"

#include "core/missing.h"

namespace thermotwin::compensation {

using core::missing;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd ChannelModel::predict(const VectorXd& time, const MatrixXd& inputs) const {
  const std::unique_ptr<RowPredictor> predictor = start();
  VectorXd result(time.size());
  for (Index i = 0; i < time.size(); ++i) {
    const double value = predictor->step(time[i], inputs.row(i));
    result[i] = std::isfinite(value) ? value : missing;
  }
  return result;
}

}  // namespace thermotwin::compensation
