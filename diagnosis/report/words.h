// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A diagnosis in words: the verdict in a sentence, and what a reader has to know beside it.

#include <string>

#include "diagnosis/inference/model_search.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

std::string sentence_of(const Diagnosis& diagnosis);

/// A change in percent; no minus before a zero.
std::string percent_text(double percent, int decimals = 0);

/// What of a record may mislead: inputs that the machine has and nobody recorded, poses that leave axes out, readings
/// that never change, a start that is not even, changes between rows that are far apart.
std::vector<std::string> warnings_of(const mesh::Machine& machine, const compensation::Measurement& measurement,
                                     const Problem& problem);

/// How long a record it is, what was left out, how the start was taken, what is not visible.
void add_notes(const reduction::ReducedModel& model, const Problem& problem, const SearchResult& found,
               const DiagnoseOptions& options, Diagnosis& out);

}  // namespace thermotwin::diagnosis
