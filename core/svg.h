// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What all pictures and pages written as text share.

#include <string>
#include <vector>

namespace thermotwin::core {

/// Text for XML and HTML: & < > " are replaced, control characters but tab and line feed left out.
std::string xml_text(const std::string& text);

/// Numbers for an axis from low to high: steps of 1, 2 or 5 times a power of ten, `count` steps at
/// most. Empty where high is not above low, or either is not finite.
std::vector<double> axis_ticks(double low, double high, int count);

}  // namespace thermotwin::core
