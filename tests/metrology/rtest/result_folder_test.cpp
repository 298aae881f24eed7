// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/result_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::metrology {
namespace {

using compensation::ChannelKind;
using compensation::Measurement;

RTestAnalysis two_cycles() {
  RTestAnalysis analysis;
  analysis.errors = {"X0C", "A0C", "Y0B"};
  analysis.units = {"um", "um/m", "um"};
  for (const double time : {100.0, 460.0}) {
    CycleResult cycle;
    cycle.time = time;
    cycle.value = Eigen::Vector3d(time * 1e-8, time * 2e-8, std::nan(""));
    cycle.std = Eigen::Vector3d(0.2e-6, 1e-6, std::nan(""));
    analysis.cycles.push_back(cycle);
  }
  return analysis;
}

RTestRecord record() {
  RTestRecord record;
  record.chain = mesh::KinematicChain::parse("V [w C' B' b Y X Z t]", "test");
  record.cycles.resize(1);
  record.cycles[0].points.resize(1);
  record.cycles[0].points[0].positions = {{"B", 90 * core::units::deg}, {"X", 0.1}};
  return record;
}

Measurement loads() {
  Measurement measurement;
  measurement.data.source = "loads/data.csv";
  measurement.data.columns = {"time_s", "n", "air"};
  measurement.data.values.resize(3, 3);
  measurement.data.values << 0, 3000, 20, 100, 0, 21, 600, 3000, 22;
  measurement.channels.resize(2);
  compensation::MeasuredChannel &speed = measurement.channels[0], &air = measurement.channels[1];
  speed.id = "n";
  speed.unit = "rpm";
  speed.kind = ChannelKind::speed;
  speed.input = "spindle.speed_rpm";
  speed.column = 1;
  air.id = "air";
  air.unit = "degC";
  air.kind = ChannelKind::temperature;
  air.uncertainty = 0.1;
  air.column = 2;
  return measurement;
}

TEST(ResultFolder, IsReadAsAMeasurementFolder) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "thermotwin_result_folder";
  std::filesystem::remove_all(folder);
  compensation::write_measurement(folder, measurement_of(record(), two_cycles(), loads()));
  const Measurement read = compensation::read_measurement(folder);
  std::filesystem::remove_all(folder);
  ASSERT_EQ(read.channels.size(), 4U) << "Y0B is not observable";
  EXPECT_EQ(read.channels[2].quantity, "X0C");
  EXPECT_EQ(read.channels[3].unit, "um/m");
  EXPECT_NEAR(read.channels[2].uncertainty, 0.2, 1e-9);
  EXPECT_EQ(read.channels[2].pose_text, "B=90,X=100");
  EXPECT_EQ(read.channels[2].zero, compensation::Zero::first);
  ASSERT_EQ(read.data.rows(), 4);
  const Eigen::VectorXd time = read.time();
  EXPECT_TRUE(time.isApprox(Eigen::Vector4d(0, 100, 460, 600)));
  EXPECT_TRUE(std::isnan(read.values(read.channels[2])[0]));
  EXPECT_NEAR(read.values(read.channels[2])[1], 1.0, 1e-9);
  EXPECT_EQ(read.values(read.channels[1])[1], 21.0) << "one row for a time that both have";
  EXPECT_TRUE(std::isnan(read.values(read.channels[0])[2]));
}

