// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/iso230/thermal_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/error.h"

namespace thermotwin::metrology {
namespace {

using compensation::ChannelKind;
using compensation::Measurement;
using Eigen::Index;

compensation::MeasuredChannel channel(const std::string& id, const std::string& unit, ChannelKind kind,
                                      double uncertainty) {
  compensation::MeasuredChannel made;
  made.id = id;
  made.unit = unit;
  made.kind = kind;
  made.uncertainty = uncertainty;
  return made;
}

/// An ETVE test of a day: Z follows the air with -1.8 um/K, A with 9 um/m per K, and Z has a rise of its own in the
/// first hour.
Measurement etve() {
  Measurement measurement;
  measurement.folder = "etve";
  measurement.data.source = "etve/data.csv";
  measurement.data.columns = {"time_s", "air", "Z", "A"};
  const Index n = 24 * 12 + 1;
  measurement.data.values.resize(n, 4);
  for (Index i = 0; i < n; ++i) {
    const double time = 300.0 * i, air = 21.0 + 2.75 * std::sin(2.0 * 3.14159265358979 * time / 86400.0);
    measurement.data.values.row(i) << time, air, -1.8 * (air - 21.0), 9.0 * (air - 21.0);
  }
  measurement.data.values(5, 2) = std::nan("");
  measurement.channels.push_back(channel("air", "degC", ChannelKind::temperature, 0.1));
  measurement.channels.push_back(channel("Z", "um", ChannelKind::displacement, 0.2));
  measurement.channels.push_back(channel("A", "um/m", ChannelKind::displacement, 0.5));
  for (Index i = 0; i < 3; ++i) measurement.channels[i].column = i + 1;
  return measurement;
}

TEST(ThermalTable, RangesAndGradients) {
  const ThermalTable table = thermal_table(etve(), "air");
  EXPECT_DOUBLE_EQ(table.duration, 86400.0);
  EXPECT_NEAR(table.ambient_range, 5.5, 1e-3);
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[0].count, 288);
  EXPECT_NEAR(table.rows[0].whole, 1.8 * 5.5, 1e-3);
  EXPECT_NEAR(table.rows[0].first_hour, 1.8 * 2.75 * std::sin(2.0 * 3.14159265358979 / 24.0), 1e-9);
  EXPECT_NEAR(table.rows[0].gradient, -1.8, 1e-9);
  EXPECT_NEAR(table.rows[1].gradient, 9.0, 1e-9);
  EXPECT_NEAR(table.rows[0].motion_std, 0.2828, 1e-4);
  EXPECT_NEAR(table.rows[0].last_std, 0.2828, 1e-4);
  EXPECT_NEAR(table.rows[0].gradient_std, 0.2 / (2.75 / std::sqrt(2.0) * std::sqrt(288.0)), 2e-4);
  EXPECT_TRUE(std::isnan(thermal_table(etve(), "").rows[0].gradient));
}

// The first hour is that of the test, whenever a channel begins; a shorter record has none.
TEST(ThermalTable, TheFirstHourIsThatOfTheTest) {
  Measurement measurement = etve();
  measurement.data.values.col(2).head(7).setConstant(std::nan(""));
  EXPECT_NEAR(thermal_table(measurement, "").rows[0].first_hour,
              measurement.data.values(7, 2) - measurement.data.values(12, 2), 1e-9);
  measurement.data.values.col(2).head(20).setConstant(std::nan(""));
  EXPECT_TRUE(std::isnan(thermal_table(measurement, "").rows[0].first_hour));
  measurement = etve();
  measurement.data.values.conservativeResize(7, Eigen::NoChange);
  const ThermalTable brief = thermal_table(measurement, "");
  EXPECT_FALSE(brief.has_an_hour());
  EXPECT_TRUE(std::isnan(brief.rows[0].first_hour));
  EXPECT_TRUE(std::isfinite(brief.rows[0].whole));
}

TEST(ThermalTable, AnAmbientGoesByItsNameToo) {
  Measurement measurement = etve();
  measurement.channels[0].id = "air.T_C";
  EXPECT_NEAR(thermal_table(measurement, "air").rows[0].gradient, -1.8, 1e-9);
  measurement.channels[0].id = "T7";
  measurement.channels[0].input = "air.T_C";
  EXPECT_NEAR(thermal_table(measurement, "air").rows[0].gradient, -1.8, 1e-9);
}

TEST(ThermalTable, SlipsAreNamed) {
  const auto refused = [](const Measurement& measurement, const std::string& ambient, const std::string& word) {
    try {
      thermal_table(measurement, ambient);
      ADD_FAILURE() << "accepted: " << word;
    } catch (const core::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  refused(etve(), "ait", "nearest: air");
  Measurement measurement = etve();
  measurement.data.values.col(1).setConstant(20.0);
  refused(measurement, "air", "does not change");
  measurement = etve();
  measurement.data.values.col(3).setConstant(std::nan(""));
  refused(measurement, "air", "0 values");
  measurement = etve();
  measurement.channels.resize(1);
  refused(measurement, "air", "no displacement");
}

/// A record of 97 rows, 5 min apart: noise of 0.3 um on x um over 8 h, the air with noise of 0.05 K on its own course.
Measurement noisy(std::uint64_t seed, double motion_um, double air_K, double per_K) {
  Measurement measurement = etve();
  measurement.data.values.conservativeResize(97, 4);
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  for (Index i = 0; i < 97; ++i) {
    const double course = std::sin(2.0 * 3.14159265358979 * i / 96.0), air = air_K * course;
    measurement.data.values.row(i) << 300.0 * i, 20.0 + air + 0.05 * normal(engine),
        0.5 * motion_um * course + per_K * air + 0.3 * normal(engine), 0.3 * normal(engine);
  }
  measurement.channels[0].uncertainty = 0.05;
  measurement.channels[1].uncertainty = measurement.channels[2].uncertainty = 0.3;
  return measurement;
}

// Extremes of 97 noisy values lie 1.5 um apart without motion: the range without noise covers it, with motion too.
TEST(ThermalTable, ARangeWithoutNoiseCoversTheMotion) {
  for (const double motion : {0.0, 2.0, 10.0}) {
    int inside = 0, hour = 0;
    double mean = 0.0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
      const ThermalRow row = thermal_table(noisy(seed, motion, 0.0, 0.0), "").rows[0];
      inside += std::abs(row.motion - motion) <= 2.0 * row.motion_std ? 1 : 0;
      const double in_hour = 0.5 * motion * std::sin(2.0 * 3.14159265358979 * 12.0 / 96.0);
      hour += std::abs(row.first_hour_motion - in_hour) <= 2.0 * row.first_hour_std ? 1 : 0;
      mean += row.motion / 200.0;
      EXPECT_GT(row.whole, row.motion);
    }
    EXPECT_GE(inside, 180) << motion;
    EXPECT_GE(hour, 180) << motion;
    EXPECT_NEAR(mean, motion, 0.2);
  }
}

// The scatter of the temperature flattens the line of least squares; the gradient is that of the course.
TEST(ThermalTable, ScatterOfTheTemperatureFlattensNoGradient) {
  int inside = 0;
  double mean = 0.0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const ThermalRow row = thermal_table(noisy(seed, 0.0, 0.1, 20.0), "air").rows[0];
    EXPECT_LT(row.reliability, 0.9);
    inside += std::abs(row.gradient - 20.0) <= 2.0 * row.gradient_std ? 1 : 0;
    mean += row.gradient / 200.0;
  }
  EXPECT_NEAR(mean, 20.0, 0.5);
  EXPECT_GE(inside, 180);
  EXPECT_TRUE(std::isnan(thermal_table(noisy(1, 1.0, 0.0, 0.0), "air").rows[0].gradient));
}

// Eight rows between two readings of the air share their scatter: they tell no more than the readings do.
TEST(ThermalTable, RowsBetweenTwoReadingsOfTheTemperatureScatterTogether) {
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Measurement measurement = noisy(seed, 0.0, 0.3, 20.0);
    for (Index i = 0; i < 97; ++i)
      if (i % 8 != 0) measurement.data.values(i, 1) = std::nan("");
    const ThermalRow row = thermal_table(measurement, "air").rows[0];
    inside += std::abs(row.gradient - 20.0) <= 2.0 * row.gradient_std ? 1 : 0;
  }
  EXPECT_GE(inside, 180);
}

