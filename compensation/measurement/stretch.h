// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// How long a training record was watched without a break: what is slower than a third of that cannot
// be told from a ramp, however many such experiments there are.

#include "compensation/measurement/dataset.h"

namespace thermotwin::compensation {

/// Longest time between two known targets with no gap above ten usual intervals, at least an hour,
/// between them, s; 0 with fewer than two.
double longest_stretch(const TrainingData& data);

/// Median of the intervals, s; 0 with fewer than two rows.
double usual_interval(const Eigen::VectorXd& time);

}  // namespace thermotwin::compensation
