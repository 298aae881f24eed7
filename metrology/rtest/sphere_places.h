// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Places of the sphere on the table that the nominal points of an R-Test mean: the table's frame at the axis positions
// takes the points of one sphere to one place. Points that contradict the positions go to many.

#include <Eigen/Core>

#include <string>

#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

struct SpherePlaces {
  Eigen::Index count = 0;  ///< places further apart than 1 mm
  bool is_cut = false;     ///< counting stopped there
  std::string doubt;       ///< a warning: why the nominal points and the axis positions do not fit; empty: none
};

SpherePlaces sphere_places(const RTestRecord& record);

}  // namespace thermotwin::metrology
