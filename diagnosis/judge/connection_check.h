// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Finds channels that contradict channels.toml: a wrong sign or unit, or two exchanged channels. They are compared with
// the prediction of the nominal machine, before any cause is considered.

#include <string>
#include <vector>

#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

struct ConnectionDoubt {
  std::string clause;   ///< "T3 and T5 seem to be exchanged"
  std::string warning;  ///< a sentence with the figures
  /// The change leaves at most half of the residual RMS: check the connection before believing any cause.
  bool strong = false;
};

/// Only channels whose residual RMS is at least 1.5 times the expected one are considered. Two temperatures, or two
/// displacements of one unit, of a record are reported as exchanged if that leaves at most 50 % of their joint residual
/// RMS and at most 70 % of either channel's. Displacements are compared about their means. Channels of a PointTest are
/// not tested for an exchange.
std::vector<ConnectionDoubt> connection_doubts(const Problem& problem);

}  // namespace thermotwin::diagnosis
