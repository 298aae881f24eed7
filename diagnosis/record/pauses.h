// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pauses of a log: what the machine did in them is unknown, beyond the rows on both sides.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/record/observations.h"

namespace thermotwin::diagnosis {

/// A speed, power or state, and its largest value in the record.
struct Watched {
  Eigen::Index channel;
  double largest;  ///< magnitude
};

/// Each watched input of the row before a pause may have been another one in any part of it: what stood ran as fast as
/// ever in the record, what ran stood. Parts are short before the end of the pause, which the rows after it show best.
/// Fills pauses, and adds to may_hold. Of many pauses the longest are taken.
/// @param rows  (rows x channels of the machine)
/// @param begins  of the pauses, the row before each
void add_pauses(const Eigen::VectorXd& time, const Eigen::MatrixXd& rows, const std::vector<Watched>& watched,
                std::vector<Eigen::Index> begins, Observations& out);

}  // namespace thermotwin::diagnosis
