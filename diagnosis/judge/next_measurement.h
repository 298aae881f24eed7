// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Proposes the next measurement for an ambiguous set of causes: of all load programs, sensors and poses of the machine,
// those at which the predictions of the causes differ most, in units of what a reading is
// uncertain by: the channel's uncertainty and the discretisation error of its response.

#include <string>
#include <vector>

#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/response/problem.h"
#include "solver/operation/load_program.h"

namespace thermotwin::diagnosis {

/// What may be the case, with what it foretells: one cause, several together, or none.
struct Rival {
  std::vector<RankedCause> causes;  ///< empty: the machine as stated
  double probability = 0;
  bool alone = false;  ///< others have one cause more
  std::string name() const;
};

/// Causes that are named are true together: one rival, and each cause that shares beside them makes another. Where none
/// is named, each of those that share is one; the most probable ones where none shares. The machine as stated stands
/// beside a single one. What something unknown does elsewhere nobody knows.
std::vector<Rival> rivals_of(const Diagnosis& diagnosis);

/// @param programs  possible load programs, in addition to a repetition of the measured load with more channels
NextMeasurement next_measurement(const Problem& problem, const reduction::ReducedModel& model,
                                 const std::vector<solver::LoadProgram>& programs, const Diagnosis& diagnosis,
                                 const DiagnoseOptions& options);

/// Whether a planned program is the load of a record again: its inputs have the record's values, but for 5 % of their
/// range in the mean. An input that either does not state does not count.
bool repeats(const Observations& plan, const Observations& record);

/// What is left to know where nothing has to be decided: kinds of which the record would have shown nothing, which a
/// measurement of another place or load would have to show. One sentence without its full stop.
std::string nothing_to_decide(const std::vector<Detectable>& kinds);

}  // namespace thermotwin::diagnosis
