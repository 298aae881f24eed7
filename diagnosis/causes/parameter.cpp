// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/parameter.h"

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

std::string name_of(const Parameter& parameter) { return name_of(parameter.kind) + " of " + parameter.where; }

}  // namespace thermotwin::diagnosis
