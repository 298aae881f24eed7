// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Places for temperature sensors: nodes of the skin, thinned to a spacing, without those that cannot be reached.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "mesh/machine_mesh.h"

namespace thermotwin::study {

struct PlaceRules {
  double spacing = 0.06;             ///< m, least distance of two places on a body
  std::vector<std::string> bodies;   ///< only on these; empty: on all elastic bodies
  std::vector<std::string> without;  ///< bodies and surfaces without sensors
  bool on_contacts = false;          ///< places on surfaces of joints, which the other side covers
  bool on_rotating = false;          ///< bodies that turn with a spindle or an endless axis, which no cable reaches
};

struct Place {
  int body = 0;
  Eigen::Index node = 0;  ///< global number in the mesh
  Eigen::Vector3d point;  ///< m, home frame
};

/// @return the places, body by body; of two that are nearer than the spacing the one with the smaller number
/// @throws InputError for unknown ids (with the nearest known), or if no place is left
std::vector<Place> sensor_places(const mesh::MachineMesh& mesh, const PlaceRules& rules);

}  // namespace thermotwin::study
