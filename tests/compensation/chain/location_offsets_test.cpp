// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/chain/location_offsets.h"

#include <numbers>

#include "compensation/online/offset_guard.h"
#include "tests/compensation/records.h"
#include "tests/compensation/scratch.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Vector3d;
using test::expect_input_error;

constexpr double degree = std::numbers::pi / 180.0, um = 1e-6;

TEST(KinematicChain, IsReadAsIso10791WritesIt) {
  const KinematicChain chain = KinematicChain::parse("V [w C' B' b Y X Z (C1) t]", "test");
  ASSERT_EQ(chain.table.size(), 2U);
  EXPECT_EQ(chain.table[0].id, "B");  // from the bed outwards
  EXPECT_EQ(chain.table[1].id, "C");
  ASSERT_EQ(chain.tool.size(), 3U);
  EXPECT_EQ(chain.tool[2].id, "Z");
  EXPECT_EQ(chain.find("C1"), nullptr) << "a spindle positions nothing";
  EXPECT_EQ(chain.ids(), (std::vector<std::string>{"Y", "X", "Z", "C", "B"}));
  EXPECT_EQ(chain.find("B")->direction, -Vector3d::UnitY());
  const KinematicChain lying = KinematicChain::parse("H [w B' X' b Y Z (C) t]", "test");
  EXPECT_EQ(lying.find("X")->direction, -Vector3d::UnitX());
  EXPECT_EQ(lying.find("Y")->direction, Vector3d::UnitY());
}

TEST(KinematicChain, MistakesAreNamed) {
  const auto refused = [](const char* text, const char* word) {
    expect_input_error([&] { KinematicChain::parse(text, "place"); }, {"place", word});
  };
  refused("w C b X t", "without [ ]");
  refused("V [w C' b X Y Z]", "without t");
  refused("V [C' b X t]", "before w");
  refused("V [w b X X t]", "a second time");
  refused("V [w b Q t]", "'Q'");
  refused("V [w b X' t]", "tool's side");
  refused("Q [w b X t]", "'Q'");
  refused("V [w b X t Y]", "after t");
  refused("V [w b X12345 t]", "X12345");
}

/// The table of document 000: B turns the table's normal towards +X.
KinematicChain machine_bc() {
  KinematicChain chain = KinematicChain::parse("V [w C' B' b Y X Z (C1) t]", "test");
  chain.find("B")->direction = Vector3d::UnitY();
  chain.find("C")->direction = Vector3d::UnitZ();
  return chain;
}

double axis_offset(const LocationOffsets& map, const AxisOffsets& offsets, const std::string& id) {
  const auto at = std::find(map.axes().begin(), map.axes().end(), id);
  return offsets.offset[at - map.axes().begin()];
}

// (6.1) to (6.9), the offset being the negative of the print's shift of the coordinate system.
TEST(LocationOffsets, EquationsOfTheRotaryTable) {
  const LocationOffsets map(machine_bc(), {.orientation = false, .axes = {}, .table_radius = 0.2});
  for (const double b : {0.0, 30 * degree, -75 * degree, 90 * degree}) {
    const std::map<std::string, double> at{{"B", b}, {"C", 1.1}};
    const Vector3d in_table(0.11, -0.07, 0.16);  // of the table that B has turned
    const Vector3d point = Eigen::AngleAxisd(b, Vector3d::UnitY()) * in_table;
    const auto of = [&](const char* error, double value) {
      const AxisOffsets found = map.offsets({{error, value}}, at, point);
      EXPECT_LT(found.point_left.norm(), 1e-15) << "three linear axes cancel any point error";
      return Vector3d(axis_offset(map, found, "X"), axis_offset(map, found, "Y"), axis_offset(map, found, "Z"));
    };
    EXPECT_LT((of("Y0C", 29 * um) - Vector3d(0, 29 * um, 0)).norm(), 1e-15);  // (6.1)
    EXPECT_LT((of("Z0T", 23 * um) - Vector3d(23 * um * std::sin(b), 0, 23 * um * std::cos(b))).norm(),
              1e-15);  // (6.2) (6.3)
    const double growth = 12 * um / 0.2;
    EXPECT_LT((of("R0T", 12 * um) - growth * Vector3d(0.11 * std::cos(b), -0.07, -0.11 * std::sin(b))).norm(),
              1e-15);  // (6.4) to (6.6)
    EXPECT_LT((of("A0C", 23 * um) - 23 * um * Vector3d(-0.07 * std::sin(b), -0.16, -0.07 * std::cos(b))).norm(),
              1e-15);  // (6.7) to (6.9)
    // (6.10) to (6.12): superposition.
    const AxisOffsets all =
        map.offsets({{"Y0C", 29 * um}, {"Z0T", 23 * um}, {"R0T", 12 * um}, {"A0C", 23 * um}}, at, point);
    const Vector3d sum = of("Y0C", 29 * um) + of("Z0T", 23 * um) + of("R0T", 12 * um) + of("A0C", 23 * um);
    EXPECT_NEAR(axis_offset(map, all, "X"), sum.x(), 1e-15);
    EXPECT_NEAR(axis_offset(map, all, "Y"), sum.y(), 1e-15);
    EXPECT_NEAR(axis_offset(map, all, "Z"), sum.z(), 1e-15);
  }
}

