// SPDX-License-Identifier: GPL-3.0-or-later
// Position by scale or by the screw of the semi-closed loop.
#include <gtest/gtest.h>

#include <cmath>

#include "mesh/machine/kinematics.h"
#include "solver/elastic/model.h"
#include "solver/elastic/tcp.h"
#include "solver/thermal/assembly.h"
#include "tests/machines/box_machine.h"

namespace thermotwin::solver {
namespace {

using test::box_pose;

constexpr double alpha = 11.5e-6;

struct Options {
  std::string feedback = "screw";
  bool stretched = false;
  double bearing_stiffness = 0.0, expansion = alpha;
  int order = 1;
};

/// The machine of five boxes with a screw under the slide, bearings at x = -0.4 (fixed) and 0.4.
mesh::MachineMesh with_screw(const Options& options) {
  mesh::MachineMesh mesh = test::box_machine_mesh();
  mesh.machine.bodies.push_back(test::body("screw", "steel", "bed"));
  mesh.machine.bodies.back().elastic = false;
  mesh.bodies.push_back(test::box_mesh({-0.42, -0.01, -0.06}, {0.42, 0.01, -0.04}, {24, 2, 2}));
  mesh.first_node.push_back(mesh.first_node.back() + mesh.bodies.back().nodes());
  mesh::ScrewSpec screw;
  screw.axis = "X";
  screw.body = "screw";
  screw.carrier = "bed";
  screw.nut_body = "slide";
  screw.bearing = {-0.4, 0.0, -0.05};
  screw.nut = {0.05, 0.0, -0.05};
  screw.expansion = {options.expansion, 0.0};
  if (options.stretched) {
    screw.far_bearing = Eigen::Vector3d(0.4, 0.0, -0.05);
    screw.pretension = 8000.0;
    screw.bearing_stiffness = options.bearing_stiffness;
  }
  mesh.machine.screws = {screw};
  mesh.machine.axes[0].feedback = options.feedback;
  return test::with_order(std::move(mesh), options.order);
}

struct Model {
  mesh::MachineMesh mesh;
  ThermalSystem thermal;
  ElasticModel elastic;
  explicit Model(const Options& options = {})
      : mesh(with_screw(options)),
        thermal(assemble_thermal(mesh)),
        elastic(mesh, thermal) {}

