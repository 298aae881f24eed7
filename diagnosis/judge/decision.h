// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Turns the probabilities of a search into a verdict: which causes are named, which remain ambiguous, or that there is
// no discrepancy.

#include <set>
#include <string>

#include "diagnosis/inference/model_search.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

inline constexpr double strong = 10.0;  ///< ln Bayes factor against none
inline constexpr double sure = 0.9;     ///< marginal probability that names a cause

/// Sets the ranking of all observable causes with none and unknown, the verdict, the named causes and the ambiguous
/// set.
void decide(const Problem& problem, const SearchResult& found, Diagnosis& out);

/// @return the steps in readings that describe something unknown best, where it has 0.5 or more; else none
StepsSeen steps_seen(const Problem& problem, const SearchResult& found);

/// Inputs of the machine that changed within half an hour before one of the steps, at most four: states first, then
/// speeds, feeds and powers.
std::vector<std::string> inputs_before(const Observations& observations, const mesh::Machine& machine,
                                       const StepsSeen& seen);

/// Changes an explained verdict to ambiguous, with an unknown cause in the set, if the whole record strains the
/// explanation: a size that varies, or another parameter that deviates, by more than expected. Where it is the size of
/// a single source or joint, `other_law` of it is in the set too.
void leave_open(const Problem& problem, const Strain& strain, Diagnosis& out);

/// The same for a reason such as "correcting it worsens ...": the strongest cause stays, with an unknown one in the
/// set.
void leave_open(const std::string& reason, Diagnosis& out);

/// Ranking and explanations, where more of a misfit is known than when it was decided.
void rank_anew(const Problem& problem, const SearchResult& found, Diagnosis& out);

/// @return why a named cause does not explain: its estimate is nearer to nominal than two of its own standard
///   deviations; empty: none is
std::string uncertain_size(const Diagnosis& diagnosis);

/// @return why a named cause does not explain: its estimate is the largest value that is looked for, or a
///   film's is almost 0; empty: none is
/// @param switched  ids of films that a state switches off: fluid that does not flow transfers no heat
std::string at_bound(const Diagnosis& diagnosis, const std::set<std::string>& switched = {});

/// @return whether an estimate deviates from nominal by more than three stated standard deviations and by more than two
///   of its own, or belongs to a missing source with strong evidence
bool outside_nominal(const RankedCause& cause);

/// @return whether the named causes are certain, but an unknown cause acts as well
bool only_unknown_shares(const Diagnosis& diagnosis);

}  // namespace thermotwin::diagnosis