TEST(LocationOffsets, WhatTheAxesCannotDoIsReported) {
  // A squareness error about X: no axis of B and C turns about X at B = 0; at B = 90 deg C does.
  const LocationOffsets map(machine_bc(), {.orientation = true, .axes = {}, .table_radius = 0.3});
  const Vector3d point(0.1, 0.2, 0.05);
  AxisOffsets found = map.offsets({{"A0C", 20 * um}}, {}, point);
  EXPECT_NEAR(std::abs(found.orientation_left.x()), 20 * um, 1e-15);
  EXPECT_LT(found.point_left.norm(), 1e-15);
  found = map.offsets({{"B0C", 20 * um}}, {}, point);
  EXPECT_LT(found.orientation_left.norm(), 1e-15);
  EXPECT_NEAR(std::abs(axis_offset(map, found, "B")), 20 * um, 1e-15);
  EXPECT_LT(found.point_left.norm(), 1e-15) << "linear axes take back what B did to the point";
  found = map.offsets({{"A0B", 20 * um}}, {{"B", 90 * degree}}, point);
  EXPECT_LT(found.orientation_left.norm(), 1e-12) << "C then turns about X";
  // With Y alone, what is across to it stays.
  const LocationOffsets only_y(machine_bc(), {.orientation = false, .axes = {"Y"}, .table_radius = 0.3});
  found = only_y.offsets({{"Y0C", 10 * um}, {"Z0T", 7 * um}}, {}, point);
  EXPECT_LT((found.point_left - Vector3d(0, 0, -7 * um)).norm(), 1e-15);
  expect_input_error([&] { map.offsets({{"Y0A", um}}, {}, point); }, {"Y0A", "Y0B"});
  expect_input_error([] { LocationOffsets(machine_bc(), {.orientation = false, .axes = {"W"}, .table_radius = 0.3}); },
                     {"'W'", "X"});
}

