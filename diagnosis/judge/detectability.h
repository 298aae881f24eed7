// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a record can show at all: the size from which each kind of cause would be seen.

#include <vector>

#include "diagnosis/inference/model_search.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// In the order of the kinds; kinds that the machine does not offer are left out. A size is seen where it is
/// sqrt(2 ln(e^strong)) = 4.5 standard deviations of its estimate.
std::vector<Detectable> detectability(const Problem& problem, const SearchResult& found);

}  // namespace thermotwin::diagnosis
