// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/probe/calibration_check.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::metrology {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Readings of the default probes along three axes. @param mm  factor of the displacements @param um  of the readings
core::Table calibration(double mm, double um, double one = 0.0) {
  core::Table table = core::parse_csv("x_mm,y_mm,z_mm,P1_um,P2_um,P3_um\n0,0,0,0,0,0\n", "calibration.csv");
  table.values.resize(7, 6);
  for (Index i = 0; i < 7; ++i) {
    Vector3d moved = Vector3d::Zero();
    if (i > 0) moved[(i - 1) / 2] = i % 2 == 1 ? -2.0 : 2.0;
    const Vector3d zero(12, -7, 30);
    table.values.row(i) << mm * moved.transpose(), (um * (1e3 * tripod().transpose() * moved + zero)).transpose();
  }
  table.values(1, 3) += one;
  return table;
}

CalibrationCheck checked(const core::Table& table, const ProbeSetup& setup = ProbeSetup()) {
  return check_calibration(Calibration::fit(table, 0.0), setup, "calibration.csv");
}

std::string refused(const core::Table& table, const ProbeSetup& setup = ProbeSetup()) {
  try {
    checked(table, setup);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CalibrationCheck, SlipsAreRefused) {
  ProbeSetup stated;
  stated.directions_stated = stated.calibration_stated = true;
  for (const ProbeSetup& setup : {ProbeSetup(), stated}) {
    const CalibrationCheck good = checked(calibration(1, 1), setup);
    EXPECT_NEAR(good.least_gain, 1.0, 1e-9);
    EXPECT_LT(good.misfit, 1e-9);
    EXPECT_EQ(good.doubt, "");
    EXPECT_NE(refused(calibration(1, -1), setup), "") << "signs reversed";
    EXPECT_NE(refused(calibration(1e3, 1), setup).find("reads 0.001 um per um"), std::string::npos);
    EXPECT_NE(refused(calibration(1, 1e-3), setup).find("reads 0.001 um per um"), std::string::npos);
  }
  EXPECT_NE(refused(calibration(1, -1), stated).find("its sign is reversed"), std::string::npos);
  stated.calibration = 0.5e-3;
  EXPECT_NE(refused(calibration(1, 1), stated).find("calibration_mm = 0.5"), std::string::npos);
  stated.calibration = 2e-3;
  stated.directions = Eigen::Matrix3Xd(tripod().rowwise().reverse());  // columns in another order
  EXPECT_EQ(refused(calibration(1, 1), stated), "");
}

TEST(CalibrationCheck, AMisfitIsStated) {
  const CalibrationCheck bad = checked(calibration(1, 1, 100.0));
  EXPECT_GT(bad.misfit, 10e-6);
  EXPECT_NE(bad.doubt.find("misses its own displacements by"), std::string::npos) << bad.doubt;
  EXPECT_NE(refused(calibration(1, 1, 2500.0)).find("readings that miss the displacements"), std::string::npos);
}

TEST(CalibrationCheck, ReadingsInMmAreNamed) {
  const Calibration fit = Calibration::fit(calibration(1, 1), 0.0);
  CalibrationCheck check = checked(calibration(1, 1));
  check.see(Vector3d(11e-6, -8e-6, 33e-6), "raw.csv", fit);
  EXPECT_EQ(check.doubt, "");
  check.see(Vector3d(12e-9, -7e-9, 30e-9), "raw.csv", fit);
  EXPECT_NE(check.doubt.find("raw.csv"), std::string::npos);
}

}  // namespace
}  // namespace thermotwin::metrology
