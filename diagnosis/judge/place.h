// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A place on a body in the words of somebody who stands before the machine.

#include <Eigen/Core>

#include <string>

#include "diagnosis/judge/diagnosis.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::diagnosis {

/// The part of a body's skin that is nearest to a point, by the centres of the model's patches: a mean over patches may
/// lie inside of the body. And the named surface that is nearest to it: by the boxes of its rules, else by the patches
/// that lie on it; none where none is within half a metre. Neither the whole skin nor a group of a mesh is a place.
/// @param at  m, home frame
PlaceOfCause place_of(const std::string& body, const Eigen::Vector3d& at, const reduction::ReducedModel& model);

/// Side of the body, height above the table, nearest named surface and sensor. @param at  m, home frame
std::string place_in_words(const std::string& body, const Eigen::Vector3d& at, const reduction::ReducedModel& model);

}  // namespace thermotwin::diagnosis