TEST(ThermalTable, OneValueHasNoRange) {
  Measurement measurement = etve();
  measurement.data.values.col(2).segment(1, 12).setConstant(std::nan(""));
  EXPECT_TRUE(std::isnan(thermal_table(measurement, "").rows[0].first_hour));
  EXPECT_FALSE(std::isnan(thermal_table(measurement, "").rows[1].first_hour));
}

// A loader's rows lie between those of the probes, at other times.
TEST(ThermalTable, BlankCellsChangeNoFigure) {
  const Measurement alone = etve();
  Measurement merged = alone;
  const Index n = alone.data.rows();
  merged.data.values.resize(2 * n, 4);
  for (Index i = 0; i < n; ++i) {
    const double nan = std::nan(""), time = alone.data.values(i, 0);
    const double later = 21.0 + 2.75 * std::sin(2.0 * 3.14159265358979 * (time + 100.0) / 86400.0);
    merged.data.values.row(2 * i) << time, nan, alone.data.values(i, 2), alone.data.values(i, 3);
    merged.data.values.row(2 * i + 1) << time + 100.0, later, nan, nan;
  }
  const ThermalRow one = thermal_table(alone, "air").rows[0], both = thermal_table(merged, "air").rows[0];
  EXPECT_NEAR(both.motion, one.motion, 1e-9);
  EXPECT_NEAR(both.motion_std, one.motion_std, 1e-9);
  EXPECT_NEAR(both.gradient, one.gradient, 0.01);
  EXPECT_NEAR(both.gradient_std, one.gradient_std, 0.1 * one.gradient_std);
}

}  // namespace
}  // namespace thermotwin::metrology
