// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/model/reduced_model.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/error.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/output_grid.h"
#include "solver/operation/grid_occupancy.h"
#include "tests/machines/boxes.h"
#include "tests/reduction/random_system.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::exact;
using test::Numbers;
using test::operator_of;
using test::random_coefficients;
using test::random_system;

VectorXd stepped(const ReducedSystem& system, const solver::Coefficients& c, VectorXd state, double time, int steps) {
  ReducedStepper stepper(system);
  for (int i = 0; i < steps; ++i) stepper.advance(state, c, time / steps);
  return state;
}

TEST(ReducedStepper, ConvergesWithSecondOrderToTheExponential) {
  const ReducedSystem system = random_system(12, 4, 3, 1);
  const solver::Coefficients c = random_coefficients(system, 2);
  const VectorXd start = Numbers(3).matrix(12, 1);
  const double time = 400.0;
  const VectorXd truth = exact(system, c, start, time);
  const double coarse = (stepped(system, c, start, time, 40) - truth).norm();
  const double fine = (stepped(system, c, start, time, 80) - truth).norm();
  EXPECT_LT(coarse, 1e-3 * start.norm());
  EXPECT_GT(std::log2(coarse / fine), 1.9);
  EXPECT_LT(std::log2(coarse / fine), 2.2);
}

TEST(ReducedStepper, AcceptsAnyCapacity) {
  ReducedSystem system = random_system(8, 2, 2, 4);
  const MatrixXd b = Numbers(5).matrix(8, 8);
  system.capacity += 0.2 * b * b.transpose();
  const solver::Coefficients c = random_coefficients(system, 6);
  const VectorXd start = Numbers(7).matrix(8, 1);
  const VectorXd truth = exact(system, c, start, 600.0);
  EXPECT_LT((stepped(system, c, start, 600.0, 600) - truth).norm(), 1e-5 * start.norm());
}

TEST(ReducedStepper, StaysAtTheSteadyStateForAnyStep) {
  const ReducedSystem system = random_system(15, 5, 4, 8);
  const solver::Coefficients c = random_coefficients(system, 9);
  VectorXd state = operator_of(system, c).partialPivLu().solve(system.inputs * c.q);
  const VectorXd steady = state;
  ReducedStepper stepper(system);
  for (const double step : {1.0, 60.0, 3600.0, 1e9}) {
    stepper.advance(state, c, step);
    EXPECT_LT((state - steady).norm(), 1e-8 * steady.norm()) << step;
  }
  // L-stable: one huge step forgets the past.
  state = Numbers(10).matrix(15, 1);
  stepper.advance(state, c, 1e12);
  EXPECT_LT((state - steady).norm(), 1e-6 * steady.norm());
}

TEST(ReducedStepper, ChangedCoefficientsAgreeWithAFreshStepper) {
  const ReducedSystem system = random_system(40, 30, 5, 11);
  solver::Coefficients c = random_coefficients(system, 12);
  Numbers number(13);
  ReducedStepper stepper(system);
  VectorXd state = number.matrix(40, 1), reference = state;
  for (int step = 0; step < 700; ++step) {
    // Small changes of two terms, at times a jump of all, at times another step size.
    for (int k = 0; k < 2; ++k) c.p(static_cast<Index>(number(0.0, 29.999))) *= number(0.97, 1.03);
    if (step % 100 == 50) c.p *= 1.5;
    if (step % 40 == 20) c.q *= -1.0;
    const double length = step % 60 < 30 ? 60.0 : 45.0;
    stepper.advance(state, c, length);
    ReducedStepper fresh(system);
    fresh.advance(reference, c, length);
    ASSERT_LT((state - reference).norm(), 1e-7 * (1.0 + reference.norm())) << step;
    ASSERT_LT((stepper.operator_matrix() - operator_of(system, c)).norm(), 1e-12 * operator_of(system, c).norm());
  }
  EXPECT_LT(stepper.factorisations(), 200) << "small changes should be met by refinement";
  EXPECT_GT(stepper.factorisations(), 5);
}

