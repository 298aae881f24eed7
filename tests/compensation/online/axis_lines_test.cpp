// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/axis_lines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "compensation/online/compensator.h"
#include "mesh/machine/kinematics.h"
#include "tests/compensation/scratch.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using Eigen::VectorXd;

class AxisLines : public ::testing::Test {
protected:
  AxisLines() : poses_{mesh::home_pose(model_.machine)} {
    const test::Truth run = test::run_truth(model_.machine, model_, 60.0, 1, 3 * 3600.0, poses_);
    for (std::size_t i = 0; i < run.time.size(); ++i) offsets_ = compensator_.step(run.time[i], run.rows[i], {});
    lines_ = axis_lines(compensator_, map_, model_.machine, offsets_.offset_um);
  }

  int axis(std::size_t line) const { return model_.machine.axis_index(compensator_.axes()[line]); }
  double offset_at(mesh::Pose pose, std::size_t line, double position) const {
    pose[axis(line)] = position;
    return offsets_um(pose)[line];
  }
  VectorXd offsets_um(const mesh::Pose& pose) const { return 1e6 * map_.offsets(compensator_.tcp(pose)); }

  reduction::ReducedModel model_ = test::lumped_model();
  std::vector<mesh::Pose> poses_;
  Compensator compensator_{model_};
  OutputMap map_{model_};
  Offsets offsets_;
  std::vector<AxisLine> lines_;
};

TEST_F(AxisLines, AreExactAtThePresentPose) {
  ASSERT_EQ(std::ssize(lines_), offsets_.offset_um.size());
  const mesh::Pose present = compensator_.pose();
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    EXPECT_EQ(lines_[k].reference, present[axis(k)]);
    EXPECT_EQ(lines_[k].offset_um, offsets_.offset_um[k]);
    EXPECT_NEAR(lines_[k].offset_um, offsets_um(present)[k], 1e-9) << "the guard has nothing to hold back";
  }
}

TEST_F(AxisLines, LeaveWhatTheyState) {
  double largest = 0.0;
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const std::vector<double>& ends = model_.machine.workspace.positions[k];
    double along = 0.0;
    for (int i = 0; i <= 20; ++i) {
      const double at = std::lerp(ends.front(), ends.back(), i / 20.0);
      const double line = lines_[k].offset_um + lines_[k].slope_um_m * (at - lines_[k].reference);
      along = std::max(along, std::abs(offset_at(compensator_.pose(), k, at) - line));
    }
    EXPECT_NEAR(along, lines_[k].left_travel_um, 1e-9);
    EXPECT_GE(lines_[k].left_across_um, 0.5 * lines_[k].left_travel_um);
    largest = std::max(largest, std::abs(lines_[k].slope_um_m));
  }
  EXPECT_GT(largest, 1.0) << "um per m: a warm machine has offsets that follow the axes";
}

TEST_F(AxisLines, NoOtherSlopeLeavesLessSquares) {
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const std::vector<double>& ends = model_.machine.workspace.positions[k];
    const auto squares = [&](double slope) {
      double sum = 0.0;
      for (int i = 0; i <= 20; ++i) {
        const double at = std::lerp(ends.front(), ends.back(), i / 20.0);
        const double line = lines_[k].offset_um + slope * (at - lines_[k].reference);
        sum += std::pow(offset_at(compensator_.pose(), k, at) - line, 2);
      }
      return sum;
    };
    const double best = squares(lines_[k].slope_um_m);
    EXPECT_LE(best, squares(lines_[k].slope_um_m + 1e-3) + 1e-9);
    EXPECT_LE(best, squares(lines_[k].slope_um_m - 1e-3) + 1e-9);
  }
}

