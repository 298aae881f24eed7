// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Time constants and late clocks far from nominal, where the tangent at nominal says nothing of them.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/inference/hypothesis_fit.h"

namespace thermotwin::diagnosis {

struct ScannedReading {
  int parameter = -1;
  double value = 0;
  Eigen::VectorXd column, residual;  ///< (fitted) white: tangent there, residual of the linear form
};

/// The few of the candidates' lags and clock shifts whose best value in their range gains most, beside the members of a
/// linear form. @param machine  the nominal one
std::vector<ScannedReading> scan_readings(const Problem& problem, const Response& response,
                                          const mesh::Machine& machine, const White& white, const LinearForm& form,
                                          const std::vector<int>& candidates);

}  // namespace thermotwin::diagnosis
