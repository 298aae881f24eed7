// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Finds channels that are not what channels.toml states: with another sign or unit, or two that are exchanged. The
// comparison is with the prediction of the machine as stated, before any cause is considered.

#include <string>
#include <vector>

#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

struct ConnectionDoubt {
  std::string clause;   ///< "T3 and T5 seem to be exchanged"
  std::string warning;  ///< a sentence with the figures
  /// What is changed so leaves at most half of the residual: no cause is to be believed before it is checked.
  bool strong = false;
};

/// Only channels whose residual RMS is at least 1.5 times the expected one are considered. Two temperatures, or two
/// displacements of one unit, of a record are taken for exchanged if that leaves at most half of their residual, and
/// less in each of them. Displacements are compared about their means.
std::vector<ConnectionDoubt> connection_doubts(const Problem& problem);

}  // namespace thermotwin::diagnosis
