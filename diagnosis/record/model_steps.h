// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The steps on which a model runs along a record, from its rows: rows of equal operation are joined, times of changes
// that the rows leave open are kept.

#include <Eigen/Core>

#include "compensation/measurement/measurement.h"
#include "diagnosis/record/observations.h"
#include "solver/operation/channels.h"

namespace thermotwin::diagnosis {

/// Fills points, rows, mixed, may_hold, before, open_changes, pauses and told_row_s; the interval is there already.
/// @param rows  (rows x channels of the machine) of the record
void set_model_steps(const compensation::Measurement& measurement, const solver::Channels& channels,
                     const Eigen::MatrixXd& rows, const ObserveOptions& options, Observations& out);

}  // namespace thermotwin::diagnosis
