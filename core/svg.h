// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Helpers that all SVG pictures and HTML pages share.

#include <string>
#include <vector>

namespace thermotwin::core {

/// @return the text for XML and HTML: & < > " are replaced, control characters except tab and line feed are left out
std::string xml_text(const std::string& text);

/// @return the tick values of an axis from low to high, in at most `count` steps of 1, 2 or 5 times a power of ten;
///   empty if high is not above low or a value is not finite
std::vector<double> axis_ticks(double low, double high, int count);

}  // namespace thermotwin::core
