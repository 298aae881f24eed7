// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Steps in readings that describe something unknown best, and what of the machine changed just before.

#include <string>
#include <vector>

#include "diagnosis/inference/search_result.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// @return the steps in readings that describe something unknown best, where it has 0.5 or more; else none
StepsSeen steps_seen(const Problem& problem, const SearchResult& found);

/// Inputs of the machine that changed within half an hour before one of the steps, at most four: states first, then
/// speeds, feeds and powers.
std::vector<std::string> inputs_before(const Observations& observations, const mesh::Machine& machine,
                                       const StepsSeen& seen);

}  // namespace thermotwin::diagnosis
