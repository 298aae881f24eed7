// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The arrays of a tt_model (model.h) with their lengths, as they are built and written.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "compensation/control/model.h"

namespace thermotwin::compensation {

struct ControlData {
  std::string name;
  std::uint64_t hash = 0;
#define TT_FIELD(x) std::int32_t x = 0;
  TT_MODEL_COUNTS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) double x = 0;
  TT_MODEL_NUMBERS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) std::vector<double> x;
  TT_MODEL_DOUBLES(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) std::vector<std::int32_t> x;
  TT_MODEL_INTS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) std::vector<std::string> x;
  TT_MODEL_TEXTS(TT_FIELD)
#undef TT_FIELD
};

}  // namespace thermotwin::compensation
