// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/operating_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <numbers>

#include "core/error.h"
#include "solver/operation/chiller.h"
#include "solver/operation/film_laws.h"
#include "solver/operation/grid_occupancy.h"
#include "solver/operation/layout.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::solver {

namespace {

constexpr double turn = 2.0 * std::numbers::pi;

JointGrid linear_grid() { return {0, false, {-0.4, -0.3, -0.1, 0.0, 0.25, 0.4}}; }
JointGrid ring_grid() {
  JointGrid grid{0, true, {}};
  for (int i = 0; i < 12; ++i) grid.positions.push_back(turn * i / 12.0);
  return grid;
}

/// Mean of the hat functions over the range by the midpoint rule with many points.
Eigen::VectorXd sampled(const JointGrid& grid, double low, double high) {
  constexpr int points = 200000;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(std::ssize(grid.positions));
  for (int i = 0; i < points; ++i) {
    const double x = low + (high - low) * (i + 0.5) / points;
    sum += grid_weights(grid, x, x);
  }
  return sum / points;
}

struct Rig {
  mesh::Machine machine = test::slide_machine();
  Layout layout = make_layout(machine, {{0, false, {-0.2, -0.1, 0.0, 0.1, 0.2}}, {-1, false, {0.0}}});
  OperatingModel model{machine, layout};
  Eigen::VectorXd row = model.channels().defaults();
  Eigen::VectorXd inlet = Eigen::VectorXd::Constant(1, -2.0);
  double& at(const std::string& name) { return row[model.channels().index(name)]; }
};

}  // namespace

TEST(GridWeights, AreHatFunctionsAtOnePosition) {
  const Eigen::VectorXd w = grid_weights(linear_grid(), -0.15, -0.15);
  EXPECT_NEAR(w[1], 0.25, 1e-12);
  EXPECT_NEAR(w[2], 0.75, 1e-12);
  EXPECT_NEAR(w.sum(), 1.0, 1e-12);
  EXPECT_DOUBLE_EQ(grid_weights(linear_grid(), 0.9, 0.9)[5], 1.0);  // beyond the end
  EXPECT_DOUBLE_EQ(grid_weights(linear_grid(), -0.4, -0.4)[0], 1.0);
  EXPECT_DOUBLE_EQ(grid_weights({-1, false, {0.0}}, 3.0, 5.0)[0], 1.0);
}

TEST(GridWeights, OfAPendularMotionAreTheExactMean) {
  for (auto [low, high] : {std::pair{-0.4, 0.4}, {-0.35, 0.31}, {-0.05, -0.02}, {0.39, 0.6}, {-0.5, 0.5}}) {
    const Eigen::VectorXd w = grid_weights(linear_grid(), low, high);
    EXPECT_GE(w.minCoeff(), 0.0);
    EXPECT_NEAR(w.sum(), 1.0, 1e-12);
    EXPECT_LT((w - sampled(linear_grid(), low, high)).cwiseAbs().maxCoeff(), 1e-5) << low << " " << high;
  }
}

TEST(GridWeights, GoRoundAnEndlessAxis) {
  const Eigen::VectorXd last = grid_weights(ring_grid(), turn * 11.5 / 12, turn * 11.5 / 12);
  EXPECT_NEAR(last[11], 0.5, 1e-9);
  EXPECT_NEAR(last[0], 0.5, 1e-9);
  EXPECT_LT((grid_weights(ring_grid(), 0.3 - 3 * turn, 0.3 - 3 * turn) - grid_weights(ring_grid(), 0.3, 0.3)).norm(),
            1e-9);
  EXPECT_LT((grid_weights(ring_grid(), 0.1, 0.1 + turn).array() - 1.0 / 12).abs().maxCoeff(), 1e-12);
  for (auto [low, high] : {std::pair{-1.0, 1.0}, {5.5, 8.0}, {0.2, 0.2 + 2.4 * turn}}) {
    const Eigen::VectorXd w = grid_weights(ring_grid(), low, high);
    EXPECT_GE(w.minCoeff(), 0.0);
    EXPECT_NEAR(w.sum(), 1.0, 1e-12);
    EXPECT_LT((w - sampled(ring_grid(), low, high)).cwiseAbs().maxCoeff(), 1e-5) << low << " " << high;
  }
}

