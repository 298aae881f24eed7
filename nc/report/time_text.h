// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Times on the page of `nc`.

#include <string>

namespace thermotwin::nc {

/// "12.0 s", "3.4 min", "5.67 h"
std::string time_text(double seconds);

struct TimeUnit {
  const char* name;
  double seconds;
};
/// Of the axis of a picture that covers a duration, s.
TimeUnit unit_for(double duration);

}  // namespace thermotwin::nc
