// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/probe/raw_signals.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::metrology {
namespace {

using core::units::um;

/// Two points of 3 s at 10 Hz; outside of the middle second the readings are wrong.
RawSignals signals() {
  RawSignals made;
  made.raw = core::parse_csv("time_s,point,P1_um,P2_um,P3_um\n0,1,0,0,0\n", "raw.csv");
  made.raw.values.resize(62, 5);
  for (int i = 0; i < 62; ++i) {
    const bool second = i > 30;
    const double time = second ? 10.0 + 0.1 * (i - 31) : 0.1 * i, within = second ? time - 10.0 : time;
    const double value = within > 0.95 && within < 2.05 ? (second ? 20.0 : 10.0) : 500.0;
    made.raw.values.row(i) << time, second ? 2 : 1, value, -value, 0.0;
  }
  made.calibration = core::parse_csv(
      "x_mm,y_mm,z_mm,P1_um,P2_um,P3_um\n-2,0,0,-2000,0,0\n2,0,0,2000,0,0\n0,-2,0,0,-2000,0\n0,2,0,0,2000,0\n"
      "0,0,-2,0,0,-2000\n0,0,2,0,0,2000\n",
      "calibration.csv");
  return made;
}

std::string refused(const RawSignals& made, Eigen::Index points = 2) {
  try {
    sphere_displacements(made, ProbeSetup(), points);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RawSignals, TheMiddleOfARecordCounts) {
  const auto found = sphere_displacements(signals(), ProbeSetup(), 2);
  EXPECT_LT((found[0] - Eigen::Vector3d(10, -10, 0) * um).norm(), 1e-12);
  EXPECT_LT((found[1] - Eigen::Vector3d(20, -20, 0) * um).norm(), 1e-12);
}

TEST(RawSignals, SlipsHaveAPlace) {
  EXPECT_NE(refused(signals(), 3).find("no sample of point 3"), std::string::npos);
  EXPECT_NE(refused(signals(), 1).find("raw.csv:33 point: 2; allowed: a row of points.csv, 1 to 1"), std::string::npos)
      << refused(signals(), 1);
  RawSignals back = signals();
  back.raw.values(5, 0) = 0.2;
  EXPECT_NE(refused(back).find("raw.csv:7"), std::string::npos) << refused(back);
  RawSignals gap = signals();
  gap.raw.values(15, 3) = std::nan("");
  EXPECT_NE(refused(gap).find("raw.csv:17 P2_um: a missing reading"), std::string::npos) << refused(gap);
  RawSignals probe = signals();
  probe.raw.columns[4] = "P4_um";
  EXPECT_NE(refused(probe).find("no column P3_um"), std::string::npos);
  RawSignals brief = signals();
  brief.raw.values.col(0) *= 0.1;
  EXPECT_NE(refused(brief).find("more than twice cut_s = 1 s"), std::string::npos) << refused(brief);
}

}  // namespace
}  // namespace thermotwin::metrology
