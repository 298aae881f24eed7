// SPDX-License-Identifier: GPL-3.0-or-later
// Each law against a number worked out by hand, monotonic, and zero where it has to be.
#include "solver/operation/loss_laws.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "solver/operation/layout.h"
#include "solver/operation/load_program.h"
#include "solver/operation/operating_model.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::solver {
namespace {

constexpr double pi = std::numbers::pi;

mesh::BearingLoss bearing() { return {1.7, 0.001, 0.085, 22e-6, 500.0, 2.0}; }

TEST(BearingLoss, MatchesTheFormulaByHand) {
  // nu n = 22 * 6000 = 132,000; ^(2/3) = 2592.5; M0 = 1e-7 * 1.7 * 2592.5 * 85^3 = 270.66 N mm;
  // M1 = 0.001 * 500 * 85 = 42.5 N mm; two bearings 0.62632 N m; at 628.32 rad/s 393.53 W.
  EXPECT_NEAR(bearing_torque(bearing(), 100.0), 0.626317, 1e-6);
  EXPECT_NEAR(loss_power(bearing(), 100.0), 393.527, 1e-3);
  // nu n = 22 * 60 = 1320: M0 = 160e-7 * 1.7 * 85^3 = 16.704 N mm; (16.704 + 42.5) * 2 * 2 pi / 1000
  EXPECT_NEAR(loss_power(bearing(), 1.0), 0.74398, 1e-4);
  EXPECT_DOUBLE_EQ(loss_power(bearing(), -100.0), loss_power(bearing(), 100.0));
}

TEST(GuideLoss, IsForceTimesSpeed) {
  EXPECT_DOUBLE_EQ(loss_power(mesh::GuideLoss{120.0, 40.0}, -0.5), 70.0);  // (120 + 20) * 0.5
}

TEST(ScrewLoss, HasDragOfThePreloadAndLossOfTheLoad) {
  // tan(beta) = 20 / (pi 40) = 0.159155; K = 0.05 / 0.398942 = 0.125331; 0.125331 * 3000 = 375.99 N;
  // 900 * 0.1 / 0.9 = 100 N; at 0.5 m/s 238.0 W.
  const mesh::ScrewLoss screw{0.020, 0.040, 3000.0, 900.0, 0.9};
  EXPECT_NEAR(loss_power(screw, 0.5), 0.5 * (375.994 + 100.0), 1e-3);
  // A screw without friction: nothing but the drag, which goes with the preload.
  EXPECT_NEAR(loss_power(mesh::ScrewLoss{0.020, 0.040, 0.0, 900.0, 1.0}, 0.5), 0.0, 1e-15);
}

TEST(MotorLoss, IsCopperHysteresisAndEddies) {
  mesh::MotorLoss motor;
  motor.torque = {{0.0, 50.0}, {4.0, 12.0}};
  motor.torque_constant = 1.5;
  motor.resistance = 0.4;
  motor.winding_C = 105.0;  // copper: 340 / 255 = 4 / 3
  motor.hysteresis = 30.0;
  motor.eddy = 20.0;
  motor.nominal_speed = 50.0;
  // at 25 turns/s M = 8, I = 5.3333: 3 * 0.4 * 4/3 * 28.444 = 45.511; 15 + 5 of iron
  EXPECT_NEAR(loss_power(motor, 25.0, 1.0), 65.511, 1e-3);
  EXPECT_NEAR(loss_power(motor, 0.0, 1.0), 3 * 0.4 * 4.0 / 3.0 * 16.0 / 2.25, 1e-12);  // holds 4 N m
  EXPECT_DOUBLE_EQ(loss_power(motor, 0.0, 0.0), 0.0);
  EXPECT_NEAR(loss_power(motor, 25.0, 0.0), 20.0, 1e-12);  // runs down without current
}

TEST(Losses, RiseWithSpeedFromNothing) {
  mesh::MotorLoss motor;
  motor.hysteresis = motor.eddy = 10.0;
  motor.nominal_speed = 50.0;
  motor.torque = {{0.0}, {0.0}};
  double before[4] = {0, 0, 0, 0};
  for (int i = 0; i <= 4000; ++i) {
    const double n = 0.001 * i;  // through the change of the bearing's law at 92 rpm
    const double now[4] = {loss_power(bearing(), n), loss_power(mesh::GuideLoss{100, 10}, n),
                           loss_power(mesh::ScrewLoss{0.01, 0.04, 1000, 500, 0.9}, n), loss_power(motor, n, 1.0)};
    for (int k = 0; k < 4; ++k) {
      if (i == 0) {
        EXPECT_EQ(now[k], 0.0) << k;
      }
      if (i > 0) {
        EXPECT_GT(now[k], before[k]) << k << " at " << n;
      }
      before[k] = now[k];
    }
  }
}

TEST(HoldingLoss, RisesWithTheAngleAsMeasured) {
  // Gebhardt (2014), Fig. 4.31 (1): 0 W at 0 deg to 3.5 kW at 90 deg in steps of 5 deg.
  const mesh::HoldingLoss drive{0.0, 3500.0, 1.0}, copper{0.0, 3500.0, 0.0};
  double before = -1.0;
  for (int deg = 0; deg <= 90; deg += 5) {
    const double phi = deg * pi / 180.0, now = loss_power(drive, phi, phi);
    EXPECT_NEAR(now, 3500.0 * std::sin(phi), 1e-9);
    EXPECT_NEAR(loss_power(copper, phi, phi), 3500.0 * std::pow(std::sin(phi), 2), 1e-9);
    EXPECT_GT(now, before);
    EXPECT_DOUBLE_EQ(loss_power(drive, -phi, -phi), now);
    before = now;
  }
  EXPECT_EQ(loss_power(drive, 0.0, 0.0), 0.0);
  EXPECT_NEAR(loss_power(drive, pi / 2, pi / 2), 3500.0, 1e-9);
}

TEST(HoldingLoss, TakesTheMeanOverARange) {
  for (const double share : {0.0, 0.3, 1.0}) {
    for (const auto& [low, high] : {std::pair{-1.2, 1.3}, {0.2, 0.9}, {-3.0, 5.0}, {1.0, 1.0 + 1e-4}}) {
      const mesh::HoldingLoss loss{0.4, 800.0, share};
      double sum = 0.0;
      constexpr int points = 20000;
      for (int i = 0; i < points; ++i) {
        const double at = low + (high - low) * (i + 0.5) / points;
        sum += loss_power(loss, at, at);
      }
      EXPECT_NEAR(loss_power(loss, low, high), sum / points, 2e-4) << share << " " << low;
      EXPECT_DOUBLE_EQ(loss_power(loss, high, low), loss_power(loss, low, high));
    }
  }
  // from -90 to 90 deg: mean of |sin| is 2 / pi, of its square a half
  EXPECT_NEAR(loss_power(mesh::HoldingLoss{0.0, 3500.0, 1.0}, -pi / 2, pi / 2), 3500.0 * 2 / pi, 1e-9);
  EXPECT_NEAR(loss_power(mesh::HoldingLoss{0.0, 3500.0, 0.0}, -pi / 2, pi / 2), 1750.0, 1e-9);
}

TEST(HoldingLoss, DependsOnTheSideThatItCameFrom) {
  // Gebhardt (2014), Fig. 4.31: 3.5 kW with a horizontal lever arm, and nearly 1 kW between the two sides.
  const mesh::HoldingLoss drive{0.0, 3500.0, 1.0, 0.14}, copper{0.0, 3500.0, 0.0, 0.14};
  EXPECT_NEAR(loss_power(drive, pi / 4, pi / 4, 1.0), 3500.0 * (std::sqrt(0.5) + 0.14), 1e-9);
  EXPECT_NEAR(loss_power(drive, pi / 4, pi / 4, 0.0), 3500.0 * (std::sqrt(0.5) - 0.14), 1e-9);
  EXPECT_NEAR(loss_power(copper, pi / 4, pi / 4, 1.0), 3500.0 * std::pow(std::sqrt(0.5) + 0.14, 2), 1e-9);
  // On the other side of the balance a motion in negative direction lifts the mass.
  EXPECT_NEAR(loss_power(drive, -pi / 4, -pi / 4, 0.0), 3500.0 * (std::sqrt(0.5) + 0.14), 1e-9);
  EXPECT_NEAR(loss_power(copper, pi / 4, pi / 4), 3500.0 * (0.5 + 0.14 * 0.14), 1e-9);  // mean of both
  EXPECT_NEAR(loss_power(drive, 0.0, 0.0, 1.0), 3500.0 * 0.14, 1e-9);
}

TEST(HoldingLoss, TakesTheMeanOverARangeWithFriction) {
  for (const double share : {0.0, 0.3, 1.0}) {
    for (const double friction : {0.05, 0.5, 1.0}) {
      for (const auto& [low, high] : {std::pair{-1.2, 1.3}, {0.2, 0.9}, {-3.0, 5.0}, {3.3, 6.1}, {-7.0, 9.0}}) {
        const mesh::HoldingLoss loss{0.4, 800.0, share, friction};
        for (const double positive : {0.0, 0.25, 1.0}) {
          double sum = 0.0;
          constexpr int points = 20000;
          for (int i = 0; i < points; ++i) {
            const double at = low + (high - low) * (i + 0.5) / points;
            sum += loss_power(loss, at, at, positive);
          }
          EXPECT_NEAR(loss_power(loss, low, high, positive), sum / points, 2e-4)
              << share << " " << friction << " " << low << " " << positive;
        }
      }
    }
  }
}

/// The sliding bed with a swivel axis that holds, and a guide, in one source each.
struct Rig {
  mesh::Machine machine = with_losses();
  Layout layout = make_layout(machine, {{0, false, {-0.2, -0.1, 0.0, 0.1, 0.2}}, {-1, false, {0.0}}});
  OperatingModel model{machine, layout};
  Eigen::VectorXd row = model.channels().defaults();
  double& at(const std::string& name) { return row[model.channels().index(name)]; }
  double power(int source) const { return model.source_powers(row)[source]; }