  /// Temperature of the screw only, a function of x; K.
  template <class Function>
  Eigen::VectorXd screw(Function&& at) const {
    Eigen::VectorXd temperature = Eigen::VectorXd::Zero(thermal.size);
    for (Eigen::Index i = 0; i < mesh.bodies[5].nodes(); ++i)
      temperature[mesh.first_node[5] + i] = at(mesh.bodies[5].points.col(i));
    return temperature;
  }
  /// What the slide, and with it the table, moves along X, m.
  double shift(const Eigen::VectorXd& temperature, const mesh::Pose& pose) const {
    return (elastic.output_rows(pose).table_axis * temperature)[0];
  }
};

TEST(Screw, EvenlyWarmMovesTheNutByItsLength) {
  for (const int order : {1, 2}) {
    const Model model({.order = order});
    const Eigen::VectorXd warm = model.screw([](const Eigen::Vector3d&) { return 3.0; });
    // from the bearing at -0.4 to the nut at 0.05 + x
    for (const double x : {-0.2, 0.0, 0.137, 0.2})
      EXPECT_NEAR(model.shift(warm, box_pose(x, 0.0)), alpha * 3.0 * (0.45 + x), 1e-12) << order << " " << x;
  }
}

TEST(Screw, LinearTemperatureGivesItsIntegral) {
  const Model model;
  // A gradient across the screw cancels.
  const Eigen::VectorXd warm =
      model.screw([](const Eigen::Vector3d& p) { return 2.0 + 5.0 * p.x() + 40.0 * p.y() - 30.0 * (p.z() + 0.05); });
  for (const double x : {-0.2, 0.05, 0.2}) {
    const double to = 0.05 + x;
    EXPECT_NEAR(model.shift(warm, box_pose(x, 0.0)), alpha * (2.0 * (to + 0.4) + 2.5 * (to * to - 0.16)), 1e-12) << x;
  }
}

TEST(Screw, BearingOnTheOtherSideTurnsTheSign) {
  mesh::MachineMesh mesh = with_screw({});
  mesh.machine.screws[0].bearing.x() = 0.4;
  const ThermalSystem thermal = assemble_thermal(mesh);
  const ElasticModel elastic(mesh, thermal);
  Eigen::VectorXd warm = Eigen::VectorXd::Zero(thermal.size);
  warm.segment(mesh.first_node[5], mesh.bodies[5].nodes()).setConstant(3.0);
  EXPECT_NEAR((elastic.output_rows(box_pose(0.1, 0.0)).table_axis * warm)[0], -alpha * 3.0 * (0.4 - 0.15), 1e-12);
}

TEST(Screw, ClosedLoopDoesNotFeelIt) {
  const Model closed({.feedback = "scale"});
  const Eigen::VectorXd warm = closed.screw([](const Eigen::Vector3d& p) { return 3.0 + p.x(); });
  const OutputRows rows = closed.elastic.output_rows(box_pose(0.1, 0.05));
  EXPECT_EQ((rows.tool * warm).norm(), 0.0);
  EXPECT_EQ((rows.table_axis * warm).norm(), 0.0);
  EXPECT_EQ((rows.table_own * warm).norm(), 0.0);
  // and the machine is the same as without the screw
  const mesh::MachineMesh plain = test::box_machine_mesh();
  const ThermalSystem thermal = assemble_thermal(plain);
  EXPECT_EQ(ElasticModel(plain, thermal).output_rows(box_pose(0.1, 0.05)).table_axis,
            rows.table_axis.leftCols(plain.nodes()));
}

TEST(Screw, EvenTemperatureOfAllOnlyScalesTheMachine) {
  // The screw expands as its bed does: nothing is strained, whatever the loop.
  for (const bool stretched : {false, true}) {
    mesh::MachineMesh mesh = with_screw({.stretched = stretched});
    mesh.machine.joints[0].stiffness_normal = mesh.machine.joints[0].stiffness_tangential = {1e4, 0.0};
    const ThermalSystem thermal = assemble_thermal(mesh);
    const ElasticModel elastic(mesh, thermal);
    const Eigen::VectorXd warm = Eigen::VectorXd::Constant(thermal.size, 2.0);
    const mesh::Pose pose = box_pose(0.1, -0.03);
    const OutputRows rows = elastic.output_rows(pose);
    const TcpError error =
        tcp_error(mesh.machine, pose, rows.tool * warm, rows.table_axis * warm, rows.table_own * warm);
    const Eigen::Vector3d point = tcp_position(mesh.machine, pose), table(pose[0], 0.0, 0.05);
    Eigen::Vector3d growth = point - table;
    growth.z() = 0.0;
    const double strain = 2.0 * alpha;
    EXPECT_LT((error.error.head<3>() - strain * (Eigen::Vector3d(0.0, 0.125, 0.25 + pose[1]) - table - growth)).norm(),
              2e-4 * strain);
    EXPECT_LT(error.error.tail<3>().norm(), 2e-4 * strain);
  }
}

TEST(Screw, AdjointRowsAgreeWithTheDisplacements) {
  for (const Options& options :
       {Options{}, Options{.stretched = true}, Options{.stretched = true, .bearing_stiffness = 2e8},
        Options{.feedback = "scale", .stretched = true}}) {
    const Model model(options);
    const Eigen::VectorXd temperature = test::uneven_temperature(model.mesh, model.thermal.size);
    const mesh::Pose pose = box_pose(0.137, -0.061);
    const OutputRows rows = model.elastic.output_rows(pose);
    const auto direct = model.elastic.outputs_of(model.elastic.displacement(temperature, pose), pose);
    EXPECT_LT((rows.tool * temperature - direct.tool).norm(), 1e-9 * direct.tool.norm());
    EXPECT_LT((rows.table_axis * temperature - direct.table_axis).norm(), 1e-9 * direct.table_axis.norm());
    EXPECT_LT((rows.table_own * temperature - direct.table_own).norm(), 1e-9 * direct.table_own.norm());
  }
}

TEST(Screw, PretensionTakesUpAnEvenExpansion) {
  // Half of the screw is warm. Bearings of 1e16 N/m^3-like stiffness do not exist: the bed gives way to
  // the pull, so the bound is the bed's compliance; the nut in the middle of an evenly warm one stays.
  const Model model({.stretched = true});
  const Eigen::VectorXd even = model.screw([](const Eigen::Vector3d&) { return 3.0; });
  const double free = alpha * 3.0 * 0.4;  // of a screw without the second bearing, at the middle
  EXPECT_LT(std::abs(model.shift(even, box_pose(-0.05, 0.0))), 0.02 * free);
  // Its pull falls by alpha T E A less what the bed gives way by.
  const double section = 0.02 * 0.02, rigid = alpha * 3.0 * 210e9 * section;
  const auto tension = model.elastic.screw_tensions(even, box_pose(0.0, 0.0));
  ASSERT_EQ(tension.size(), 1u);
  EXPECT_EQ(tension[0].screw, 0);
  EXPECT_LT(tension[0].tension, 8000.0 - 0.9 * rigid);
  EXPECT_GT(tension[0].tension, 8000.0 - rigid);
  const auto slack = model.elastic.screw_tensions(4.0 * even, box_pose(0.0, 0.0));
  EXPECT_LT(slack[0].tension, 0.0);
  EXPECT_NEAR(model.elastic.screw_tensions(Eigen::VectorXd::Zero(model.thermal.size), box_pose(0.0, 0.0))[0].tension,
              8000.0, 1e-9);
}

TEST(Screw, StretchedOneMovesTheNutByWhatIsUneven) {
  // Bearings that cannot move: with u_A = u_B = 0 the nut goes e(A, x) - (x - A) / L e(A, B). The bed's
  // own answer to the pull is taken off by the machine under closed loop, which feels the pull alone.
  const Model semi({.stretched = true}), closed({.feedback = "scale", .stretched = true});
  const auto parabola = [](const Eigen::Vector3d& p) { return 2.0 + 5.0 * p.x(); };
  const Eigen::VectorXd warm = semi.screw(parabola);
  const auto integral = [](double to) { return alpha * (2.0 * (to + 0.4) + 2.5 * (to * to - 0.16)); };
  for (const double x : {-0.2, 0.0, 0.15}) {
    const double to = 0.05 + x, share = (to + 0.4) / 0.8;
    const mesh::Pose pose = box_pose(x, 0.0);
    // The bed between the bearings: its ends' motion under the pull, from the displacements.
    const Eigen::Matrix3Xd motion = closed.elastic.displacement(warm, pose);
    const auto bed_at = [&](double at) {
      double sum = 0.0, weight = 0.0;
      const Eigen::Matrix3Xd& points = closed.mesh.bodies[0].points;
      for (Eigen::Index i = 0; i < points.cols(); ++i) {
        if (std::abs(points(2, i) + 0.1) < 1e-9 && std::abs(points(0, i) - at) < 0.126 &&
            std::abs(points(1, i)) < 0.01) {
          const double hat = std::max(0.0, 1.0 - std::abs(points(0, i) - at) / 0.125);
          sum += hat * motion(0, i);
          weight += hat;
        }
      }
      return sum / weight;
    };
    const double ends = (1.0 - share) * bed_at(-0.4) + share * bed_at(0.4);
    EXPECT_NEAR(semi.shift(warm, pose), integral(to) - share * integral(0.4) + ends, 3e-7) << x;
  }
}

TEST(Screw, SoftBearingsLetItExpand) {
  // Bearings of 1 N/um hold nothing: the screw's own ends move, the same as far as the middle.
  const Model model({.stretched = true, .bearing_stiffness = 1e3});
  const Eigen::VectorXd warm = model.screw([](const Eigen::Vector3d&) { return 3.0; });
  for (const double x : {-0.2, 0.0, 0.2})
    EXPECT_NEAR(model.shift(warm, box_pose(x, 0.0)), alpha * 3.0 * (0.05 + x), 1e-9) << x;  // from the middle on
}

}  // namespace
}  // namespace thermotwin::solver
