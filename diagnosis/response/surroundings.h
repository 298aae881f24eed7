// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the surroundings of a machine may do beside what is recorded of them.

#include <vector>

#include "diagnosis/record/observations.h"
#include "diagnosis/record/several_records.h"
#include "diagnosis/response/propagation.h"

namespace thermotwin::diagnosis {

/// @return triangles of each ambient in turn along each record, with their standard deviations
std::vector<Disturbance> surroundings(const mesh::Machine& machine, Records records, const Observations& obs);

}  // namespace thermotwin::diagnosis
