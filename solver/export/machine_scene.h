// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The machine in 3-D for a page: its skin, coloured by temperature and displaced, over time, for each load and pose;
// the errors of the workspace as arrows. Fields are few modes at the skin's vertices times coefficients over time,
//   T(v, t) = T_ref + sum_k M_k(v) a_k(t),   u(v, t, pose) = sum_j w_j(pose) sum_k U_kj(v) a_k(t),
// U_kj the displacement under mode k at key pose j (corners of the workspace), w_j linear in each axis. A script adds
// them up; nothing is fetched.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "core/table.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_fields.h"
#include "solver/export/skin.h"

namespace thermotwin::solver {

/// Poses with displacement fields, and what each pose of a grid takes of them.
struct KeyPoses {
  std::vector<mesh::Pose> poses;
  Eigen::MatrixXd weights;  ///< (poses of the grid x key poses), rows add up to one
};
/// Corners in at most three axes that the grid moves, the linear ones first; other axes in mid-position.
KeyPoses key_poses(const mesh::Machine& machine, const std::vector<mesh::Pose>& grid);

struct SceneLoad {
  std::string name;
  Eigen::VectorXd hours;         ///< (times)
  Eigen::MatrixXd coefficients;  ///< (modes x times); no columns: no fields of this load are at hand
  Eigen::MatrixXd errors_um;     ///< (3 poses x times) dx dy dz of each pose
};
/// @param tcp  as of a campaign: a row for each time and pose  @param coefficients  of the thinned times
SceneLoad scene_load(const std::string& name, const core::Table& tcp, Eigen::Index poses,
                     const Eigen::MatrixXd& coefficients);

struct MachineScene {
  mesh::Machine machine;
  Skin skin;  ///< may be empty: arrows only
  std::vector<mesh::Pose> poses;
  KeyPoses keys;
  Eigen::MatrixXd temperature;  ///< (vertices x modes) K
  std::vector<Eigen::MatrixXd>
      displacement;      ///< one a key pose: (3 vertices x first modes) m, home frames; empty: none
  Eigen::MatrixXd turn;  ///< (order x modes): coefficients = turn^T reduced state; may be empty
  std::vector<SceneLoad> loads;
  std::string first_load{};  ///< that the page shows first; empty: the one with the largest error
};

inline constexpr Eigen::Index scene_modes = 14;
inline constexpr Eigen::Index displaced_modes = 10;  ///< of them, at most

/// Skin, poses of the workspace grid, and modes on the skin; no loads yet. @param modes (size x m) K
MachineScene make_scene(const FullModel& full, const Eigen::MatrixXd& modes);

/// A section of a page; the view may be given behind the address: `#load=2&pose=5&time=0.5&turn=0.4`.
std::string machine_scene_html(const MachineScene& scene);

}  // namespace thermotwin::solver
