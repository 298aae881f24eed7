// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Whether the machine as stated fits the fitted part of a record, and what is furthest off.

#include <cstddef>
#include <string>
#include <utility>

#include "diagnosis/inference/search_result.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// The machine as stated fits the fitted part already: chi-square as expected, no parameter far from what is stated of
/// it, and no channel further off than expected. A cause may fit better still, but then the model's error is stated too
/// large to say so.
bool nothing_fits(const Problem& problem, const SearchResult& found);

/// The channel whose fitted part is furthest from the prediction, in what is expected of it.
std::pair<std::size_t, double> furthest_channel(const Problem& problem);

/// Whether the cause brings the channel that is furthest off clearly nearer to its prediction.
bool lessens_furthest(const Problem& problem, const RankedCause& cause);

/// Why the machine as stated does not fit, though no cause is more likely; empty: it fits.
std::string why_none_does_not_fit(const Problem& problem, const SearchResult& found);

}  // namespace thermotwin::diagnosis
