// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/daily_window.h"

#include <gtest/gtest.h>

#include "core/interpolation.h"

namespace {

using namespace thermotwin;
using diagnosis::DailyWindow;

TEST(DailyWindow, RisesAndFallsInStraightLinesEveryDay) {
  const DailyWindow afternoon{13.0, 17.0, 1.0};
  for (const double day : {-24.0, 0.0, 72.0}) {
    EXPECT_EQ(height(afternoon, day + 12.5), 0.0);
    EXPECT_NEAR(height(afternoon, day + 13.0), 0.5, 1e-12);
    EXPECT_NEAR(height(afternoon, day + 13.25), 0.75, 1e-12);
    EXPECT_EQ(height(afternoon, day + 15.0), 1.0);
    EXPECT_NEAR(height(afternoon, day + 17.5), 0.0, 1e-12);
  }
  EXPECT_EQ(in_words(afternoon), "from 13:00 to 17:00 every day");
}

TEST(DailyWindow, ANightShiftGoesOverMidnight) {
  const DailyWindow night{22.0, 30.0, 0.5};
  EXPECT_EQ(height(night, 23.9), 1.0);
  EXPECT_EQ(height(night, 0.0), 1.0);
  EXPECT_EQ(height(night, 5.0), 1.0);
  EXPECT_EQ(height(night, 7.0), 0.0);
  EXPECT_EQ(in_words(night), "from 22:00 to 06:00 every day");
}

TEST(DailyWindow, ItsTableIsTheSameCourse) {
  for (const DailyWindow& window :
       {DailyWindow{13.0, 17.0, 1.0}, {22.0, 30.0, 0.5}, {-1.0, 3.0, 2.0}, {6.0, 8.0, 2.0}}) {
    const mesh::PowerLaw law = law_of(window, 80.0);
    EXPECT_EQ(law.input, mesh::time_of_day);
    for (double hour = 0.0; hour < 24.0; hour += 0.125) {
      const double power = core::linear_at(law.at, law.power, mesh::at_input(mesh::TableInput::hour, hour + 48.0));
      EXPECT_NEAR(power, 80.0 * height(window, hour), 1e-4) << window.from_h << " " << hour;
    }
  }
}

}  // namespace
