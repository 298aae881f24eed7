// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// From the probabilities of a search to a verdict: which causes are named, which share, and when nothing is wrong.

#include <string>

#include "diagnosis/inference/model_search.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

inline constexpr double strong = 10.0;  ///< ln Bayes factor against none
inline constexpr double sure = 0.9;     ///< marginal probability that names a cause

/// Ranking of all visible causes, none and unknown; verdict, named causes, those that share.
void decide(const Problem& problem, const SearchResult& found, Diagnosis& out);

/// What is explained stays ambiguous, with something unknown beside it, where all of the record strains the
/// explanation: a size that wanders, or another parameter that is off, by more than is ever expected.
void leave_open(const Problem& problem, const Strain& strain, Diagnosis& out);

/// What is explained stays ambiguous for a reason, "correcting it worsens ...": its strongest cause and something
/// unknown.
void leave_open(const std::string& reason, Diagnosis& out);

/// Whether an estimate is further from nominal than three stated standard deviations, and than two of its own; of a
/// missing source also whether its evidence is strong.
bool outside_nominal(const RankedCause& cause);

/// What is named is sure, but it is not all.
bool only_unknown_shares(const Diagnosis& diagnosis);

}  // namespace thermotwin::diagnosis
