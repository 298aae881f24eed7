// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pauses of a log: what the machine did in them is unknown, beyond the rows on both sides.

#include <Eigen/Core>

#include <vector>

#include "compensation/measurement/channel.h"
#include "diagnosis/record/observations.h"

namespace thermotwin::diagnosis {

/// A speed, power or state, and its largest value in the record.
struct Watched {
  Eigen::Index channel;
  double largest;  ///< magnitude
};

/// Each watched input of the row before a pause may have been another one in any part of it: what stood ran as fast as
/// ever in the record, what ran stood, and an axis was where it is farthest from there. Parts are short before the end
/// of the pause, which the rows after it show best. Adds to may_hold; of many pauses the longest are taken.
/// @param rows  (rows x channels of the machine)  @param inputs  the machine's channels
void add_unknown_operation(const Eigen::VectorXd& time, const Eigen::MatrixXd& rows,
                           const std::vector<compensation::Channel>& inputs, const std::vector<Watched>& watched,
                           Observations& out);

/// Temperatures wander on through a pause: in its steps they lie between those of the rows on both sides.
void let_wander(const Eigen::VectorXd& time, const Eigen::MatrixXd& rows,
                const std::vector<compensation::Channel>& inputs, Observations& out);

}  // namespace thermotwin::diagnosis
