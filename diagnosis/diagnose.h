// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Diagnosis of a measurement: residuals against uncertainty, hypotheses ranked by evidence, the
// extended machine, the gain on held-out time. Linear-Gaussian at its core: the reduced model's
// response to each parameter (exact finite differences along the measured inputs), nominal
// uncertainties of all parameters as nuisances, sensor noise, and a model error term for the mesh;
// a cause has a wide prior instead of its nominal one, its size is then refined by Gauss-Newton.

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

Diagnosis diagnose(const reduction::ReducedModel& model, const compensation::Measurement& measurement,
                   const DiagnoseOptions& options);

}  // namespace thermotwin::diagnosis
