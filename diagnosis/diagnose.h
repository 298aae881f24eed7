// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Diagnoses a measurement: residuals against their uncertainty, hypotheses ranked by evidence, the extended machine,
// and its gain on held-out data. The model is linear-Gaussian. It consists of the reduced model's response to each
// parameter (exact finite differences along the measured inputs), the stated uncertainties of all parameters as
// nuisance parameters, sensor noise, and a model error for the discretisation. A cause has a wide prior instead of its
// stated one, and its size is then refined by Gauss-Newton.

#include <filesystem>
#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/report/scene.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/load_program.h"

namespace thermotwin::diagnosis {

/// @throws InputError if the measurement does not fit the machine; SolverError
Diagnosis diagnose(const reduction::ReducedModel& model, const compensation::Measurement& measurement,
                   const DiagnoseOptions& options);

/// Diagnoses several records of one machine together. A cause holds in all of them. An offset, drift or clock error of
/// a reading holds in all or in one. The end of each record is held out.
/// @param records  one or more
Diagnosis diagnose(const reduction::ReducedModel& model, std::vector<compensation::Measurement> records,
                   const DiagnoseOptions& options);

}  // namespace thermotwin::diagnosis
