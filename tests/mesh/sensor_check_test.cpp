// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/sensor_check.h"

#include <gtest/gtest.h>

#include "samples.h"

using namespace thermotwin;

namespace {

/// A box of 400 x 200 x 100 mm.
mesh::TetMesh box_mesh() {
  mesh::TetMesh box = samples::box_mesh({0.4, 0.2, 0.1}, 3);
  mesh::build_boundary(box, "box");
  return box;
}

/// A machine of that box, with elements of 20 mm.
mesh::Machine box_machine() {
  mesh::Machine machine;
  machine.path = "m/machine.toml";
  machine.bodies.resize(1);
  machine.bodies[0].id = "box";
  machine.bodies[0].element_size = 0.02;
  return machine;
}

/// Message for a sensor at a point (m) of the box.
std::string refused(const Eigen::Vector3d& point) {
  mesh::Machine machine = box_machine();
  machine.sensors.resize(1);
  machine.sensors[0].id = "T1";
  machine.sensors[0].body = "box";
  machine.sensors[0].point = point;
  return samples::message_of([&] { mesh::check_sensors(machine, {box_mesh()}); });
}

TEST(SensorCheck, InOnAndBesideTheBodyIsFine) {
  EXPECT_EQ(refused({0.2, 0.1, 0.05}), "") << "deep inside, further from the surface than an element";
  EXPECT_EQ(refused({0.4, 0.2, 0.1}), "");
  EXPECT_EQ(refused({0.2, 0.1, 0.119}), "");
}

TEST(SensorCheck, FarOffIsRefusedWithItsDistance) {
  const std::string message = refused({0.2, 0.1, 0.15});
  for (const char* words :
       {"machine.toml", "'T1'", "[200, 100, 150]", "50 mm outside body 'box'", "element_size_mm = 20"})
    EXPECT_NE(message.find(words), std::string::npos) << words << " in: " << message;
  EXPECT_NE(refused({0.43, 0.21, 0.05}).find("31.6 mm"), std::string::npos) << "sqrt(30^2 + 10^2) beside an edge";
}

/// What is said of a scale on the box whose tape and head lie at a height (m).
std::string warned(double height) {
  mesh::Machine machine = box_machine();
  mesh::ScaleSpec scale;
  scale.axis = "Y";
  scale.carrier = scale.head_body = "box";
  scale.start = {0.1, 0.0, 0.1};
  scale.end = scale.fixed_at = {0.3, 0.0, 0.1};
  scale.head = {0.2, 0.0, height};
  machine.scales = {scale};
  testing::internal::CaptureStderr();
  mesh::check_scales(machine, {box_mesh()});
  return testing::internal::GetCapturedStderr();
}

TEST(SensorCheck, AScaleInTheAirIsWarnedOf) {
  EXPECT_EQ(warned(0.05), "");
  EXPECT_EQ(warned(0.13), "") << "a scale may stand off its body";
  EXPECT_EQ(
      warned(0.4),
      "warning: m/machine.toml scale of axis 'Y' head_mm: [200, 0, 400] is 300 mm from body 'box', to which it is "
      "fixed\n");
}

}  // namespace
