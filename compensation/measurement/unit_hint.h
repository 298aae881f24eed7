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

/// Compares displacements about their means, because a probe may begin at any reading. A factor is offered under four
/// conditions: the fitted factor lies between half and twice of it; the absolute correlation is above 0.9; the RMS of
/// the prediction is above three uncertainties; at most 0.75 of the RMS residual is left. The wide limits allow for a
/// cause that the model lacks. A temperature is compared as it is, once as stated and once converted from degrees
/// Fahrenheit.
/// @param measured, predicted  (rows) in the unit of the channel, NaN where missing
std::optional<UnitHint> unit_hint(const MeasuredChannel& channel, const Eigen::VectorXd& measured,
                                  const Eigen::VectorXd& predicted);

/// @return the hint as a sentence with the figures
std::string in_words(const UnitHint& hint, const MeasuredChannel& channel);

}  // namespace thermotwin::compensation
