// SPDX-License-Identifier: GPL-3.0-or-later
// Example 2: a machine, a load program and the error at the tool centre point (TCP).
//
// Elasticity is linear and quasi-static, so the TCP error of a pose is a linear functional of the temperature field:
//
//   error = C T,   T in K above the machine's reference temperature.
//
// ElasticModel computes the rows C once for a pose, by adjoint solves; a time step then costs a product. The example
// runs a load program on the full model and checks the rows against the displacement field of the last temperature.
//
// Usage: 02_machine [CASE]    CASE: a folder with machine.toml, case.toml and loads/; default: the toy machine
#include <algorithm>
#include <cstdio>

#include "core/error.h"
#include "core/progress.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/case.h"
#include "solver/elastic/tcp.h"

using namespace thermotwin;
namespace units = core::units;

namespace {

int run(const char* folder) {
  // 1. The case: a machine, its load programs and a mesh size. Every value and every id has been checked.
  const solver::Case machine_case = solver::read_case(folder);
  const mesh::Machine& machine = machine_case.machine;
  const solver::LoadProgram load = machine_case.load(machine_case.train.back());

  // 2. The full model: meshes of all bodies, matrices of heat, factors of elasticity.
  mesh::MeshOptions meshing;
  meshing.size_factor = mesh::size_factor(machine, machine_case.size);
  const solver::FullModel full = solver::build_full_model(machine, meshing);
  std::printf("%s: %zu bodies, %td nodes, %zu joints\n", machine.name.c_str(), machine.bodies.size(), full.mesh.nodes(),
              machine.joints.size());

  // 3. Rows of one pose. A pose has a position for each axis, in m or rad; parse_pose() takes mm and deg. The table
  //    side has two parts, because the table turns with its rotary axis.
  const mesh::Pose pose =
      machine_case.check_points.empty() ? mesh::home_pose(machine) : machine_case.check_points.front();
  const solver::OutputRows rows = full.elastic.output_rows(pose);
  const auto tcp_error_um = [&](const Eigen::VectorXd& temperature) -> Eigen::Vector3d {
    const solver::TcpError tcp = solver::tcp_error(machine, pose, rows.tool * temperature,
                                                   rows.table_axis * temperature, rows.table_own * temperature);
    return tcp.error.head<3>() / units::um;  // dx dy dz; then three rotations
  };

  // 4. The load program on the full model. on_output is called at each output time; a campaign keeps tables beside.
  solver::CampaignOptions options;
  options.poses = {pose};
  Eigen::VectorXd last;
  std::printf("%s at %s\n  time_h    dx_um    dy_um    dz_um\n", load.title().c_str(),
              mesh::format_pose(machine, pose).c_str());
  options.on_output = [&](const solver::LoadProgram&, const solver::OutputState& output) {
    last = output.state;
    const Eigen::Vector3d error_um = tcp_error_um(last);
    if (output.index % 3 == 0)
      std::printf("%8.2f %8.2f %8.2f %8.2f\n", output.time / units::hour, error_um.x(), error_um.y(), error_um.z());
  };
  const solver::LoadResult result = solver::run_campaign(full, {load}, options).front();
  std::printf("%s\n", result.heat->brief().c_str());

  // 5. The same from displacements of all nodes: a solve for this temperature instead of a product.
  const Eigen::Matrix3Xd displacement = full.elastic.displacement(last, pose);
  const solver::ElasticModel::Outputs direct = full.elastic.outputs_of(displacement, pose);
  const double tool_um = (direct.tool - rows.tool * last).head<3>().norm() / units::um;
  const double table_um = (direct.table_axis - rows.table_axis * last).head<3>().norm() / units::um;
  std::printf(
      "largest displacement %.1f um; rows and displacements differ by %.1e um at the tool, %.1e um at the table\n",
      displacement.colwise().norm().maxCoeff() / units::um, tool_um, table_um);

  const double table_dx = result.tcp.column("dx_um").tail<1>()[0];
  const bool same_table = std::abs(table_dx - tcp_error_um(last).x()) < 1e-6;
  return std::max(tool_um, table_um) < 1e-4 && result.heat->gap() < 1e-8 && same_table ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  core::set_quiet(true);  // else progress goes to stderr
  try {
    return run(argc > 1 ? argv[1] : TOY_CASE);
  } catch (const core::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return error.exit_status();
  }
}