TEST(ReducedStepper, AlternatingStatesKeepTheirFactors) {
  const ReducedSystem system = random_system(30, 10, 5, 14);
  const solver::Coefficients states[] = {random_coefficients(system, 15), random_coefficients(system, 16),
                                         random_coefficients(system, 17)};
  ReducedStepper stepper(system);
  VectorXd state = VectorXd::Zero(30);
  for (int i = 0; i < 300; ++i) stepper.advance(state, states[i / 5 % 3], 60.0);
  EXPECT_LE(stepper.factorisations(), 4);
}

TEST(ReducedStepper, ABlockOfLoadsEqualsTheLoadsOneByOne) {
  const ReducedSystem system = random_system(20, 8, 5, 18);
  const std::vector<solver::Coefficients> c{random_coefficients(system, 19), random_coefficients(system, 20)};
  MatrixXd block = Numbers(21).matrix(20, 2);
  VectorXd first = block.col(0), second = block.col(1);
  ReducedStepper together(system), one(system), two(system);
  for (int i = 0; i < 20; ++i) {
    together.advance(block, c, 30.0);
    one.advance(first, c[0], 30.0);
    two.advance(second, c[1], 30.0);
  }
  EXPECT_LT((block.col(0) - first).norm() + (block.col(1) - second).norm(), 1e-8);
}

TEST(ReducedStepper, UniformAndSensorsFollowTheSystem) {
  const ReducedSystem system = random_system(10, 3, 2, 22);
  const ReducedStepper stepper(system);
  EXPECT_EQ(stepper.size(), 10);
  EXPECT_TRUE(stepper.uniform(2.5).isApprox(2.5 * system.one_kelvin));
  const MatrixXd state = Numbers(23).matrix(10, 2);
  EXPECT_TRUE(stepper.sensors(state).isApprox(system.sensors * state));
}

TEST(ReducedStepper, ANaNIsReportedAndForgotten) {
  const ReducedSystem system = random_system(10, 3, 2, 24);
  solver::Coefficients good = random_coefficients(system, 25), bad = good;
  bad.p(1) = std::nan("");
  ReducedStepper stepper(system);
  VectorXd state = VectorXd::Ones(10), reference = state;
  stepper.advance(state, good, 60.0);
  VectorXd spoilt = state;
  EXPECT_THROW(stepper.advance(spoilt, bad, 60.0), core::SolverError);
  bad = good;
  bad.q(0) = std::nan("");
  spoilt = state;
  EXPECT_THROW(stepper.advance(spoilt, bad, 60.0), core::SolverError);
  stepper.advance(state, good, 60.0);
  ReducedStepper fresh(system);
  fresh.advance(reference, good, 60.0);
  fresh.advance(reference, good, 60.0);
  EXPECT_LT((state - reference).norm(), 1e-12);
}

/// Of the tool's poses that a model stores.
Eigen::VectorXd pose_weights(const mesh::Machine& machine, const mesh::Pose& pose, std::size_t stored) {
  Eigen::VectorXd weights;
  OutputGrid(machine, stored).tool_weights(pose, weights);
  return weights;
}

TEST(PoseWeights, ReproduceQuadraticsAndTheirSumIsOne) {
  const mesh::Machine machine = test::small_machine();
  const std::vector<mesh::Pose> grid = mesh::workspace_poses(machine);
  ASSERT_EQ(grid.size(), 9u);
  const auto f = [](const mesh::Pose& p) {
    return 1.0 + 2.0 * p(0) - 3.0 * p(1) + 5.0 * p(0) * p(1) + 7.0 * p(0) * p(0) - 4.0 * p(1) * p(1) * p(0);
  };
  Numbers number(30);
  for (int i = 0; i < 20; ++i) {
    mesh::Pose pose = mesh::home_pose(machine);
    pose(0) = number(-0.2, 0.2);
    pose(1) = number(-0.1, 0.1);
    const VectorXd weights = pose_weights(machine, pose, mesh::workspace_poses(machine).size());
    ASSERT_EQ(weights.size(), 9);
    EXPECT_NEAR(weights.sum(), 1.0, 1e-14);
    double sum = 0;
    for (std::size_t k = 0; k < grid.size(); ++k) sum += weights(k) * f(grid[k]);
    EXPECT_NEAR(sum, f(pose), 1e-13);
  }
}

