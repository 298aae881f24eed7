// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Diagnosis of data that no machine model belongs to: a lag model of the record's first part is the simulation.

#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"

namespace thermotwin::diagnosis {

/// @param options  interval_s is used
/// @throws InputError: no input, no displacement, a record too short to be divided
Diagnosis diagnose_data(const compensation::Measurement& measurement, const DiagnoseOptions& options);

}  // namespace thermotwin::diagnosis
