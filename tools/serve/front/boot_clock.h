// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Seconds since the computer started, also while it sleeps. No change of the date moves it.

#include <ctime>

namespace thermotwin::tools {

inline double boot_s() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

}  // namespace thermotwin::tools
