// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The lines of machine.toml that an extension changes, for a page.

#include <string>

namespace thermotwin::diagnosis {

/// Changed lines with one line of context. The extension only replaces and adds single lines, so a
/// walk that looks a few lines ahead finds every difference.
std::string difference(const std::string& before, const std::string& after);

}  // namespace thermotwin::diagnosis
