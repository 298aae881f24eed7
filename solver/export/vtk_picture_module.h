// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The module that draws pictures, and brings VTK's renderer, OpenGL and X11 with it.

#include <Eigen/Core>

#include <string>

namespace thermotwin::solver {

/// What is drawn: a coloured surface, seen from the front right.
struct PictureScene {
  Eigen::Matrix3Xd points;        ///< m
  Eigen::Matrix3Xi triangles;     ///< indices into points
  Eigen::VectorXf temperature_C;  ///< (points)
  double low_C = 0, high_C = 1;   ///< ends of the colour map
  std::string title, note;
};

/// The module's function thermotwin_draw. @param png  receives the bytes of the file; empty: no memory
using DrawPicture = void (*)(const PictureScene& scene, std::string& png);

}  // namespace thermotwin::solver