TEST(PoseWeights, AreExactAtTheGridAndClampedBeyondIt) {
  const mesh::Machine machine = test::small_machine();
  const std::vector<mesh::Pose> grid = mesh::workspace_poses(machine);
  for (std::size_t k = 0; k < grid.size(); ++k) {
    EXPECT_EQ(pose_weights(machine, grid[k], mesh::workspace_poses(machine).size()), VectorXd::Unit(9, k));
  }
  mesh::Pose outside = grid[8];
  outside(0) += 1.0;
  outside(1) += 1.0;
  EXPECT_EQ(pose_weights(machine, outside, mesh::workspace_poses(machine).size()),
            pose_weights(machine, grid[8], mesh::workspace_poses(machine).size()));
}

TEST(PoseWeights, TwoPositionsAreLinearAndManyPiecewise) {
  mesh::Machine machine = test::small_machine();
  machine.workspace.axes = {"X"};
  machine.workspace.positions = {{-0.2, 0.2}};
  mesh::Pose pose = mesh::home_pose(machine);
  pose(0) = 0.1;
  EXPECT_TRUE(pose_weights(machine, pose, mesh::workspace_poses(machine).size()).isApprox(Eigen::Vector2d(0.25, 0.75)));
  machine.workspace.positions = {{-0.2, -0.1, 0.0, 0.2}};
  EXPECT_TRUE(
      pose_weights(machine, pose, mesh::workspace_poses(machine).size()).isApprox(Eigen::Vector4d(0, 0, 0.5, 0.5)));
  machine.workspace.positions = {{0.05}};
  EXPECT_EQ(pose_weights(machine, pose, mesh::workspace_poses(machine).size()), VectorXd::Ones(1));
}

/// A swivel B below the table C, as in a trunnion; the table's own turn is no grid axis.
mesh::Machine swivel_machine() {
  mesh::Machine machine = test::small_machine();
  mesh::Axis b;
  b.id = "B";
  b.kind = mesh::AxisKind::rotary;
  b.direction = Eigen::Vector3d::UnitY();
  b.low = -0.5;
  b.high = 2.0;
  machine.axes.push_back(b);
  machine.bodies[machine.body_index("slide")].axis = "B";
  machine.workspace.table_axes = {"C", "B"};
  machine.workspace.table_positions = {{0.0, 1.0}, {0.0, 0.8, 1.5}};
  return machine;
}

/// f interpolated from the stored poses, minus f, at random poses.
double interpolation_error(const mesh::Machine& machine, const OutputGrid& grid,
                           const std::function<double(const mesh::Pose&)>& f) {
  Numbers number(34);
  double worst = 0;
  VectorXd weights;
  for (int i = 0; i < 40; ++i) {
    mesh::Pose pose = mesh::home_pose(machine);
    pose(0) = number(-0.2, 0.2);
    pose(1) = number(-0.1, 0.1);
    grid.tool_weights(pose, weights);
    double sum = 0;
    for (std::size_t k = 0; k < grid.tool_count(); ++k) sum += weights(k) * f(grid.tool_poses()[k]);
    worst = std::max(worst, std::abs(sum - f(pose)));
  }
  return worst;
}

