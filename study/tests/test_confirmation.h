// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Confirms a test on machines measured virtually: the full model on a finer mesh with perturbed values and noise runs
// the test, the parameters are estimated from it, and the reduced model with them predicts load programs that the same
// machine runs too.

#include <filesystem>
#include <string>
#include <vector>

#include "reduction/model/reduced_model.h"
#include "solver/campaign/case.h"
#include "study/tests/test_run.h"

namespace thermotwin::study {

struct ConfirmedTest {
  std::string name, text;  ///< of its load program
};

/// RMS over times and check points of the error of the predicted translations since the start, um.
struct ConfirmedMachine {
  double nominal_um = 0;         ///< with the values of machine.toml
  std::vector<double> tests_um;  ///< with those estimated from each test
};

/// @param loads  names of the predicted load programs  @param keep  folder of the measured machines
/// @param cache  of meshes
std::vector<ConfirmedMachine> confirm_tests(const solver::Case& machine_case, const reduction::ReducedModel& model,
                                            const TestSetup& setup, const std::vector<ConfirmedTest>& tests,
                                            const std::vector<std::string>& loads, int draws,
                                            const std::filesystem::path& keep, const std::filesystem::path& cache);

}  // namespace thermotwin::study
