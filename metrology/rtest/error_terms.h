// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The parameters of a kinematic chain that points can show: location errors, X0C to R0T, and component errors of linear
// axes. The component error E(x) of an axis is a polynomial of its position, E(x) = sum_n c_n (x / 1 m)^n, n from 1 to
// 3, and 0 at position 0, where the location error has its value. "EYX2" is c_2 of the straightness of X along y.
// "EXX1" is the growth of the scale of X, "EBX1" a rotation about y in proportion to the position. What moves is what
// the axis carries, at the axis' point and in the frame of the body on which it stands, as with a location error
// (compensation/chain/location_offsets.h). Names of the errors follow ISO 230-1.

#include <Eigen/Core>

#include <map>
#include <string>
#include <vector>

#include "compensation/chain/location_offsets.h"

namespace thermotwin::metrology {

struct ErrorTerm {
  std::string name;     ///< "X0C", "EYX2"
  std::string located;  ///< location error whose motion it has: "Y0X"
  std::string axis;     ///< of the position; of a location error empty
  int power = 0;
};

inline constexpr int highest_power = 3;

/// @throws InputError (place) for a name that the chain does not have
std::vector<ErrorTerm> error_terms(const std::vector<std::string>& names, const compensation::LocationOffsets& map,
                                   const mesh::KinematicChain& chain, const std::string& place);

/// Share of one SI unit of the term in the deviation tool - workpiece, m, machine frame.
Eigen::Vector3d shift_of(const ErrorTerm& term, const compensation::LocationOffsets& map,
                         const std::map<std::string, double>& positions, const Eigen::Vector3d& point);

/// "um", "um/m", "um/m2" ... @param name  of an error of a chain, or dx ... rc
std::string unit_of_error(const std::string& name);
std::vector<std::string> units_of_errors(const std::vector<std::string>& names);

}  // namespace thermotwin::metrology