TEST(PoseWeights, OuterLinesAddWhatTheGridDoesNotSee) {
  const mesh::Machine machine = test::small_machine();
  const OutputGrid stored(machine), coarse(machine, 9);
  ASSERT_EQ(stored.tool_count(), 9u + 2u * 3u * 6u);
  for (const OutputGrid* grid : {&stored, &coarse}) {
    for (std::size_t k = 0; k < grid->tool_count(); ++k) {
      EXPECT_TRUE(pose_weights(machine, grid->tool_poses()[k], grid->tool_count())
                      .isApprox(VectorXd::Unit(grid->tool_count(), k), 1e-13))
          << k;
    }
  }
  EXPECT_DOUBLE_EQ(stored.tool_poses()[9](0), -0.15);
  EXPECT_DOUBLE_EQ(stored.tool_poses()[9](1), -0.1);
  EXPECT_DOUBLE_EQ(stored.tool_poses()[12](0), 0.05) << "the middle is the grid's";
  EXPECT_DOUBLE_EQ(stored.tool_poses()[21](1), 0.0) << "the line through the middle";
  // Cubics of each axis, linear in the other, beside the quadratics of both, which the grid knows; the same with a
  // quadratic of the other axis that is none at its ends.
  const auto cubic = [](const mesh::Pose& p) {
    return 1.0 - 3.0 * p(1) + 5.0 * p(0) * p(1) + 7.0 * p(0) * p(0) * p(1) * p(1) +
           40.0 * p(0) * p(0) * p(0) * (1.0 + 2.0 * p(1)) - 60.0 * p(1) * p(1) * p(1) * (1.0 - 3.0 * p(0));
  };
  EXPECT_LT(interpolation_error(machine, stored, cubic), 1e-13);
  EXPECT_GT(interpolation_error(machine, coarse, cubic), 0.01) << "the lines gain nothing";
  const auto bulge = [&](const mesh::Pose& p) { return cubic(p) + 900.0 * p(0) * p(0) * p(0) * (p(1) * p(1) - 0.01); };
  EXPECT_LT(interpolation_error(machine, stored, bulge), 1e-13);
  EXPECT_GT(interpolation_error(machine, coarse, bulge), 0.02);
  VectorXd weights;
  mesh::Pose pose = mesh::home_pose(machine);
  pose(0) = 0.13, pose(1) = -0.02;
  coarse.grid_weights(pose, weights);
  EXPECT_EQ(weights, pose_weights(machine, pose, 9));
  EXPECT_TRUE(OutputGrid::can_store(machine, 9) && OutputGrid::can_store(machine, 45));
  EXPECT_FALSE(OutputGrid::can_store(machine, 8) || OutputGrid::can_store(machine, 13));
  mesh::Machine two = machine;  // no middle: outer lines alone
  two.workspace.positions[1] = {-0.1, 0.1};
  EXPECT_EQ(OutputGrid(two).tool_count(), 6u + 2u * 6u);
  EXPECT_LT(
      interpolation_error(two, OutputGrid(two), [](const mesh::Pose& p) { return p(0) * p(0) * p(0) * (1.0 + p(1)); }),
      1e-13);
  EXPECT_THROW(OutputGrid(machine, 13), core::SolverError);
}

/// Largest error of 1, cos and sin between the positions.
double turning_error(const mesh::Machine& machine, double low, double high) {
  const std::vector<mesh::Pose> grid = OutputGrid(machine).table_poses();
  Numbers number(31);
  double worst = 0;
  for (int i = 0; i < 50; ++i) {
    mesh::Pose pose = mesh::home_pose(machine);
    pose(2) = number(0.0, 6.0);
    pose(3) = number(low, high);
    const VectorXd weights = table_weights(machine, pose);
    double one = 0, cosine = 0, sine = 0;
    for (std::size_t k = 0; k < grid.size(); ++k) {
      const double w = weights(k);
      one += w, cosine += w * std::cos(grid[k](3)), sine += w * std::sin(grid[k](3));
    }
    worst = std::max(
        {worst, std::abs(one - 1.0), std::abs(cosine - std::cos(pose(3))), std::abs(sine - std::sin(pose(3)))});
  }
  return worst;
}

