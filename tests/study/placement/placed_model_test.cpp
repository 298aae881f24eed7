// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/placement/placed_model.h"

#include <gtest/gtest.h>

#include "tests/machines/slide_machine.h"

namespace thermotwin::study {
namespace {

TEST(PlacedSensors, KeepTheOneThatAChillerFollowsWithAnIdOfItsOwn) {
  mesh::Machine machine = test::slide_machine();
  machine.sensors[0].id = machine.coolants[0].guide_sensor = "S2";
  machine.sensors[0].offset = 0.3;
  const std::vector<Place> places{{0, 5, {0.1, 0.2, 0.3}}, {1, 90, {0.3, 0.1, 0.16}}};
  const std::vector<mesh::SensorSpec> sensors = placed_sensors(machine, places);
  ASSERT_EQ(sensors.size(), 3U);
  EXPECT_EQ(sensors[0].id, "S1");
  EXPECT_EQ(sensors[1].id, "S3");
  EXPECT_EQ(sensors[1].body, "slide");
  EXPECT_EQ(sensors[1].point, places[1].point);
  EXPECT_EQ(sensors[2].id, "S2");
  EXPECT_EQ(sensors[2].offset, 0.3);

  solver::Case machine_case;
  machine_case.machine = machine;
  const solver::Case placed = placed_case(machine_case, sensors);
  EXPECT_EQ(placed.machine.sensors.size(), 3U);
  EXPECT_NE(placed.machine.hash, machine.hash);
  EXPECT_EQ(placed_case(machine_case, sensors).machine.hash, placed.machine.hash);
}

TEST(PlacedModel, ReadsThePlacesAndKeepsTheOtherRows) {
  reduction::ReducedModel model;
  model.machine = test::slide_machine();
  model.system.conduction.setIdentity(3, 3);
  model.system.sensors.resize(3, 3);  // two sensors and what chillers follow besides
  model.system.sensors << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  mesh::Machine placed = model.machine;
  placed.sensors = placed_sensors(model.machine, {{0, 5, {0.1, 0.1, 0.1}}});
  const reduction::ReducedModel made = placed_model(model, placed, Eigen::RowVector3d(10, 11, 12));
  Eigen::MatrixXd expected(3, 3);
  expected << 10, 11, 12, 1, 2, 3, 7, 8, 9;
  EXPECT_EQ(made.system.sensors, expected);
  EXPECT_EQ(made.machine.sensors.size(), 2U);
}

}  // namespace
}  // namespace thermotwin::study