// The deviations at the points: a place that is measured again in a cycle counts once, a turn further is the same
// place.
TEST(ResultFolder, DeviationsAtThePointsAreChannels) {
  RTestRecord points = record();
  points.std = 0.4e-6;
  points.cycles.assign(2, {});
  for (int cycle = 0; cycle < 2; ++cycle) {
    for (int i = 0; i < 3; ++i) {
      RTestPoint point;
      point.time = 100.0 * cycle + 10.0 * i + (cycle == 1 ? 1e-7 : 0.0);
      point.positions = {{"C", 180.0 * i * core::units::deg}, {"X", 0.1}};
      point.deviation = Eigen::Vector3d(i + 1, 0, 10 * cycle) * 1e-6;
      points.cycles[cycle].points.push_back(point);
    }
  }
  const Measurement found = points_measurement_of(points, loads());
  ASSERT_EQ(found.channels.size(), 8U);
  EXPECT_EQ(found.channels[5].id, "dx@2");
  EXPECT_EQ(found.channels[5].pose_text, "C=180,X=100");
  EXPECT_NEAR(found.channels[5].uncertainty, 0.4, 1e-12);
  // Rows: loads at 0, 100, 600; points at 0, 10, 100 (within a millisecond), 110.
  ASSERT_EQ(found.data.rows(), 5);
  EXPECT_LT((found.time() - (Eigen::VectorXd(5) << 0, 10, 100, 110, 600).finished()).norm(), 1e-3) << found.time();
  EXPECT_NEAR(found.values(found.channels[5])[1], 2.0, 1e-12);
  EXPECT_NEAR(found.values(found.channels[4])[2], 10.0, 1e-12);
  EXPECT_EQ(found.values(found.channels[1])[2], 21.0);
  points.cycles[0].points.resize(most_places + 1, points.cycles[0].points[0]);
  EXPECT_THROW(points_measurement_of(points, loads()), core::InputError);
}

/// R-Test cycles at the angles of a table's axis, with deviations of no meaning.
RTestRecord turned(const std::vector<std::vector<double>>& angles_deg) {
  RTestRecord turned = record();
  turned.chain.find("C")->direction = Eigen::Vector3d::UnitZ();
  turned.std = 0.2e-6;
  turned.errors = {"X0C", "Y0C", "Z0T", "A0C", "B0C", "C0C", "R0T"};
  turned.cycles.clear();
  double value = 0.0;
  for (const std::vector<double>& angles : angles_deg) {
    turned.cycles.push_back({"cycle", {}});
    for (const double angle : angles) {
      const double at = angle * core::units::deg;
      RTestPoint point;
      point.time = 300.0 * static_cast<double>(turned.cycles.size()) +
                   5.0 * static_cast<double>(turned.cycles.back().points.size());
      point.nominal = Eigen::Vector3d(0.19 * std::cos(at), 0.19 * std::sin(at), 0.15);
      point.positions = {{"C", at}, {"X", point.nominal[0]}, {"Y", point.nominal[1]}};
      value += 1.0;
      point.deviation = 1e-6 * Eigen::Vector3d(std::sin(value), std::sin(3 * value), std::cos(2 * value));
      turned.cycles.back().points.push_back(point);
    }
  }
  return turned;
}

// The weights make of the deviations what the evaluation made of them, drift and all.
TEST(ResultFolder, WeightsMakeTheErrorsOfTheDeviations) {
  const RTestRecord test = turned({{0, 90, 180, 270, 360}, {360, 450, 540, 630, 720}, {720, 810, 900, 990, 1080}});
  const RTestAnalysis found = analyse(test);
  ASSERT_TRUE(found.cycles[0].drift_estimated);
  const Measurement folder = measurement_of(test, found, std::nullopt);
  ASSERT_EQ(folder.channels.size(), 7U);
  for (const compensation::MeasuredChannel& channel : folder.channels) {
    ASSERT_EQ(channel.points.size(), 5U);
    EXPECT_EQ(channel.arrangement, "rtest");
    EXPECT_EQ(channel.points[4].pose_text, "C=0,X=190,Y=0") << "within a turn";
    for (int cycle : {1, 2}) {
      double sum = 0.0;
      for (std::size_t i = 0; i < 5; ++i) {
        sum +=
            channel.points[i].weight.dot(test.cycles[cycle].points[i].deviation - test.cycles[0].points[i].deviation) /
            1e-6;
      }
      EXPECT_NEAR(folder.values(channel)[cycle], sum, 1e-9) << channel.id;
    }
  }
}

