// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The data of a tt_model (model.h) in vectors that own them, for the code that builds and writes a model. The macros of
// model.h list the members.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "compensation/control/model.h"

namespace thermotwin::compensation {

struct ControlData {
  std::string name;
  std::uint64_t hash = 0;  ///< of all members below
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
