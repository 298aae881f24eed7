// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Turns the probabilities of a search into a verdict: which causes are named, which remain ambiguous, or that there is
// no discrepancy.

#include "diagnosis/inference/search_result.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// Sets the ranking of all observable causes with none and unknown, the verdict, the named causes and the ambiguous
/// set.
void decide(const Problem& problem, const SearchResult& found, Diagnosis& out);

}  // namespace thermotwin::diagnosis
