// SPDX-License-Identifier: GPL-3.0-or-later
// cases/ac5: the machine loads with its cradle and table on the workpiece side, and meshes with the mass of its README.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/case.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

std::string ac5() { return (toy_case().parent_path().parent_path().parent_path() / "cases" / "ac5").string(); }

TEST(Cradle, IsReadWithBothRotaryAxesOnTheWorkpieceSide) {
  const solver::Case machine_case = solver::read_case(ac5());
  const mesh::Machine& machine = machine_case.machine;
  EXPECT_EQ(machine.workspace.axes, (std::vector<std::string>{"X", "Y", "Z"}));
  EXPECT_EQ(machine.workspace.table_axes, (std::vector<std::string>{"A"})) << "C turns outputs by itself";
  EXPECT_EQ(mesh::workspace_poses(machine).size(), 27U);
  EXPECT_GE(machine.axis_index("A"), 0);
  EXPECT_GE(machine.axis_index("C"), 0);
  EXPECT_EQ(machine.axis_index("B"), -1);
  for (const std::string& load : machine_case.load_names())
    EXPECT_GT(machine_case.load(load).output_times().size(), 1U) << load;
}

TEST(Cradle, Meshes) {
  const Toy toy;
  const Result result = toy.run({"mesh", ac5(), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const nlohmann::json said = nlohmann::json::parse(result.out);
  EXPECT_EQ(said["bodies"].size(), 15U);
  double mass = 0;
  for (const nlohmann::json& body : said["bodies"]) mass += body["mass_kg"].get<double>();
  EXPECT_NEAR(mass, 9292.0, 5.0);
  EXPECT_NEAR(said["nodes"].get<double>(), 18720.0, 200.0);
  EXPECT_EQ(result.err.find("warning"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace thermotwin::cases
