// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Whether tests of LinuxCNC's interpreter run. Without the helper they are skipped, unless THERMOTWIN_LINUXCNC says
// that it must be there: then they fail.

#include <cstdlib>

#include "nc/program/interpreter.h"

namespace thermotwin::nc {

inline bool interpreter_there() { return std::getenv("THERMOTWIN_LINUXCNC") != nullptr || !find_helper().empty(); }

}  // namespace thermotwin::nc
