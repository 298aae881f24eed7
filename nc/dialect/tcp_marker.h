// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Comments by which tool centre point control begins and ends in a program that the helper runs.

#include <string>

namespace thermotwin::nc {

inline constexpr const char* tcp_on_marker = "tcp on";
inline constexpr const char* tcp_off_marker = "tcp off";

inline std::string marker_comment(const std::string& marker) { return "(thermotwin:" + marker + ")"; }

}  // namespace thermotwin::nc