/// Any chain: the offsets, put into the axes, bring tool and workpiece together again. Both sides
/// are moved here as rigid bodies with finite motions, another way than the code's.
TEST(LocationOffsets, OffsetsBringToolAndWorkpieceTogetherOnAnyChain) {
  test::Uniform uniform(21);
  for (const char* text : {"V [w C' B' b Y X Z (C1) t]", "V [w C' A' X' b Y Z (C1) t]", "H [w B' X' b Z Y (C) t]",
                           "V [w Y' X' b Z C B (S) t]", "V [w C' X' b Y Z B (C1) t]"}) {
    KinematicChain chain = KinematicChain::parse(text, "test");
    std::map<std::string, double> at, errors;
    for (const std::string& id : chain.ids()) {
      at[id] = chain.find(id)->rotary ? 2.0 * uniform() - 1.0 : 0.4 * uniform();
      if (chain.find(id)->rotary) chain.find(id)->origin = 0.2 * Vector3d(uniform(), uniform(), uniform());
    }
    const LocationOffsets map(chain, {.orientation = false, .axes = {}, .table_radius = 0.3});
    for (const std::string& name : map.known_errors()) {
      if (name != "R0T" && name.substr(2) != "T") errors[name] = 2e-7 * (uniform() - 0.5);
    }
    const Vector3d point(0.3, -0.2, 0.25);
    const AxisOffsets found = map.offsets(errors, at, point);
    // Where point of the tool and of the workpiece go.
    const auto placed = [&](const std::vector<ChainAxis>& branch, bool moved) {
      std::map<std::string, double> positions = at;
      for (std::size_t i = 0; moved && i < map.axes().size(); ++i) positions[map.axes()[i]] += found.offset[i];
      Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
      for (std::size_t i = 0; i < branch.size(); ++i) {
        const ChainAxis& axis = branch[i];
        if (moved) {
          Vector3d shift, turn;
          for (int k = 0; k < 3; ++k) {
            shift[k] = errors.at(std::string(1, "XYZ"[k]) + "0" + axis.id);
            turn[k] = errors.at(std::string(1, "ABC"[k]) + "0" + axis.id);
          }
          transform.translate(shift).translate(axis.origin);
          if (turn.norm() > 0.0) transform.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
          transform.translate(-axis.origin);
        }
        transform = transform * KinematicChain::frame({axis}, 0, positions);
      }
      return transform;
    };
    const auto gone = [&](const std::vector<ChainAxis>& branch) {
      return Vector3d(placed(branch, true) * (placed(branch, false).inverse() * point) - point);
    };
    EXPECT_GT(found.point_error.norm(), 1e-8);
    EXPECT_LT((gone(chain.tool) - gone(chain.table) - found.point_left).norm(), 1e-12) << text;
    if (map.axes().size() == 3) {
      EXPECT_LT(found.point_left.norm(), 1e-14) << text;
    }
  }
}

TEST(OffsetGuard, NeverJumpsWhateverTheModelDoes) {
  const GuardOptions options{50.0, 0.5, 60.0};
  OffsetGuard guard(2, options);
  test::Uniform uniform(3);
  Eigen::Vector2d before = Eigen::Vector2d::Zero();
  double time = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double step = 0.1 + 2.0 * uniform();
    time += step;
    Eigen::Vector2d wanted(200.0 * (uniform() - 0.5), 30.0);
    if (i % 400 > 300) wanted[0] = std::nan("");
    const Eigen::VectorXd applied = guard.step(time, wanted);
    ASSERT_TRUE(applied.allFinite());
    ASSERT_LE((applied - before).cwiseAbs().maxCoeff(), i == 0 ? 0.0 : 0.5 * step + 1e-12) << i;
    ASSERT_LE(applied.cwiseAbs().maxCoeff(), 50.0);
    before = applied;
  }
}

TEST(OffsetGuard, FollowsHoldsAndReturns) {
  OffsetGuard guard(1, {100.0, 1.0, 60.0});
  const auto at = [&](double time, double wanted) { return guard.step(time, Eigen::VectorXd::Constant(1, wanted))[0]; };
  EXPECT_EQ(at(0, 20), 0.0);
  EXPECT_EQ(at(10, 20), 10.0);
  EXPECT_EQ(guard.state(), GuardState::limited);
  EXPECT_EQ(at(30, 20), 20.0);
  EXPECT_EQ(guard.state(), GuardState::following);
  EXPECT_EQ(at(60, std::nan("")), 20.0);
  EXPECT_EQ(guard.state(), GuardState::holding);
  EXPECT_EQ(at(95, std::nan("")), 0.0);
  EXPECT_EQ(guard.state(), GuardState::returning);
  EXPECT_EQ(at(96, 500), 1.0);
  EXPECT_EQ(at(400, 500), 100.0);
  EXPECT_EQ(guard.state(), GuardState::limited);
  EXPECT_EQ(guard.step(401, Eigen::VectorXd::Constant(1, 0.0), 9.0)[0], 90.0) << "a second and a motion";
  expect_input_error([] { OffsetGuard(1, {100.0, 0.0, 60.0}); }, {"rate_um_s"});
}

}  // namespace
}  // namespace thermotwin::compensation
