// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Finds a channel whose sign or unit is not the stated one: its record follows the prediction of a model with a factor
// such as -1, 1e-3 or 25.4 clearly better than with the factor 1.

#include <Eigen/Core>

#include <optional>
#include <string>

#include "compensation/measurement/measurement.h"

namespace thermotwin::compensation {

struct UnitHint {
  double factor = 1;       ///< recorded numbers over those in the stated unit
  std::string words;       ///< "its numbers may be mm", "its sign may be reversed"
  double rms_stated = 0;   ///< of measured minus predicted about its mean, in the stated unit
  double rms_changed = 0;  ///< the same, with the numbers divided by the factor
};

/// Compares changes about the mean, since a probe may begin anywhere. A factor is offered if the fitted one lies
/// between half and twice of it, the correlation is above 0.9 in size, the predicted RMS above three uncertainties, and
/// no more than 0.75 of the residual is left. The wide limits allow for a cause that the model lacks. A temperature is
/// compared in degrees Fahrenheit, with its offset.
/// @param measured, predicted  (rows) in the unit of the channel, NaN where missing
std::optional<UnitHint> unit_hint(const MeasuredChannel& channel, const Eigen::VectorXd& measured,
                                  const Eigen::VectorXd& predicted);

/// @return the hint as a sentence with the figures
std::string in_words(const UnitHint& hint, const MeasuredChannel& channel);

}  // namespace thermotwin::compensation