TEST(OperatingModel, DefaultsStandStill) {
  Rig s;
  const Coefficients c = s.model.coefficients(s.row, s.inlet);
  EXPECT_NEAR(s.model.source_powers(s.row)[0], 0.0, 1e-12);
  EXPECT_NEAR(s.model.source_powers(s.row)[2], 40.0, 1e-12);  // standstill losses
  EXPECT_EQ(c.p[1], 0.0);                                     // no cutting fluid
  const double wall = free_convection(mesh::Orientation::vertical, 1.0, 3.0, 293.15);
  EXPECT_NEAR(c.p[0], wall + radiation(0.9, 293.15), 1e-12);
  EXPECT_NEAR(c.p[2], wall, 1e-12);
  EXPECT_NEAR(c.p.segment(3, 5).sum(), 1500.0, 1e-9);
  EXPECT_NEAR(c.p[5], 1500.0, 1e-9);
}

TEST(OperatingModel, FilmOfTheDiscBlendsAndStatesMultiply) {
  Rig s;
  s.at("spindle.speed_rpm") = 3000;
  s.at("cutting_fluid.on") = 1;
  const double wall = free_convection(mesh::Orientation::vertical, 1.0, 3.0, 293.15);
  const double forced = 0.3 * rotating_disc(3000 * turn / 60, 0.2);
  EXPECT_NEAR(s.model.film_coefficient(2, s.row), std::cbrt(std::pow(wall, 3) + std::pow(forced, 3)), 1e-9);
  EXPECT_DOUBLE_EQ(s.model.film_coefficient(1, s.row), 300.0);
}

TEST(OperatingModel, PowersFollowTheirLawsOrTheMeasuredDrive) {
  Rig s;
  s.at("spindle.speed_rpm") = -9000;  // the magnitude counts
  EXPECT_NEAR(s.model.source_powers(s.row)[0], 170.0, 1e-9);
  s.at("spindle.speed_rpm") = 20000;
  EXPECT_NEAR(s.model.source_powers(s.row)[0], 240.0, 1e-9);
  s.machine.sources[0].drive = "spindle";
  s.machine.sources[0].drive_loss_share = 0.1;
  s.machine.sources[0].scale.value = 2.0;
  const OperatingModel driven(s.machine, s.layout);
  Eigen::VectorXd row = driven.channels().defaults();
  row[driven.channels().index("spindle.speed_rpm")] = 6000;
  EXPECT_NEAR(driven.source_powers(row)[0], 200.0, 1e-9);
  row[driven.channels().index("spindle.power_W")] = 1500;
  EXPECT_NEAR(driven.source_powers(row)[0], 300.0, 1e-9);
}

TEST(OperatingModel, ALawOverTheTimeOfDayRepeatsDaily) {
  mesh::Machine machine = test::slide_machine();
  EXPECT_EQ(Channels(machine).index("day.time_h"), -1) << "no law asks for it";
  machine.sources[0].laws = {{"day.time_h", {0, 6, 8, 20, 24}, {10, 10, 90, 90, 10}}};
  const Layout layout = make_layout(machine, {{0, false, {-0.2, 0.2}}, {-1, false, {0.0}}});
  const OperatingModel model(machine, layout);
  Eigen::VectorXd row = model.channels().defaults();
  const int hour = model.channels().index("day.time_h");
  ASSERT_EQ(hour, model.channels().size() - 1) << "behind all others, whose places stay";
  const double scale = machine.sources[0].scale.value;
  const auto power = [&](double at) {
    row[hour] = at;
    return model.source_powers(row)[0] / scale;
  };
  const double standstill = power(not_given);
  for (const double day : {0.0, 24.0, 48.0}) {
    EXPECT_NEAR(power(day + 3) - standstill, 10, 1e-9);
    EXPECT_NEAR(power(day + 7) - standstill, 50, 1e-9);
    EXPECT_NEAR(power(day + 22) - standstill, 50, 1e-9);
  }
  EXPECT_NEAR(power(-17) - standstill, 50, 1e-9) << "seven of the day before";
}

