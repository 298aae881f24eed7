// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The page of `run`: the machine in 3-D, what compensation removes, how good the reduced model is, the diagnosis.

#include <string>

#include "compensation/evaluation/validation.h"
#include "diagnosis/judge/diagnosis.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "tools/chain.h"
#include "tools/options.h"

namespace thermotwin::tools {

struct RunResults {
  const solver::Case& machine_case;
  const RunOptions& options;
  const solver::FullModel& full;
  const ReducedCase& made;
  const compensation::Validation& validation;
  const diagnosis::Diagnosis& diagnosed;
  std::string hidden;  ///< what a measurement that was made here contains; empty: it was not
};

/// Writes scene.bin beside the model too, for the page of `campaign --reduced`.
std::string run_page(const RunResults& results);

}  // namespace thermotwin::tools
