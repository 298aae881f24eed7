// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Weights that interpolate a value known at some poses to another pose, by the highest of these polynomials that the
// poses determine: triquadratic (3 x 3 x 3), quadratic with products (face-centred cube), multilinear (corners), linear
// (Okenka et al.), constant. The weights are the least-squares solution of smallest norm.

#include <Eigen/Core>

#include <map>
#include <string>
#include <vector>

namespace thermotwin::compensation {

/// Axis positions by name from "X=1,B=45" (mm, deg); axes that are not named stand at 0.
std::map<std::string, double> pose_of_text(const std::string& text);

/// @param known  poses at which the value is known  @param at  pose to interpolate to
/// @return (known) weights; their sum is 1
Eigen::VectorXd workspace_weights(const std::vector<std::string>& known, const std::string& at);

}  // namespace thermotwin::compensation
