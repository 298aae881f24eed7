// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Writes a diagnosis as text: the verdict as a sentence, warnings and notes.

#include <string>

#include "diagnosis/inference/model_search.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// @return the verdict with its evidence and the next step
std::string sentence_of(const Diagnosis& diagnosis);

/// @return a change in percent, without a minus before a zero
std::string percent_text(double percent, int decimals = 0);

/// @return warnings about a record that may mislead: inputs of the machine that were not recorded, incomplete poses,
///   constant readings, an uneven initial temperature, changes of inputs where rows are more than a minute apart
std::vector<std::string> warnings_of(const mesh::Machine& machine, const compensation::Measurement& measurement,
                                     const Observations& observations);

/// Adds notes on the length of the record, left-out channels, the initial temperature and unobservable causes.
void add_notes(const reduction::ReducedModel& model, const Problem& problem, const SearchResult& found,
               const DiagnoseOptions& options, Diagnosis& out);

}  // namespace thermotwin::diagnosis
