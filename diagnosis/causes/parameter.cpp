// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/parameter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "core/units.h"

namespace thermotwin::diagnosis {

Parameter make_parameter(Kind kind, const std::string& where) {
  const KindRow& row = row_of(kind);
  Parameter p;
  p.kind = kind;
  p.where = where;
  p.name = row.amount;
  p.unit = row.unit;
  p.ratio = row.sense == Sense::ratio;
  p.nominal = p.ratio ? 1.0 : 0.0;
  p.low = row.low;
  p.high = row.high;
  p.step = row.step;
  return p;
}

double cause_std_at(const Parameter& parameter, double value) {
  return std::max(parameter.cause_std, std::abs(value - parameter.nominal));
}

std::string step_in_words(const Parameter& parameter) {
  if (!std::isfinite(parameter.from_s)) return "the start";
  return fmt::format("{:.2f} +- {} h of the record", parameter.from_s / core::units::hour,
                     core::plain_number(parameter.from_std_s / core::units::hour, 2));
}

std::string name_of(const Parameter& parameter) { return name_of(parameter.kind) + " of " + parameter.where; }

}  // namespace thermotwin::diagnosis
