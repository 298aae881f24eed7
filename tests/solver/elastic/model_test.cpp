// SPDX-License-Identifier: GPL-3.0-or-later
// The machine's elastic system: joints, scales, outputs.
#include "solver/elastic/model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/thread_pool.h"
#include "mesh/machine/kinematics.h"
#include "solver/elastic/tcp.h"
#include "solver/thermal/assembly.h"
#include "tests/machines/box_machine.h"

namespace thermotwin::solver {
namespace {

using test::box_machine_mesh;
using test::box_pose;

struct Model {
  mesh::MachineMesh mesh;
  ThermalSystem thermal;
  ElasticModel elastic;
  explicit Model(mesh::MachineMesh m) : mesh(std::move(m)), thermal(assemble_thermal(mesh)), elastic(mesh, thermal) {}
};

TcpError error_at(const Model& model, const mesh::Pose& pose, const Eigen::VectorXd& temperature) {
  const OutputRows rows = model.elastic.output_rows(pose);
  return tcp_error(model.mesh.machine, pose, rows.tool * temperature, rows.table_axis * temperature,
                   rows.table_own * temperature);
}

/// Machine that hardly feels the foundation, so that even expansion is free.
test::BoxMachineOptions afloat() {
  test::BoxMachineOptions options;
  options.mount_normal = options.mount_tangential = 1e4;
  return options;
}

TEST(ElasticModel, SameBitsForAnyNumberOfThreads) {
  const auto rows_with = [](int threads) {
    core::set_thread_count(threads);
    const Model model(box_machine_mesh());
    return model.elastic.output_rows(box_pose(0.137, -0.061));
  };
  const OutputRows one = rows_with(1), three = rows_with(3);
  core::set_thread_count(0);
  EXPECT_EQ(one.tool, three.tool);
  EXPECT_EQ(one.table_axis, three.table_axis);
  EXPECT_EQ(one.table_own, three.table_own);
}

TEST(ElasticModel, EvenTemperatureOnlyScalesTheMachine) {
  // One material, tapes that expand alike: no joint is strained, and the error is alpha T times the
  // way from the table's surface to the tool's, at any pose.
  const Model model(box_machine_mesh(afloat()));
  const double strain = 11.5e-6 * 2.0;
  const Eigen::VectorXd temperature = Eigen::VectorXd::Constant(model.thermal.size, 2.0);
  for (const mesh::Pose& pose : {box_pose(0, 0), box_pose(0.137, -0.061), box_pose(-0.2, 0.1)}) {
    const TcpError error = error_at(model, pose, temperature);
    const Eigen::Vector3d nose(0.0, 0.125, 0.25 + pose[1]), table(pose[0], 0.0, 0.05);
    const Eigen::Vector3d point = tcp_position(model.mesh.machine, pose);
    // The nose moves by its mean, the table by its mean and its radial growth up to the tool.
    Eigen::Vector3d growth = point - table;
    growth.z() = 0.0;
    const Eigen::Vector3d expected = strain * (nose - table - growth);
    EXPECT_LT((error.error.head<3>() - expected).norm(), 1e-4 * strain);
    EXPECT_LT(error.error.tail<3>().norm(), 1e-4 * strain);
  }
  const OutputRows rows = model.elastic.output_rows(box_pose(0, 0));
  EXPECT_NEAR(rows.table_own.row(6) * temperature, strain * 0.15, 1e-9 * strain);
}

TEST(ElasticModel, TurnedTableExpandsEvenlyToo) {
  const Model model(box_machine_mesh(afloat()));
  const double strain = 11.5e-6 * 2.0;
  const Eigen::VectorXd temperature = Eigen::VectorXd::Constant(model.thermal.size, 2.0);
  const mesh::Pose pose = box_pose(0.1, 0.0, M_PI / 2);
  const auto outputs = model.elastic.outputs_of(model.elastic.displacement(temperature, pose), pose);
  EXPECT_NEAR(outputs.table_own[6], strain * 0.15, 1e-6 * strain);
  EXPECT_LT(outputs.table_own.segment<3>(3).norm(), 1e-5 * strain);
  EXPECT_LT(outputs.table_axis.tail<3>().norm(), 1e-4 * strain);
}

TEST(ElasticModel, TapeMovesTheSlide) {
  // A tape that expands otherwise than its carrier shifts the slide by the difference over the
  // length from its fixed point to the head.
  test::BoxMachineOptions other = afloat();
  other.tape_expansion = 8.0e-6;
  const Model same(box_machine_mesh(afloat())), tape(box_machine_mesh(other));
  const Eigen::VectorXd temperature = Eigen::VectorXd::Constant(same.thermal.size, 1.0);
  const mesh::Pose pose = box_pose(0.15, -0.05);
  const Vector6 change = error_at(tape, pose, temperature).error - error_at(same, pose, temperature).error;
  const double difference = 8.0e-6 - 11.5e-6;
  EXPECT_NEAR(change[0], -difference * (0.15 + 0.4), 1e-10);  // the table goes with the slide
  EXPECT_NEAR(change[2], difference * (0.4 - 0.05 - 0.6), 1e-10);
  EXPECT_NEAR(change[1], 0.0, 1e-10);
}

TEST(ElasticModel, TapeFeelsTheTemperatureBelowIt) {
  // Only the bed is warm, linearly along x: the tape's expansion is the integral from its fixed end.
  const Model model(box_machine_mesh());
  Eigen::VectorXd warm = Eigen::VectorXd::Zero(model.thermal.size);
  for (Eigen::Index i = 0; i < model.mesh.bodies[0].nodes(); ++i)
    warm[i] = 1.0 + 2.0 * model.mesh.bodies[0].points(0, i);
  test::BoxMachineOptions options;
  options.tape_expansion = 0.0;
  const Model rigid_tape(box_machine_mesh(options));
  const mesh::Pose pose = box_pose(0.1, 0.0);
  const Vector6 change = error_at(model, pose, warm).table - error_at(rigid_tape, pose, warm).table;
  // integral of 1 + 2 x from -0.4 to 0.1
  EXPECT_NEAR(change[0], 11.5e-6 * (0.5 + 0.01 - 0.16), 1e-10);
}

/// One block on mounts, or two joined ones, warm at one side; the top's motion.
Vector6 top_of_block(bool divided, double stiffness) {
  mesh::Machine machine;
  machine.path = "block/machine.toml";
  machine.materials = {test::steel()};
  machine.bodies = {test::body("lower")};
  machine.surfaces = {test::surface("feet", "lower", {"z0"}), test::surface("lower.top", "lower", {"z1"})};
  machine.joints = {test::elastic_joint("mounts", "mount", "feet", "", "", {2, 2, 1})};
  machine.ambients = {test::ambient("air", 20.0), test::ambient("foundation", 20.0)};
  machine.films = {test::constant_film("film", {"feet"}, 5.0)};
  if (divided) {
    machine.bodies.push_back(test::body("upper", "steel", "lower"));
    machine.surfaces.push_back(test::surface("upper.foot", "upper", {"z0"}));
    machine.surfaces.push_back(test::surface("upper.top", "upper", {"z1"}));
    machine.joints.push_back(test::elastic_joint("joint", "bolted", "upper.foot", "lower.top", "", {6, 6, 1}));
    machine.joints.back().stiffness_normal = machine.joints.back().stiffness_tangential = {stiffness, 0.0};
  }
  machine.tcp.tool_body = divided ? "upper" : "lower";
  machine.tcp.tool_surface = divided ? "upper.top" : "lower.top";
  machine.tcp.tool_point = {0.1, 0.1, 0.5};
  machine.tcp.table_body = "lower";
  machine.tcp.table_surface = "feet";
  machine.tcp.table_radius = 0.1;
  std::vector<mesh::TetMesh> boxes;
  if (divided) {
    boxes = {test::box_mesh({0, 0, 0}, {0.2, 0.2, 0.2}, {6, 6, 6}),
             test::box_mesh({0, 0, 0.2}, {0.2, 0.2, 0.4}, {6, 6, 6})};
  } else
    boxes = {test::box_mesh({0, 0, 0}, {0.2, 0.2, 0.4}, {6, 6, 12})};
  const Model model(test::machine_mesh(machine, boxes));
  Eigen::VectorXd temperature = Eigen::VectorXd::Zero(model.thermal.size);
  for (std::size_t b = 0; b < model.mesh.bodies.size(); ++b) {
    for (Eigen::Index i = 0; i < model.mesh.bodies[b].nodes(); ++i) {
      const Eigen::Vector3d p = model.mesh.bodies[b].points.col(i);
      temperature[model.mesh.first_node[b] + i] = 1.0 + 20.0 * p.x() * p.z() + 5.0 * p.y();
    }
  }
  return model.elastic.output_rows(mesh::Pose(0)).tool * temperature;
}

TEST(ElasticModel, StiffJointActsLikeSolidMaterial) {
  const Vector6 solid = top_of_block(false, 0.0), joined = top_of_block(true, 1e15);
  EXPECT_LT((joined - solid).head<3>().norm(), 0.01 * solid.head<3>().norm());
  EXPECT_LT((joined - solid).tail<3>().norm(), 0.02 * solid.tail<3>().norm());
}

TEST(ElasticModel, BodyThatNothingTouchesIsNamed) {
  mesh::MachineMesh mesh = box_machine_mesh();
  mesh.machine.joints[4].stiffness_normal = mesh.machine.joints[4].stiffness_tangential = {0.0, 0.0};
  mesh.machine.scales.pop_back();
  mesh.machine.bodies[4].axis.clear();
  try {
    const Model model(mesh);
    FAIL() << "the head floats";
  } catch (const core::MeshError& error) {
    EXPECT_NE(std::string(error.what()).find("head"), std::string::npos) << error.what();
  }
}

TEST(ElasticModel, LooseDirectionIsNamed) {
  mesh::MachineMesh mesh = box_machine_mesh();
  mesh.machine.joints[2].stiffness_tangential = {0.0, 0.0};  // the table slides and turns on its seat
  try {
    const Model model(mesh);
    FAIL() << "the table slides";
  } catch (const core::MeshError& error) {
    EXPECT_NE(std::string(error.what()).find("'table'"), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find("'bed'"), std::string::npos) << error.what();
  }
}

/// The machine whose column stands on pads of its own.
mesh::MachineMesh column_on(const Eigen::Vector3i& divide) {
  mesh::MachineMesh mesh = box_machine_mesh();
  mesh.machine.joints[3].divide = divide;
  return mesh;
}

// Pads in a row hold a body about the row's line only as far as their centres stray from it.
TEST(ElasticModel, PadsOnOneLineAreRefusedOrWarnedOf) {
  testing::internal::CaptureStderr();
  std::string refused;
  try {
    const Model model(column_on({2, 1, 1}));
  } catch (const core::MeshError& error) {
    refused = error.what();
  }
  const std::string said = testing::internal::GetCapturedStderr() + refused;
  EXPECT_NE(said.find("'column'"), std::string::npos) << said;
  EXPECT_NE(said.find("to turn about x through ("), std::string::npos) << said;
  testing::internal::CaptureStderr();
  const Model held(column_on({2, 2, 1}));
  EXPECT_EQ(testing::internal::GetCapturedStderr().find("hardly held"), std::string::npos);
}

// A body holds its pads no better than its material does, so joints as good as rigid make no other one look loose.
TEST(ElasticModel, RigidJointsLeaveTheOthersAsTheyAre) {
  mesh::MachineMesh mesh = box_machine_mesh();
  for (std::size_t j = 1; j < mesh.machine.joints.size(); ++j) {
    for (core::Uncertain* stiffness :
         {&mesh.machine.joints[j].stiffness_normal, &mesh.machine.joints[j].stiffness_tangential})
      if (stiffness->value > 0.0) stiffness->value = 1e17;
  }
  testing::internal::CaptureStderr();
  const Model model(std::move(mesh));
  EXPECT_EQ(testing::internal::GetCapturedStderr().find("hardly held"), std::string::npos);
}

TEST(ElasticModel, LinearAxisNeedsAScale) {
  mesh::MachineMesh mesh = box_machine_mesh();
  mesh.machine.scales.erase(mesh.machine.scales.begin());
  try {
    const Model model(mesh);
    FAIL() << "nothing holds the slide along X";
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("axis X"), std::string::npos) << error.what();
  }
}

TEST(ElasticModel, BodiesWithHeatOnlyAreCarried) {
  mesh::MachineMesh mesh = box_machine_mesh();
  mesh.machine.bodies.push_back(test::body("screw", "steel", "bed"));
  mesh.machine.bodies.back().elastic = false;
  mesh.bodies.push_back(test::box_mesh({-0.4, -0.1, -0.1}, {0.4, -0.08, -0.08}, {8, 1, 1}));
  mesh.first_node.push_back(mesh.first_node.back() + mesh.bodies.back().nodes());
  const Model model(mesh);
  const Eigen::VectorXd temperature = test::uneven_temperature(model.mesh, model.thermal.size);
  const Eigen::Matrix3Xd motion = model.elastic.displacement(temperature, box_pose(0, 0));
  const Eigen::Index first = model.mesh.first_node[5], count = model.mesh.bodies[5].nodes();
  EXPECT_GT(motion.middleCols(first, count).norm(), 0.0);
  // Rigid: distances along the screw do not change.
  const Eigen::Matrix3Xd& points = model.mesh.bodies[5].points;
  const Eigen::Vector3d way = points.col(count - 1) - points.col(0);
  EXPECT_NEAR(way.dot(motion.col(first + count - 1) - motion.col(first)), 0.0, 1e-12);
}

}  // namespace
}  // namespace thermotwin::solver