TEST_F(AxisLines, TablesHoldTheErrorsAlongTheAxes) {
  const ErrorTables tables = error_tables(compensator_, model_.machine);
  // An axis may move in another direction of machine.toml than its letter says.
  mesh::Machine other = model_.machine;
  for (auto& axis : other.axes) axis.direction = {axis.direction.z(), -axis.direction.x(), axis.direction.y()};
  const ErrorTables of_other = error_tables(compensator_, other);
  for (std::size_t a = 0; a < tables.axes.size(); ++a) {
    EXPECT_EQ(std::string("XYZ").find(tables.axes[a].axis), static_cast<std::size_t>(tables.axes[a].along));
    EXPECT_EQ(of_other.axes[a].along, (tables.axes[a].along + 1) % 3);
  }
  ASSERT_EQ(tables.axes.size(), lines_.size());
  mesh::Pose middle = compensator_.pose();
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const std::vector<double>& ends = model_.machine.workspace.positions[k];
    middle[axis(k)] = 0.5 * (ends.front() + ends.back());
  }
  const int swivel = model_.machine.axis_index("B"), turn = model_.machine.axis_index("C");
  middle[swivel] = std::numbers::pi / 4;
  middle[turn] = 0.0;
  ASSERT_EQ(tables.rotary.size(), 2U);
  EXPECT_NEAR(tables.rotary[0].middle, std::numbers::pi / 4, 1e-12);
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const AxisErrors& table = tables.axes[k];
    mesh::Pose end = middle;
    end[axis(k)] = table.position[table.position.size() - 1];
    const VectorXd expected = 1e6 * (compensator_.tcp(end).error - compensator_.tcp(middle).error);
    EXPECT_LT((table.errors.rightCols(1) - expected).norm(), 1e-9) << table.axis;
    EXPECT_LT(table.errors.col(10).norm(), 1e-6) << "at the middle of the workspace nothing is left";
  }
  // At a corner of the workspace the sum of the tables is off by no more than what they state.
  mesh::Pose corner = middle;
  Eigen::Vector3d sum = tables.at_middle.head<3>();
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    corner[axis(k)] = tables.axes[k].position[0];
    sum += tables.axes[k].errors.col(0).head<3>();
  }
  const Eigen::Vector3d left = (1e6 * compensator_.tcp(corner).error.head<3>() - sum).cwiseAbs();
  for (int i = 0; i < 3; ++i) {
    EXPECT_LE(left[i], tables.left_at_rotary_middle_um[i] + 1e-9) << i;
    EXPECT_LE(tables.left_at_rotary_middle_um[i], tables.left_um[i] + 1e-9) << i;
  }
  // No table knows that B and C turn.
  corner[swivel] = std::numbers::pi / 2;
  corner[turn] = std::numbers::pi / 2;
  const Eigen::Vector3d turned = (1e6 * compensator_.tcp(corner).error.head<3>() - sum).cwiseAbs();
  for (int i = 0; i < 3; ++i) EXPECT_LE(turned[i], tables.left_um[i] + 1e-9) << i;
  EXPECT_GT(tables.left_um.maxCoeff(), tables.left_at_rotary_middle_um.maxCoeff() + 1e-3);
}

TEST_F(AxisLines, WhatIsLeftAcrossHoldsWhereTheRotaryAxesTurn) {
  const int swivel = model_.machine.axis_index("B"), turn = model_.machine.axis_index("C");
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    double left = 0.0;
    for (mesh::Pose pose : mesh::workspace_poses(model_.machine)) {
      for (const double b : {0.0, std::numbers::pi / 4, std::numbers::pi / 2}) {
        for (int quarter = 0; quarter < 4; ++quarter) {
          pose[swivel] = b;
          pose[turn] = quarter * std::numbers::pi / 2;
          const double line = lines_[k].offset_um + lines_[k].slope_um_m * (pose[axis(k)] - lines_[k].reference);
          left = std::max(left, std::abs(offsets_um(pose)[static_cast<Eigen::Index>(k)] - line));
        }
      }
    }
    EXPECT_NEAR(lines_[k].left_across_um, left, 1e-9);
  }
}

}  // namespace
}  // namespace thermotwin::compensation
