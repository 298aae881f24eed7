// SPDX-License-Identifier: GPL-3.0-or-later
// cases/turnmill: the machine loads, meshes and runs; its milling head behaves alike in both of its positions.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

#include "core/table.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/output_grid.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

std::string turnmill() {
  return (toy_case().parent_path().parent_path().parent_path() / "cases" / "turnmill").string();
}

TEST(Turnmill, IsReadWithItsHeadOnTheToolSide) {
  const mesh::Machine machine = mesh::read_machine(turnmill() + "/machine.toml");
  EXPECT_EQ(machine.workspace.axes, (std::vector<std::string>{"Z", "X", "B"}));
  EXPECT_TRUE(machine.workspace.table_axes.empty());
  EXPECT_EQ(mesh::workspace_poses(machine).size(), 27U);
  const reduction::OutputGrid grid(machine);
  EXPECT_EQ(grid.table_poses().size(), 1U) << "the main spindle's outputs turn with it by themselves";

  // Between the stored angles of B, what is fixed to the head follows sine and cosine.
  const int b = machine.axis_index("B");
  mesh::Pose pose = mesh::home_pose(machine);
  pose[b] = 0.3;
  Eigen::VectorXd weights;
  grid.tool_weights(pose, weights);
  double one = 0, sine = 0, cosine = 0;
  for (std::size_t i = 0; i < grid.tool_count(); ++i) {
    one += weights[i];
    sine += weights[i] * std::sin(grid.tool_poses()[i][b]);
    cosine += weights[i] * std::cos(grid.tool_poses()[i][b]);
  }
  EXPECT_NEAR(one, 1.0, 1e-12);
  EXPECT_NEAR(sine, std::sin(0.3), 1e-12);
  EXPECT_NEAR(cosine, std::cos(0.3), 1e-12);
}

TEST(Turnmill, Meshes) {
  const Toy toy;
  const Result result = toy.run({"mesh", turnmill(), "--size", "2", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const nlohmann::json said = nlohmann::json::parse(result.out);
  EXPECT_EQ(said["bodies"].size(), 13U);
  EXPECT_EQ(result.err.find("warning"), std::string::npos) << result.err;
}

// Mares et al. (2020), section 3: one model holds for milling and drilling, since the head's heat stays in the head.
TEST(Turnmill, HeatOfTheHeadActsAlongItsOwnAxis) {
  const Toy toy;
  const auto last = [&](const std::string& pose) {
    const Result result = toy.run({"simulate", turnmill(), "--size", "2", "--load", "milling_6500", "--pose", pose,
                                   "--output-times", "7200", "--fields-every", "1e9"});
    EXPECT_EQ(result.status, 0) << result.err;
    const core::Table tcp = core::read_csv(toy.result("simulate/milling_6500/tcp.csv"));
    const Eigen::Index row = tcp.rows() - 1;
    return Eigen::Vector3d(tcp.column("dx_um")[row], tcp.column("dy_um")[row], tcp.column("dz_um")[row]);
  };
  const Eigen::Vector3d milling = last("Z=0,X=100,B=0"), drilling = last("Z=600,X=-250,B=90");
  EXPECT_LT(milling.z(), -20.0) << "the mandrel grows downwards";
  EXPECT_NEAR(drilling.x(), milling.z(), 0.15 * std::abs(milling.z())) << "and to the main spindle where it lies";
  EXPECT_NEAR(drilling.y(), milling.y(), 0.25 * std::abs(milling.y()));
  EXPECT_LT(std::abs(drilling.z()), 0.3 * std::abs(drilling.x())) << "the head is symmetric";
}

}  // namespace
}  // namespace thermotwin::cases