  static mesh::Machine with_losses() {
    mesh::Machine m = test::slide_machine();
    mesh::Axis tilt;
    tilt.id = "B";
    tilt.kind = mesh::AxisKind::rotary;
    tilt.direction = Eigen::Vector3d::UnitY();
    tilt.low = -2.0;
    tilt.high = 2.0;
    tilt.rapid = 5.0;
    m.axes.push_back(tilt);
    mesh::SourceSpec friction;
    friction.id = "losses";
    friction.losses = {{"X", 1.0, mesh::GuideLoss{120.0, 40.0}}, {"X", 1.0 / 0.02, bearing()}};
    friction.places = {test::at_joint("X_guide", 1.0, 0.5)};
    friction.scale = {2.0, 0.0};
    mesh::SourceSpec hold;
    hold.id = "hold";
    hold.losses = {{"B", 1.0, mesh::HoldingLoss{0.0, 1000.0, 0.0}}};
    hold.places = {test::on_surface("slide.top")};
    mesh::SourceSpec seat;
    seat.id = "seat";
    seat.losses = {{"spindle", 1.5, bearing()}, {"B", 2.0, bearing()}};
    seat.places = {test::on_surface("slide.top")};
    m.sources = {friction, hold, seat};
    m.joints[0].law = {{2e6, 0.0}, 5e6, 1e6, 0.95, {}, {}};
    return m;
  }
};

TEST(LossInput, TurnsFeedsIntoSpeeds) {
  Rig s;
  EXPECT_EQ(s.power(0), 0.0);
  s.at("axis.X.feed_mm_min") = 30000;  // 0.5 m/s, 25 turns a second of a screw of 20 mm
  EXPECT_NEAR(s.power(0), 2.0 * (70.0 + loss_power(bearing(), 25.0)), 1e-9);
  s.at("spindle.speed_rpm") = -6000;
  s.at("axis.B.feed_deg_min") = 3600;  // 10 turns a minute
  EXPECT_NEAR(s.power(2), loss_power(bearing(), 150.0) + loss_power(bearing(), 1.0 / 3.0), 1e-9);
}

TEST(LossInput, HoldsWhileOnAndNotClamped) {
  Rig s;
  s.at("axis.B.position_deg") = 90.0;
  EXPECT_NEAR(s.power(1), 1000.0, 1e-9);  // at standstill
  s.at("axis.B.clamp.on") = 1.0;
  EXPECT_EQ(s.power(1), 0.0);
  s.at("axis.B.clamp.on") = 0.0;
  s.at("machine.on") = 0.0;
  EXPECT_EQ(s.power(1), 0.0);
  s.at("machine.on") = 1.0;
  s.at("axis.B.low_deg") = -90.0;
  s.at("axis.B.high_deg") = 90.0;
  EXPECT_NEAR(s.power(1), 500.0, 1e-9);
}

TEST(LossInput, FindsItsHottestRow) {
  Rig s;
  const auto hottest = [&](std::size_t source, std::size_t k) {
    const mesh::LossLaw& loss = s.machine.sources[source].losses[k];
    const LossInput input(s.machine, s.model.channels(), loss);
    Eigen::VectorXd row = s.row;
    input.set_hottest(loss, s.machine, row);
    return input.power(loss, row);
  };
  EXPECT_NEAR(hottest(1, 0), 1000.0, 1e-9);                            // 90 deg is within +-114.6 deg
  EXPECT_NEAR(hottest(0, 0), (120.0 + 40.0) * 1.0, 1e-9);              // rapid 1 m/s
  EXPECT_NEAR(hottest(2, 0), loss_power(bearing(), 1.5 * 200), 1e-9);  // 12000 rpm
  s.machine.axes[1].high = 1.0;  // 90 deg out of reach: -2 rad is steeper than 1 rad
  s.machine.axes[1].low = -1.2;
  EXPECT_NEAR(hottest(1, 0), 1000.0 * std::pow(std::sin(1.2), 2), 1e-9);
}

TEST(ContactLaw, ConductanceFollowsThePressure) {
  Rig s;
  const auto guide = [&] { return s.model.coefficients(s.row, Eigen::VectorXd::Zero(1)).p.segment(3, 5).sum(); };
  EXPECT_NEAR(guide(), 1500.0 * std::pow(2.0, 0.95), 1e-9);
  EXPECT_EQ(s.model.channels().index("axis.Y.clamp.on"), -1);
  s.at("axis.X.clamp.on") = 1.0;
  EXPECT_NEAR(guide(), 1500.0 * std::pow(5.0, 0.95), 1e-9);
  mesh::ContactLaw table;
  table.pressure.value = 3e6;
  table.by_pressure = {{1e6, 2e6, 4e6}, {1.0, 1.8, 3.0}};
  EXPECT_NEAR(table.factor(false), 2.4, 1e-12);
  EXPECT_NEAR(table.factor(true), 2.4, 1e-12);  // no other pressure while clamped
  EXPECT_EQ(mesh::ContactLaw{}.factor(true), 1.0);
}

TEST(LoadProgram, ClampsAnAxisForAPhase) {
  const Rig s;
  const std::string text = R"(schema = 1
[[phase]]
duration_h = 1
[[phase.axis]]
id = "B"
position_deg = 45
clamped = true
[[phase]]
duration_h = 1
)";
  const LoadProgram program = LoadProgram::parse(text, "loads/hold.toml", s.machine);
  const int clamped = s.model.channels().index("axis.B.clamp.on");
  EXPECT_EQ(program.row(0.0, 600.0)[clamped], 1.0);
  EXPECT_EQ(program.row(3600.0, 4200.0)[clamped], 0.0);
  std::string moving = text;
  moving.replace(moving.find("position_deg = 45"), 17, "low_deg = 0\nhigh_deg = 9\nfeed_deg_min = 60");
  EXPECT_THROW(LoadProgram::parse(moving, "loads/hold.toml", s.machine), core::InputError);
}

