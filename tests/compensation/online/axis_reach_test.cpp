// SPDX-License-Identifier: GPL-3.0-or-later
// The directions that linear axes move, and what offsets cancel in them.
#include "compensation/online/axis_reach.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "compensation/evaluation/measured_machines.h"
#include "compensation/evaluation/replay.h"
#include "compensation/evaluation/validation.h"
#include "solver/campaign/case.h"
#include "tests/compensation/scratch.h"
#include "tests/machines/five_axis.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Vector3d;

struct Carried {
  std::string id;
  Vector3d direction;
  mesh::AxisKind kind = mesh::AxisKind::linear;
};

/// The tool stands on a chain of axes, the first one next to the ground; the table on another one.
mesh::Machine machine_of(const std::vector<Carried>& tool, const std::vector<Carried>& table) {
  mesh::Machine machine;
  const auto chain = [&](const std::vector<Carried>& axes, std::string parent) {
    for (const Carried& carried : axes) {
      mesh::Axis axis;
      axis.id = carried.id;
      axis.kind = carried.kind;
      axis.direction = carried.direction.normalized();
      machine.axes.push_back(axis);
      mesh::BodySpec body;
      body.id = "of " + carried.id;
      body.parent = parent;
      body.axis = carried.id;
      machine.bodies.push_back(body);
      parent = body.id;
    }
    return parent;
  };
  mesh::BodySpec bed;
  bed.id = "bed";
  machine.bodies.push_back(bed);
  machine.tcp.tool_body = chain(tool, "bed");
  machine.tcp.table_body = chain(table, "bed");
  return machine;
}

AxisReach reach_of(const mesh::Machine& machine, const std::vector<double>& pose = {}) {
  mesh::Pose at = mesh::Pose::Zero(std::ssize(machine.axes));
  for (std::size_t a = 0; a < pose.size(); ++a) at[a] = pose[a];
  return AxisReach(machine, at);
}

const Carried x{"X", {1, 0, 0}}, y{"Y", {0, 1, 0}}, z{"Z", {0, 0, 1}};
const Vector3d error{3, -4, 12};

TEST(AxisReach, ThreeAxesMoveAllDirections) {
  const AxisReach reach = reach_of(machine_of({x, z}, {y}));
  EXPECT_EQ(reach.unmoved_directions(), "");
  EXPECT_EQ(reach.unmoved(error), Vector3d::Zero());
  EXPECT_EQ(reach.motion(Vector3d(1, 2, 3)), Vector3d(1, -3, 2)) << "X and Z carry the tool, Y the table";
}

TEST(AxisReach, DirectionsWithoutAnAxisAreNamed) {
  const AxisReach one = reach_of(machine_of({x}, {})), lathe = reach_of(machine_of({z, x}, {}));
  EXPECT_EQ(one.unmoved_directions(), "y (dy) and z (dz)");
  EXPECT_LT((one.unmoved(error) - Vector3d(0, -4, 12)).norm(), 1e-12);
  EXPECT_EQ(lathe.unmoved_directions(), "y (dy)");
  EXPECT_LT((lathe.unmoved(error) - Vector3d(0, -4, 0)).norm(), 1e-12);
  EXPECT_EQ(reach_of(machine_of({}, {})).unmoved_directions(), "x (dx), y (dy) and z (dz)");
}

TEST(AxisReach, ObliqueAxesLeaveObliqueDirections) {
  const AxisReach wedge = reach_of(machine_of({{"X", {1, 0, 0}}, {"U", {0, 3, 4}}}, {}));
  EXPECT_EQ(wedge.unmoved_directions().find("(0.00, "), 0U) << wedge.unmoved_directions();
  EXPECT_LT((wedge.unmoved(error) - Vector3d(0, -8.32, 6.24)).norm(), 1e-12);  // 10.4 um along (0, -0.8, 0.6)
  const AxisReach one = reach_of(machine_of({{"U", {0, 3, 4}}}, {}));
  EXPECT_EQ(one.unmoved_directions(), "what is normal to (0.00, 0.60, 0.80)");
}

TEST(AxisReach, AnAxisOnARotaryOneTurnsWithIt) {
  const mesh::Machine machine = machine_of({{"B", {0, 1, 0}, mesh::AxisKind::rotary}, {"W", {0, 0, 1}}}, {});
  EXPECT_EQ(reach_of(machine).unmoved_directions(), "x (dx) and y (dy)");
  const AxisReach turned = reach_of(machine, {std::numbers::pi / 2, 0});
  EXPECT_EQ(turned.unmoved_directions(), "y (dy) and z (dz)");
  EXPECT_LT((turned.motion(Eigen::VectorXd::Constant(1, 2.0)) - Vector3d(2, 0, 0)).norm(), 1e-12);
}

TEST(AxisReach, AnAxisOfAnotherPartMovesNothing) {
  mesh::Machine machine = machine_of({x}, {y});
  mesh::Axis tailstock;
  tailstock.id = "W";
  tailstock.direction = {0, 0, 1};
  machine.axes.push_back(tailstock);
  const AxisReach reach = reach_of(machine);
  EXPECT_EQ(reach.unmoved_directions(), "z (dz)");
  EXPECT_EQ(reach.motion(Vector3d(0, 0, 5)), Vector3d::Zero());
}

// What the guarded offsets cancel is what the model predicts, as soon as the guard has let them in.
TEST(AxisReach, WithThreeAxesTheOffsetsCancelThePrediction) {
  const reduction::ReducedModel model = test::lumped_model(), truth = test::lumped_model({1.02, 0.96, 0.05});
  const test::Scratch scratch;
  solver::Case machine_case;
  machine_case.folder = scratch.path();
  machine_case.machine = model.machine;
  machine_case.check_points.push_back(mesh::parse_pose(model.machine, "X=300,Y=-200,Z=50,B=45", "test"));
  scratch.write("loads/work.toml",
                "schema = 1\ntime_step_s = 60\noutput_s = 300\n[[phase]]\nduration_h = 3\nspindle_rpm = 9000\n");
  ValidationOptions options;
  options.loads = {"work"};
  MeasuredMachines machines(machine_case, options.machine, {}, &truth);
  const Measurement measured = machines.measure(3, {machine_case.load("work"), ""});
  MeasuredRun how;
  const auto predicted = run_compensator(measured, model, machine_case.check_points, how);
  how.guarded = true;
  const auto cancelled = run_compensator(measured, model, machine_case.check_points, how);
  const Eigen::VectorXd time = measured.time();
  int compared = 0;
  for (Eigen::Index i = 0; i < time.size(); ++i) {
    if (time[i] < time[0] + offset_settle_s) continue;
    const std::size_t row = i;
    EXPECT_LT((cancelled[0][row].error - predicted[0][row].error).head<3>().norm(), 1e-15) << time[i];
    ++compared;
  }
  EXPECT_GT(compared, 30);
}

}  // namespace
}  // namespace thermotwin::compensation
