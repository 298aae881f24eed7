// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Which errors of the chain a record's points distinguish, where the file does not state the errors.

#include <string>
#include <vector>

#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

struct ErrorChoice {
  std::vector<std::string> chosen;
  /// "EYX2 from ECX1": a candidate with an effect that the points do not distinguish from chosen ones.
  std::vector<std::string> left_out;
};

/// Takes the candidates in their order. One is left out where less than a thousandth of its effect on the points of the
/// first cycle differs from those before it, or when half of the coordinates are used.
ErrorChoice distinguished(const RTestRecord& record, const std::vector<std::string>& candidates);

/// Of an R-Test: usual_errors(). Where rotary axes of both sides move, some of these act alike, and a rotation of the
/// tool's axis about itself may not: then the distinguished ones of usual_errors() and of all errors of the tool's
/// axes.
ErrorChoice default_errors(const RTestRecord& record);

}  // namespace thermotwin::metrology
