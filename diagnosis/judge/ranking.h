// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The causes of a search in the order of their probabilities, with none and something unknown among them.

#include <vector>

#include "diagnosis/inference/search_result.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

inline constexpr double strong = 10.0;        ///< ln Bayes factor against none
inline constexpr double sure = 0.9;           ///< marginal probability that names a cause
inline constexpr double least_in_set = 0.01;  ///< of each that is listed for what is not named
inline constexpr double certain = 2.0;        ///< of its own standard deviations that a size has to be off

RankedCause no_parameter(Kind kind, double probability, double log_evidence);
RankedCause something_unknown(const SearchResult& found);
RankedCause other_law(const Problem& problem, const ChangingLaw& law);

/// Fills the ranking of what the record can show, none and unknown. @return causes, the leading one first
std::vector<RankedCause> rank(const Problem& problem, const SearchResult& found, Diagnosis& out);

/// Ranking and explanations, where more of a misfit is known than when it was decided.
void rank_anew(const Problem& problem, const SearchResult& found, Diagnosis& out);

/// @return whether an estimate deviates from nominal by more than three stated standard deviations and by more than two
///   of its own, or belongs to a missing source with strong evidence
bool outside_nominal(const RankedCause& cause);

/// An estimate at the largest value that is looked for: what it stands for is more, or something else.
bool is_at_bound(const RankedCause& cause);

}  // namespace thermotwin::diagnosis
