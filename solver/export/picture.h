// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pictures by VTK's own renderer, which lies in a module (vtk_picture_module.h). Needs a display: xvfb-run -a.

#include <Eigen/Core>

#include <filesystem>
#include <string>

#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"

namespace thermotwin::solver {

/// @return whether there is a display to draw on (DISPLAY is set and not empty)
bool has_display();

/// Picture of temperature on the deformed machine. @param temperature_C  (nodes)  @param displacement  (3 x nodes) m
/// @param exaggeration  factor on the displacement
/// @throws SolverError where there is no display to draw on (has_display)
void write_picture(const std::filesystem::path& png, const mesh::MachineMesh& mesh, const mesh::Pose& pose,
                   const Eigen::VectorXd& temperature_C, const Eigen::Matrix3Xd& displacement, double exaggeration,
                   const std::string& title);

}  // namespace thermotwin::solver
