// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Effects with a place of their own on the full model: single bodies, tapes, screws and joints that are
// not as the machine says, and heat on a spot of the skin that no source has.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "specimen.h"

namespace thermotwin::hidden {

/// What truths of parts change in a specimen's matrices; empty where nothing does.
struct WrongParts {
  solver::SparseMatrix capacity;         ///< (size x size) J/K, added to E
  std::vector<solver::OutputRows> rows;  ///< (poses) added to the output rows, at the effect's full size
};

/// @param right   output rows of the specimen at the poses
/// @param uneven  (size) a capacity or an expansion that is off is so by this share from place to place
WrongParts wrong_parts(const solver::FullModel& full, const std::vector<Truth>& truths,
                       const std::vector<mesh::Pose>& poses, const std::vector<solver::OutputRows>& right,
                       const Eigen::VectorXd& uneven);

/// A place on the skin of the machine's bodies, all areas alike: its body and where, m, home frame.
std::pair<std::string, Eigen::Vector3d> drawn_place(const mesh::MachineMesh& mesh, Random& random);

/// 1 W on the skin of a body about a place, a bell of 3 cm. (size)
Eigen::VectorXd warm_spot(const solver::FullModel& full, const std::string& body, const Eigen::Vector3d& centre);

}  // namespace thermotwin::hidden
