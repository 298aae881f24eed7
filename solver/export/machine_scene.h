// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// 3-D view of the machine for a page: the skin over time for each load and pose, coloured by temperature and displaced,
// with the TCP errors of the workspace as arrows. A field is a sum of few modes at the skin's vertices, each times a
// coefficient over time:
//   T(v, t) = T_ref + sum_k M_k(v) a_k(t),   u(v, t, pose) = sum_j w_j(pose) sum_k U_kj(v) a_k(t).
// M_k is a mode of the temperature, U_kj the displacement under mode k at key pose j (a corner of the workspace), and
// w_j is linear in each axis. A script of the page computes the sums; the page loads nothing from elsewhere.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "core/table.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_fields.h"
#include "solver/export/skin.h"

namespace thermotwin::solver {

/// Poses with displacement fields, and the weights of these fields at each pose of a grid.
struct KeyPoses {
  std::vector<mesh::Pose> poses;
  Eigen::MatrixXd weights;  ///< (poses of the grid x key poses), rows add up to one
};
/// Corners of the grid in at most three axes that have several positions, linear ones first. Every other axis stands at
/// the middle one of its positions in the grid.
KeyPoses key_poses(const mesh::Machine& machine, const std::vector<mesh::Pose>& grid);

struct SceneLoad {
  std::string name;
  Eigen::VectorXd hours;         ///< (times)
  Eigen::MatrixXd coefficients;  ///< (modes x times); no columns: this load has no fields
  Eigen::MatrixXd errors_um;     ///< (3 poses x times) dx dy dz of each pose
};
/// @param tcp  tcp.csv of a campaign: a row for each time and pose
/// @param coefficients  (modes x times) at LoadFields::most_times of these times at most
SceneLoad scene_load(const std::string& name, const core::Table& tcp, Eigen::Index poses,
                     const Eigen::MatrixXd& coefficients);

struct MachineScene {
  mesh::Machine machine;
  Skin skin;  ///< may be empty: arrows only
  std::vector<mesh::Pose> poses;
  KeyPoses keys;
  Eigen::MatrixXd temperature;  ///< (vertices x modes) K
  std::vector<Eigen::MatrixXd>
      displacement;      ///< for each key pose: (3 vertices x displaced modes) m, home frames; empty: none
  Eigen::MatrixXd turn;  ///< (order x modes): coefficients = turn^T reduced state; may be empty
  std::vector<SceneLoad> loads;
  std::string first_load{};  ///< that the page shows first; empty: the one with the largest error
};

inline constexpr Eigen::Index scene_modes = 14;
inline constexpr Eigen::Index displaced_modes = 10;  ///< of them, at most

/// Skin, poses of the workspace grid, and modes on the skin; no loads yet. @param modes (size x m) K
MachineScene make_scene(const FullModel& full, const Eigen::MatrixXd& modes);

/// A section of a page. The fragment of its address may set the view: `#load=2&pose=5&time=0.5&turn=0.4`, with load and
/// pose from 0, time as a share of the load's times, and turn in rad.
std::string machine_scene_html(const MachineScene& scene);

}  // namespace thermotwin::solver
