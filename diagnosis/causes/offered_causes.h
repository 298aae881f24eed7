// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Every cause that machine and measurement offer.

#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/causes/parameter.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// Every parameter of every kind that machine and measurement offer.
/// @param with_parts  those that need the matrices of single parts, too   @param told_row_s  as
///   Observations::told_row_s
std::vector<Parameter> candidate_parameters(const mesh::Machine& machine, const compensation::Measurement& measurement,
                                            bool with_parts = false, double told_row_s = 0.0);

}  // namespace thermotwin::diagnosis
