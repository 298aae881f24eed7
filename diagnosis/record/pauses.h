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

/// Each watched input, and each axis, may have been another one in any part of a pause than what the model takes: what
/// runs with at least half of its largest value stood, anything else ran as fast as ever in the record, and an axis
/// stood where it is farthest from there. The last part of a pause takes 5 min, those before it get longer, so that the
/// rows after it can tell them apart. The same holds of the time before the record. Adds to may_hold, and fills before.
/// Where there are too many, parts are longer; pauses that still do not fit are left out, the shortest first. The steps
/// of the model are there already.
/// @param rows  (rows x channels of the machine)  @param inputs  the machine's channels
/// @param watched    those that the record has a column of
/// @param in_pauses  whether anything may have run in them
void add_unknown_operation(const Eigen::MatrixXd& rows, const std::vector<compensation::Channel>& inputs,
                           const std::vector<Watched>& watched, bool in_pauses, Observations& out);

/// Temperatures wander on through a pause: in its steps they lie between those of the rows on both sides.
void let_wander(const Eigen::VectorXd& time, const Eigen::MatrixXd& rows,
                const std::vector<compensation::Channel>& inputs, Observations& out);

}  // namespace thermotwin::diagnosis
