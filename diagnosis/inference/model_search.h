// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Which change of the machine explains a measurement: no cause, every single cause, every pair, and
// "unknown" (something that wanders freely on every channel and that no parameter describes) compete
// by prior weight times evidence. Single causes are compared at first on the nominal linearisation; the
// leading ones are then re-linearised about their own estimate (Gauss-Newton), since a film at a third of its
// nominal value does not act as two thirds of a small change. Pairs grow from these: every second cause beside
// a leading one, on the linear form about that one's estimate; the leading pairs are fitted in turn.

#include "diagnosis/inference/search_options.h"
#include "diagnosis/inference/search_result.h"
#include "diagnosis/response/problem.h"
#include "diagnosis/response/response.h"

namespace thermotwin::diagnosis {

SearchResult search(const Problem& problem, const Response& response, const mesh::Machine& machine,
                    const SearchOptions& options = {});

}  // namespace thermotwin::diagnosis
