// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Parts of the sentence on a record without a machine that depend on how many channels or causes they name.

#include <cstddef>
#include <string>
#include <vector>

namespace thermotwin::diagnosis {

/// Channels that follow the lag model though something may have changed them.
/// @param how_well  of one channel or several  @param rivals  causes that may have changed them; none: an unknown cause
std::string doubt(const std::vector<std::string>& channels, double fitted_hours, const std::string& how_well,
                  const std::vector<std::string>& rivals);
/// "within its uncertainty" of one, "within their uncertainty" of several.
std::string within_uncertainty(std::size_t channels);
/// " a explains the rest.", " a, b explain the rest."; nothing of none
std::string explain_the_rest(const std::vector<std::string>& causes);
/// "only a holds in the last part"; "no proposed cause holds in the last part" of none
std::string hold_in_the_last_part(const std::vector<std::string>& causes);

}  // namespace thermotwin::diagnosis