TEST(LoadProgram, KnowsTheDirectionOfTheLastMotion) {
  Rig plain;
  EXPECT_EQ(plain.model.channels().index("axis.B.positive.on"), -1) << "no law asks for it";
  mesh::Machine machine = Rig::with_losses();
  std::get<mesh::HoldingLoss>(machine.sources[1].losses[0].law).friction = 0.1;
  const Channels channels(machine);
  const int positive = channels.index("axis.B.positive.on");
  ASSERT_GE(positive, 0);
  const auto phase = [](const std::string& axis) {
    return "[[phase]]\nduration_h = 1\n" + (axis.empty() ? "" : "[[phase.axis]]\nid = \"B\"\n" + axis + "\n");
  };
  const std::string text =
      "schema = 1\n" + phase("") + phase("position_deg = 45") + phase("") + phase("position_deg = 45") +
      phase("position_deg = -10") + phase("clamped = true\nposition_deg = -10") +
      phase("low_deg = 0\nhigh_deg = 9\nfeed_deg_min = 60") + phase("") + phase("position_deg = 0");
  const LoadProgram program = LoadProgram::parse(text, "loads/sides.toml", machine);
  const double expected[] = {0.5, 1.0, 1.0, 1.0, 0.0, 0.0, 0.5, 0.5, 1.0};
  for (int i = 0; i < 9; ++i) EXPECT_EQ(program.row(3600.0 * i, 3600.0 * (i + 1))[positive], expected[i]) << i;

  const Layout layout = make_layout(machine, {{0, false, {-0.2, -0.1, 0.0, 0.1, 0.2}}, {-1, false, {0.0}}});
  const OperatingModel model(machine, layout);
  EXPECT_NEAR(model.source_powers(program.row(3600.0, 7200.0))[1], 1000.0 * std::pow(std::sqrt(0.5) + 0.1, 2), 1e-9);
  const double at = std::sin(pi / 18);
  EXPECT_NEAR(model.source_powers(program.row(14400.0, 18000.0))[1], 1000.0 * std::pow(at + 0.1, 2), 1e-9)
      << "on the other side of the balance, lifted";
}

}  // namespace
}  // namespace thermotwin::solver
