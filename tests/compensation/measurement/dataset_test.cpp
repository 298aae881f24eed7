// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/dataset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace thermotwin::compensation {
namespace {

/// A logger has a temperature each minute, a probe a displacement 20 s after each fifth of them.
Measurement two_loggers(Eigen::Index lost) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Measurement measurement;
  measurement.data.columns = {"time_s", "T1", "dz"};
  measurement.data.values.resize(72, 3);
  Eigen::Index row = 0;
  for (int minute = 0; minute < 60; ++minute) {
    measurement.data.values.row(row++) << 60.0 * minute, minute == lost ? nan : 20.0 + 0.1 * minute, nan;
    if (minute % 5 == 0) measurement.data.values.row(row++) << 60.0 * minute + 20.0, nan, 1.0 * minute;
  }
  measurement.channels.resize(2);
  measurement.channels[0].id = "T1";
  measurement.channels[0].kind = ChannelKind::temperature;
  measurement.channels[0].column = 1;
  measurement.channels[1].id = "dz";
  measurement.channels[1].kind = ChannelKind::displacement;
  measurement.channels[1].column = 2;
  return measurement;
}

TEST(Dataset, ReadingsStandUntilTheNextIsDueAtRowsOfOthers) {
  const Dataset data = make_dataset(two_loggers(-1));
  ASSERT_EQ(data.rows(), 72);
  for (Eigen::Index i = 0; i < data.rows(); ++i) EXPECT_TRUE(std::isfinite(data.input_values(i, 0))) << i;
  EXPECT_DOUBLE_EQ(data.input_values(1, 0), 20.0);
}

TEST(Dataset, ALostReadingIsMissing) {
  const Dataset data = make_dataset(two_loggers(10));
  // Minutes 0 to 9 have two rows of the probe among them.
  EXPECT_TRUE(std::isfinite(data.input_values(11, 0)));
  EXPECT_TRUE(std::isnan(data.input_values(12, 0))) << data.time[12];
  EXPECT_TRUE(std::isnan(data.input_values(13, 0))) << data.time[13];
  EXPECT_TRUE(std::isfinite(data.input_values(14, 0)));
}

}  // namespace
}  // namespace thermotwin::compensation
