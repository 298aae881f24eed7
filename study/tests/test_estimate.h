// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Estimates the parameters of a machine from its measured test: maximum a posteriori of test_run.h, linearised anew
// about each estimate (Gauss-Newton).

#include <Eigen/Core>

#include "compensation/measurement/measurement.h"
#include "reduction/model/reduced_model.h"
#include "study/tests/test_run.h"

namespace thermotwin::study {

/// @param test      the load program that was run, as a block with its readings of the probe
/// @param measured  rows of all its sensors, and of dx, dy, dz at the probe's pose
/// @return (parameters) values  @throws InputError for a channel that is missing
Eigen::VectorXd estimate(const reduction::ReducedModel& model, const TestSetup& setup, const TestBlock& test,
                         const compensation::Measurement& measured, int rounds = 3);

}  // namespace thermotwin::study
