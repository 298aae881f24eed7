// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the rewriters are told, and what they count.

#include <vector>

#include "nc/control/control_profile.h"

namespace thermotwin::nc {

struct RewriteOptions {
  double tolerance = 0.5e-6;     ///< m
  double largest_offset = 1e-3;  ///< m; beyond it the program is refused
  std::vector<WordRule> words;   ///< of the control profile: the path takes what stands in their place
  bool dwells_in_ms = false;     ///< P of G4 in the written program
};

struct RewriteSummary {
  long lines_before = 0, lines_after = 0, changed = 0, split = 0, written_out = 0;
  double largest_um = 0;  ///< displacement
};

}  // namespace thermotwin::nc
