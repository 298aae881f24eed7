// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The temperature field of a machine that was not in equilibrium when a record began: its slowest modes, and what
// warmed it before.

#include <Eigen/Core>

#include "diagnosis/record/observations.h"
#include "diagnosis/response/propagation.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::diagnosis {

inline constexpr double even_start_K = 0.3;  ///< first readings that differ by less begin from one temperature

/// K0 + sum p K of a machine as a record begins. (r x r), symmetric
Eigen::MatrixXd conduction_at_start(const reduction::ReducedModel& model, const mesh::Machine& machine,
                                    const Observations& observations);

/// What a machine may be warmed by when a record begins: modes of the first row with time constants of half an hour
/// and more, the slowest first, each of 1 K in the mean of squares over the heat capacity. (r x modes); none where
/// the first readings agree
Eigen::MatrixXd start_modes(const reduction::ReducedModel& model, const mesh::Machine& machine,
                            const Observations& observations);

/// What each of Observations::before leaves of it at the start, K. (r x before); none where the first readings agree
Eigen::MatrixXd earlier_operation(const Nominal& nominal);

/// Whether first readings tell that something ran before the record.
bool begins_warm(const Observations& record);

/// Prior standard deviation of the uniform start, K.
double start_std(const Observations& record);

}  // namespace thermotwin::diagnosis
