// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The path of the tool in 3-D for a page, coloured by its error: length, a component or the standard deviation. A
// slider moves along the program. The view may be given behind the address: `#colour=1&time=0.5&turn=0.4&rapid=0`.

#include <string>

#include "nc/report/path_points.h"

namespace thermotwin::nc {

/// A section of a page; empty for fewer than two points. @param below  a line that explains it, HTML
std::string path_scene_html(const PathPoints& path, const std::string& below);

}  // namespace thermotwin::nc
