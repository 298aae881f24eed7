// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Lists the candidate causes of a machine and a measurement.

#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/causes/parameter.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// @return the parameters of all kinds that the machine and the measurement offer
/// @param with_parts  include those that need the matrices of single parts
/// @param told_row_s  as Observations::told_row_s
std::vector<Parameter> candidate_parameters(const mesh::Machine& machine, const compensation::Measurement& measurement,
                                            bool with_parts = false, double told_row_s = 0.0);

/// Sources that only a measured power drives, and whose power the measurement does not have: they count as 0 W.
std::vector<const mesh::SourceSpec*> unrecorded_sources(const mesh::Machine& machine,
                                                        const compensation::Measurement& measurement);

}  // namespace thermotwin::diagnosis
