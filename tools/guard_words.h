// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Words of the guard's states, as in answers of `compensate --json-lines` and `serve`.

#include "compensation/online/offset_guard.h"

namespace thermotwin::tools {

constexpr const char* text_of(compensation::GuardState state) {
  switch (state) {
    case compensation::GuardState::following: return "following";
    case compensation::GuardState::limited: return "limited";
    case compensation::GuardState::holding: return "holding";
    case compensation::GuardState::returning: return "returning";
  }
  return "";
}

}  // namespace thermotwin::tools