TEST(OperatingModel, AmbientsFollowEachOther) {
  Rig s;
  s.at("air.T_C") = 27.0;
  EXPECT_NEAR(s.model.ambient_K(1, s.row), 6.0, 1e-12);  // foundation = air - 1
  s.at("foundation.T_C") = 22.0;
  EXPECT_NEAR(s.model.ambient_K(1, s.row), 2.0, 1e-12);
}

TEST(OperatingModel, InputsCarryTheirTerms) {
  Rig s;
  s.at("air.T_C") = 25.0;
  s.at("axis.X.position_mm") = 50.0;
  s.at("axis.X.feed_mm_min") = 15000.0;
  const Coefficients c = s.model.coefficients(s.row, s.inlet);
  double joint_power = 0.0;
  for (std::size_t k = 0; k < s.layout.inputs.size(); ++k) {
    const Input& input = s.layout.inputs[k];
    const double q = c.q[k];
    if (input.kind == InputKind::film_ambient && input.item == 0) {
      EXPECT_NEAR(q, 5.0 * c.p[0], 1e-12);
    }
    if (input.kind == InputKind::contact_ambient) {
      EXPECT_NEAR(q, 50.0 * 4.0, 1e-12);
    }
    if (input.kind == InputKind::coolant_inlet) {
      EXPECT_NEAR(q, 0.02 * -2.0, 1e-15);
    }
    if (input.kind == InputKind::source && input.item == 1) joint_power += q;
  }
  EXPECT_NEAR(joint_power, 45.0, 1e-9);
  EXPECT_NEAR(s.model.pose(s.row)[0], 0.05, 1e-15);
  s.at("coolant.main.on") = 0;
  const Coefficients off = s.model.coefficients(s.row, s.inlet);
  for (std::size_t t = 0; t < s.layout.terms.size(); ++t) {
    if (s.layout.terms[t].kind == TermKind::coolant_flow) {
      EXPECT_EQ(off.p[t], 0.0);
    }
    if (s.layout.terms[t].kind == TermKind::coolant_wall) {
      EXPECT_GT(off.p[t], 0.0);
    }
  }
}

TEST(OperatingModel, RefusesAnUnknownChannel) {
  Rig s;
  s.machine.sources[0].laws[0].input = "spindle.sped_rpm";
  EXPECT_THROW(OperatingModel(s.machine, s.layout), core::InputError);
}

TEST(Chiller, FollowsItsGuideExactly) {
  Rig s;
  s.machine.coolants[0].guide_offset = 1.5;
  Chiller chiller(s.machine, s.layout, s.model.channels(), Eigen::VectorXd::Zero(1));
  const Eigen::VectorXd air = Eigen::VectorXd::Zero(1);
  const Eigen::VectorXd sensors = Eigen::Vector2d(3.0, 9.0);
  chiller.advance(s.row, sensors, air, 50.0);
  chiller.advance(s.row, sensors, air, 70.0);
  EXPECT_NEAR(chiller.outlet_K()[0], 4.5 * (1.0 - std::exp(-1.0)), 1e-12);
  s.at("coolant.main.inlet_T_C") = 21.0;
  EXPECT_NEAR(chiller.advance(s.row, sensors, air, 1.0)[0], 1.0, 1e-12);
  s.at("coolant.main.inlet_T_C") = not_given;
  s.at("coolant.main.on") = 0.0;
  EXPECT_NEAR(chiller.advance(s.row, sensors, air, 1000.0)[0], 1.0, 1e-12);
}

}  // namespace thermotwin::solver
