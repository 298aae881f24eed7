// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/unit_hint.h"

#include <gtest/gtest.h>

#include <limits>

namespace thermotwin::compensation {
namespace {

using Eigen::VectorXd;

MeasuredChannel channel_of(ChannelKind kind, const std::string& unit, double uncertainty) {
  MeasuredChannel channel;
  channel.id = "c";
  channel.kind = kind;
  channel.unit = unit;
  channel.uncertainty = uncertainty;
  return channel;
}

/// A prediction of 20 um RMS, and a smaller course of its own that the machine adds.
struct Course {
  VectorXd predicted = VectorXd::LinSpaced(60, 0.0, 6.0).array().sin() * 28.0,
           more = VectorXd::LinSpaced(60, 0.0, 40.0).array().cos() * 4.0;
};

TEST(UnitHint, NamesTheUnitOrTheSignThatFits) {
  const Course course;
  const VectorXd right = 1.3 * course.predicted + course.more;
  const MeasuredChannel um = channel_of(ChannelKind::displacement, "um", 0.5),
                        angle = channel_of(ChannelKind::displacement, "um/m", 0.5);
  // A cause that makes a third more is no other unit, and the probe may begin anywhere.
  EXPECT_FALSE(unit_hint(um, right.array() + 500.0, course.predicted));
  struct Slip {
    const MeasuredChannel& channel;
    double factor;
    std::string words;
  };
  for (const Slip& slip :
       {Slip{um, -1.0, "its sign may be reversed"}, Slip{um, 1e-3, "its numbers may be mm"},
        Slip{um, -1e-3, "its numbers may be mm, and its sign may be reversed"}, Slip{um, 1e-6, "its numbers may be m"},
        Slip{um, 1e3, "its numbers may be nm"}, Slip{um, 1 / 25.4, "its numbers may be thousandths of an inch"},
        Slip{angle, 1e-3, "its numbers may be mrad"}, Slip{angle, 0.206265, "its numbers may be arc seconds"}}) {
    const auto hint = unit_hint(slip.channel, slip.factor * (right.array() + 500.0), course.predicted);
    ASSERT_TRUE(hint) << slip.words;
    EXPECT_EQ(hint->words, slip.words);
    EXPECT_NEAR(hint->factor, slip.factor, 1e-3 * std::abs(slip.factor));
    EXPECT_LT(hint->rms_changed, hint->rms_stated);
  }
}

TEST(UnitHint, IsSilentWithoutEvidence) {
  const Course course;
  const MeasuredChannel um = channel_of(ChannelKind::displacement, "um", 0.5);
  const VectorXd reversed = -course.predicted;
  ASSERT_TRUE(unit_hint(um, reversed, course.predicted));
  // Below three uncertainties, seven rows, no motion, no correlation.
  EXPECT_FALSE(unit_hint(channel_of(ChannelKind::displacement, "um", 8.0), reversed, course.predicted));
  VectorXd few = reversed;
  few.tail(53).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(unit_hint(um, few, course.predicted));
  EXPECT_FALSE(unit_hint(um, reversed, VectorXd::Constant(60, 3.0)));
  EXPECT_FALSE(unit_hint(um, reversed + 6.0 * course.more, course.predicted));
}

TEST(UnitHint, DegreesFahrenheitAreNamedWithTheirOffset) {
  const Course course;
  const MeasuredChannel sensor = channel_of(ChannelKind::temperature, "degC", 0.1);
  const VectorXd celsius = 24.0 + 0.1 * course.predicted.array(), warmer = celsius.array() + 1.0;
  EXPECT_FALSE(unit_hint(sensor, warmer, celsius));
  const auto hint = unit_hint(sensor, 1.8 * warmer.array() + 32.0, celsius);
  ASSERT_TRUE(hint);
  EXPECT_NEAR(hint->rms_changed, 1.0, 1e-9);
  const std::string words = in_words(*hint, sensor);
  EXPECT_NE(words.find("may be degrees Fahrenheit, although channels.toml states degC"), std::string::npos) << words;
}

}  // namespace
}  // namespace thermotwin::compensation
