// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The candidate causes of several records of one machine. What is wrong with the machine holds in all of them. What is
// wrong with a reading holds in all of them or, of offsets, drifts and clocks, in one alone.

#include <vector>

#include "diagnosis/causes/parameter.h"
#include "diagnosis/record/observations.h"
#include "diagnosis/record/several_records.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// @param observations  of the records
/// @return of a single record candidate_parameters(); of several each cause once, with the largest spread that one of
///   them gives it
std::vector<Parameter> candidates_of_records(const mesh::Machine& machine, Records records,
                                             const Observations& observations, bool with_parts);

}  // namespace thermotwin::diagnosis
