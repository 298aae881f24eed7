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
  double rms_stated = 0;   ///< of measured minus predicted (displacements: about the means), in the stated unit
  double rms_changed = 0;  ///< the same, with numbers divided by the factor, or converted from degrees Fahrenheit
};

/// Compares displacements about their means, because a probe may start at any reading. A factor is reported if the
/// fitted factor is between half and twice it, and the absolute correlation is at least 0.9. The RMS of the prediction
/// must be at least three uncertainties, and the residual RMS must fall to at most 75 %. The wide limits allow for a
/// cause that the model lacks. For a temperature, the conversion from degrees Fahrenheit must leave less than 10 % of
/// the residual RMS, and at most 4 K.
/// @param measured, predicted  (rows) in the unit of the channel, NaN where missing
std::optional<UnitHint> unit_hint(const MeasuredChannel& channel, const Eigen::VectorXd& measured,
                                  const Eigen::VectorXd& predicted);

/// @return the hint as a sentence with the figures
std::string in_words(const UnitHint& hint, const MeasuredChannel& channel);

}  // namespace thermotwin::compensation
