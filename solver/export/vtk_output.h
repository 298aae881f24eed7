// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Results for ParaView: one .vtu per output time with all bodies at the pose, point arrays
// temperature_C, displacement_um and, where given, stress_MPa (xx yy zz xy yz zx) and
// von_mises_MPa (machine frame), cell array body; quadratic meshes as quadratic cells; a .pvd with the times; field
// data with pose and case. The poses' error vectors as .vtp for glyphs. Pictures by VTK's own
// renderer (needs a display: xvfb-run -a).

#include <filesystem>
#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"
#include "solver/elastic/tcp.h"

namespace thermotwin::solver {

/// @param temperature_C (nodes)  @param displacement (3 x nodes) m, bodies' home frames; no columns: left out
/// @param time_s  kept as field data TimeValue
/// @param stress  (6 x nodes) Pa, bodies' home frames, see MachineStress; no columns: left out
void write_fields(const std::filesystem::path& path, const mesh::MachineMesh& mesh, const mesh::Pose& pose,
                  const Eigen::VectorXd& temperature_C, const Eigen::Matrix3Xd& displacement, double time_s = 0.0,
                  const Eigen::MatrixXd& stress = {});

/// @param files  relative names with their times in s
void write_pvd(const std::filesystem::path& path, const std::vector<std::pair<double, std::string>>& files);

/// Points at the TCP positions with error_um (3), error_tool_um, error_table_um, rotation_um_per_m.
void write_poses(const std::filesystem::path& path, const mesh::Machine& machine, const std::vector<mesh::Pose>& poses,
                 const std::vector<TcpError>& errors);

}  // namespace thermotwin::solver