TEST(TableWeights, AreExactForWhatStandsStillWhileTheTableTilts) {
  mesh::Machine machine = swivel_machine();
  const std::vector<mesh::Pose> grid = OutputGrid(machine).table_poses();
  ASSERT_EQ(grid.size(), 16u) << "six degrees apart at most";
  EXPECT_EQ(grid[8](3), 0.8);
  EXPECT_EQ(grid[4](3), 0.4);
  EXPECT_EQ(grid[8](2), 0.0) << "the table's own axis stands at 0";
  EXPECT_EQ(OutputGrid(machine).table_grid_places(), (std::vector<std::size_t>{0, 8, 15}));
  EXPECT_LT(turning_error(machine, 0.0, 1.5), 1e-13);
  for (std::size_t k = 0; k < grid.size(); ++k)
    EXPECT_TRUE(table_weights(machine, grid[k]).isApprox(VectorXd::Unit(16, k), 1e-14));
  mesh::Pose beyond = grid.back();
  beyond(3) = 1.9;
  EXPECT_EQ(table_weights(machine, beyond), table_weights(machine, grid.back()));
  VectorXd coarse;
  OutputGrid(machine).table_grid_weights(grid[8], coarse);
  EXPECT_TRUE(coarse.isApprox(Eigen::Vector3d(0, 1, 0), 1e-14));
  OutputGrid(machine).table_grid_weights(grid[4], coarse);
  EXPECT_NEAR(coarse.dot(Eigen::Vector3d(std::cos(grid[0](3)), std::cos(grid[8](3)), std::cos(grid[15](3)))),
              std::cos(0.4), 1e-13);

  machine.workspace.table_positions[1] = {-0.4, 0.0, 0.3, 0.8, 1.5};
  EXPECT_LT(turning_error(machine, -0.4, 1.5), 1e-13);
  mesh::Pose left = mesh::home_pose(machine), right = left;
  left(3) = 0.8 - 1e-9, right(3) = 0.8 + 1e-9;
  EXPECT_LT((table_weights(machine, left) - table_weights(machine, right)).norm(), 1e-7) << "no step at a stored angle";
  machine.workspace.table_positions[1] = {0.0, 1.0};
  EXPECT_LT(turning_error(machine, 0.0, 1.0), 1e-13) << "two angles have others between them";
}

TEST(TableWeights, LinearAxesBelowTheTableAreGridAxesToo) {
  const mesh::Machine machine = test::small_machine();
  const std::vector<mesh::Pose> grid = OutputGrid(machine).table_poses();
  ASSERT_EQ(grid.size(), 3u) << "X carries the table, Z does not";
  EXPECT_EQ(grid[0](0), -0.2);
  EXPECT_EQ(grid[2](0), 0.2);
}

TEST(TableWeights, AnEndlessTiltAxisClosesItsTurn) {
  mesh::Machine machine = swivel_machine();
  machine.axes.back().endless = true;
  machine.workspace.table_axes = {"B"};
  machine.workspace.table_positions = {{0.0, 2.0, 4.0}};
  mesh::Pose pose = mesh::home_pose(machine);
  const double turn = 2.0 * std::acos(-1.0);
  EXPECT_LT(turning_error(machine, -10.0, 10.0), 1e-12);
  pose(3) = 5.0;
  const VectorXd here = table_weights(machine, pose);
  pose(3) = 5.0 - 2.0 * turn;
  EXPECT_TRUE(table_weights(machine, pose).isApprox(here, 1e-12));
  machine.workspace.table_positions = {{0.0, 2.0}};
  pose(3) = 0.5 * (2.0 + turn);
  EXPECT_TRUE(table_weights(machine, pose).isApprox(Eigen::Vector2d(0.5, 0.5), 1e-12));
}

}  // namespace
}  // namespace thermotwin::reduction
