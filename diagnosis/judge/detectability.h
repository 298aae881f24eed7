// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Detectability: the smallest change of each kind of cause that a record would show.

#include <vector>

#include "diagnosis/inference/model_search.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// A change counts as shown from sqrt(2 `strong`) = 4.5 standard deviations on, with `strong` = 10, the ln Bayes factor
/// of strong evidence (decision.h). This standard deviation is the root of the sum of squares of the estimate's and of
/// the nominal value's stated one.
/// @return one entry for each kind, in the order of the kinds; kinds that the machine does not offer are left out
std::vector<Detectable> detectability(const Problem& problem, const SearchResult& found);

}  // namespace thermotwin::diagnosis