// A cycle without a point has other weights: its errors are blank, and with another test's points the ids differ.
TEST(ResultFolder, CyclesWithOtherPointsAreBlank) {
  const RTestRecord test = turned({{0, 90, 180, 270, 360}, {0, 90, 180, 360}, {0, 90, 180, 270, 360}});
  const Measurement folder = measurement_of(test, analyse(test), std::nullopt);
  const Eigen::VectorXd x = folder.values(folder.channels[0]);
  EXPECT_FALSE(std::isnan(x[0]) || std::isnan(x[2]));
  EXPECT_TRUE(std::isnan(x[1]));
  Measurement before = loads();
  before.channels[1].arrangement = "rtest";
  EXPECT_EQ(measurement_of(test, analyse(test), before).channels.back().arrangement, "rtest2");
  const RTestRecord none =
      turned({{0, 90, 180, 270, 360}, {0, 90, 180, 360}, {0, 45, 180, 270}, {0, 80, 180, 270}, {10, 90, 180, 200}});
  EXPECT_TRUE(common_points(none, analyse(none)).empty());
  EXPECT_TRUE(measurement_of(none, analyse(none), std::nullopt).channels[0].points.empty());
}

// A sweep of 721 points keeps 60 of them; a deviation that is smooth along the path gives the same errors.
TEST(ResultFolder, SweepsAreThinned) {
  std::vector<double> angles;
  for (int i = 0; i <= 720; ++i) angles.push_back(i <= 360 ? i : 720.0 - i);
  RTestRecord test = turned({angles, angles});
  const auto deviation = [](double angle) {
    return Eigen::Vector3d(3 * std::cos(angle) + std::sin(2 * angle), 5.0 + std::cos(2 * angle), 4 * std::sin(angle));
  };
  for (RTestPoint& point : test.cycles[1].points)
    point.deviation =
        test.cycles[0].points[&point - test.cycles[1].points.data()].deviation + 1e-6 * deviation(point.positions["C"]);
  const RTestAnalysis found = analyse(test);
  const Measurement folder = measurement_of(test, found, std::nullopt);
  for (const compensation::MeasuredChannel& channel : folder.channels) {
    ASSERT_EQ(channel.points.size(), 60U);
    double sum = 0.0;
    for (const compensation::PointShare& point : channel.points) {
      const double angle = std::stod(point.pose_text.substr(2)) * core::units::deg;
      sum += point.weight.dot(deviation(angle));
    }
    EXPECT_NEAR(folder.values(channel)[1], sum, 0.01 * std::abs(sum) + (channel.unit == "um" ? 0.02 : 0.1))
        << channel.id;
  }
}

TEST(ResultFolder, ChannelsOfBothAreRefused) {
  Measurement both = loads();
  both.channels[1].id = "X0C";
  EXPECT_THROW(measurement_of(record(), two_cycles(), both), core::InputError);
}

TEST(ResultFolder, TableHasValuesAndDeviations) {
  const core::Table table = error_table(two_cycles());
  EXPECT_EQ(table.columns,
            (std::vector<std::string>{"time_s", "X0C_um", "A0C_um_per_m", "std_X0C_um", "std_A0C_um_per_m"}));
  EXPECT_NEAR(table.values(1, 2), 9.2, 1e-9);
  EXPECT_NEAR(table.values(0, 3), 0.2, 1e-9);
}

TEST(ResultFolder, BothNeedOneClock) {
  Measurement both = loads();
  both.data.values.col(0).array() += 1e5;
  EXPECT_THROW(measurement_of(record(), two_cycles(), both), core::InputError);
  both.data.values.col(0).array() -= 1e5 - 200.0;
  testing::internal::CaptureStderr();
  measurement_of(record(), two_cycles(), both);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("1 of 2 rows of the test"), std::string::npos) << said;
}

}  // namespace
}  // namespace thermotwin::metrology
