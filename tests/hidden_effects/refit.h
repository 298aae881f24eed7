// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The hidden cause of a record and what the diagnosis prefers to it, each fitted about its own estimate.

#include <optional>
#include <vector>

#include "expectations.h"

namespace thermotwin::hidden {

/// ln of posterior odds against no cause, prior included, of causes that are fitted with all nuisance parameters.
/// @param causes   empty: no cause, 0
/// @param machine  nominal
/// @return nothing where one of them is no parameter of the problem, as missing sources and steps are not
std::optional<double> refitted_log_odds(const Seen& seen, const mesh::Machine& machine,
                                        const std::vector<Truth>& causes);

}  // namespace thermotwin::hidden
