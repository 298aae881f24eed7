// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/plot.h"

#include <gtest/gtest.h>

#include <limits>
#include <regex>
#include <set>

namespace thermotwin::core {
namespace {

using Eigen::Vector2d;
using Eigen::Vector4d;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

std::ptrdiff_t count(const std::string& text, const std::string& pattern) {
  const std::regex what(pattern);
  return std::distance(std::sregex_iterator(text.begin(), text.end(), what), std::sregex_iterator());
}

Axis axis(double low, double high, bool log = false) { return {"", log, low, high}; }

TEST(AxisTicks, AreRoundAndInside) {
  EXPECT_EQ(axis_ticks(0.0, 10.0, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(axis_ticks(-1.2, 1.3, 5), (std::vector<double>{-1.0, -0.5, 0.0, 0.5, 1.0}));
  EXPECT_EQ(axis_ticks(0.0, 86.0, 8).size(), 5U) << "0, 20 .. 80";
  EXPECT_EQ(axis_ticks(1e5, 1.7e5, 8).size(), 8U) << "steps of 10,000";
}

TEST(AxisTicks, NoneWithoutARange) {
  EXPECT_TRUE(axis_ticks(1.0, 1.0, 5).empty());
  EXPECT_TRUE(axis_ticks(2.0, 1.0, 5).empty());
  EXPECT_TRUE(axis_ticks(0.0, infinite, 5).empty());
  EXPECT_TRUE(axis_ticks(nan, 1.0, 5).empty());
}

TEST(Axis, HoldsWhatItShows) {
  Axis linear;
  linear.include(Vector4d(2.0, nan, -1.0, infinite));
  linear.close(0.1);
  EXPECT_DOUBLE_EQ(linear.low, -1.3);
  EXPECT_DOUBLE_EQ(linear.high, 2.3);
  EXPECT_DOUBLE_EQ(linear.share(0.5), 0.5);
  Axis logarithmic{"", true};
  logarithmic.include(Vector4d(0.02, 0.0, -1.0, 30.0));
  logarithmic.close();
  EXPECT_NEAR(logarithmic.low, 0.01, 1e-12);
  EXPECT_NEAR(logarithmic.high, 100.0, 1e-9);
  EXPECT_NEAR(logarithmic.share(1.0), 0.5, 1e-12);
}

TEST(Axis, HasAWidthOfOneValueAndOfNone) {
  for (const bool log : {false, true}) {
    Axis none{"", log}, one{"", log};
    none.close();
    one.include(10.0);
    one.close();
    EXPECT_LT(none.low, none.high);
    EXPECT_LT(one.low, 10.0);
    EXPECT_GT(one.high, 10.0);
  }
}

TEST(Axis, OfCountsHasWholeNumbersOnly) {
  for (const bool whole : {false, true}) {
    Axis counts{"sensors"}, up{"um"};
    counts.whole = whole;
    counts.include(Vector4d(1.0, 2.0, 3.0, 4.0));
    counts.close();
    up.include(Vector4d(0.0, 10.0, 20.0, 30.0));
    up.close();
    Plot plot(400, 300, "counts");
    Panel(plot, {40, 20, 320, 240}, counts, up).x_axis();
    EXPECT_EQ(count(plot.inset(), ">1.5<"), whole ? 0 : 1) << plot.inset();
    EXPECT_EQ(count(plot.inset(), whole ? ">2<" : ">2.0<"), 1) << plot.inset();
  }
}

TEST(Plot, NamesAreMadeHarmless) {
  Plot plot(10, 10, "a < b");
  plot.title(0, 0, "c & d");
  plot.text(0, 0, "<e>", Anchor::end);
  const std::string svg = plot.inset();
  EXPECT_EQ(count(svg, "a &lt; b"), 1);
  EXPECT_EQ(count(svg, "c &amp; d"), 1);
  EXPECT_EQ(count(svg, "text-anchor=\"end\">&lt;e&gt;<"), 1);
}

TEST(Plot, AFileHasItsStyleAndAPageGivesIt) {
  const Plot plot(10, 10, "");
  EXPECT_NE(plot.file().find(plot_style()), std::string::npos);
  EXPECT_EQ(count(plot.inset(), "<style>"), 0);
  std::set<std::string> colours;
  for (std::size_t i = 0; i < 8; ++i) {
    colours.insert(class_of(series_ink(i)));
    EXPECT_EQ(count(plot_style(), "\\." + class_of(series_ink(i)) + "\\{color:#"), 2) << "light and dark";
  }
  EXPECT_EQ(colours.size(), 8U);
  EXPECT_EQ(series_ink(8), series_ink(0));
}

TEST(Plot, EntriesOfALegendFollowEachOther) {
  Plot plot(10, 10, "");
  const double second = plot.key(5, 5, "first", Ink::green);
  EXPECT_GT(second, 5 + 26 + 20);
  EXPECT_EQ(count(plot.inset(), "class=\"key green\" d=\"M5.0 5.0h20\""), 1);
}

TEST(Panel, AxesHaveRoundNumbers) {
  Plot plot(200, 200, "");
  Panel panel(plot, {50, 0, 100, 100}, {"hours", false, 0.0, 8.0}, {"um", false, -0.5, 0.5});
  panel.x_axis();
  panel.y_axis();
  const std::string svg = plot.inset();
  for (const char* text : {">0<", ">8<", ">hours<", ">um<", ">\u22120.2<", ">0.4<"})
    EXPECT_NE(svg.find(text), std::string::npos) << text << "\n" << svg;
  EXPECT_EQ(count(svg, "class=\"grid zero\" d=\"M50.0 50.0H150.0\""), 1);
}

// A record that is probed now and then has no two values beside each other.
TEST(Panel, ALineShowsValuesThatStandAlone) {
  constexpr Eigen::Index rows = 5000;
  Eigen::VectorXd at(rows), values = Eigen::VectorXd::Constant(rows, nan);
  for (Eigen::Index i = 0; i < rows; ++i) at[i] = i;
  for (const Eigen::Index i : {33, 1234, 4001}) values[i] = 1.0;
  Plot plot(200, 200, "");
  Panel panel(plot, {50, 0, 100, 100}, axis(0, rows), axis(0, 2));
  panel.line(at, values, Ink::blue);
  EXPECT_EQ(count(plot.inset(), "h4"), 3) << plot.inset();
  values.segment(2000, 200).setConstant(1.5);
  Plot more(200, 200, "");
  Panel(more, {50, 0, 100, 100}, axis(0, rows), axis(0, 2)).line(at, values, Ink::blue);
  EXPECT_EQ(count(more.inset(), "h4"), 3) << more.inset();
  EXPECT_EQ(count(more.inset(), "<path class=\"line"), 1) << more.inset();
}

TEST(Panel, ALogarithmicAxisHasPowersOfTen) {
  Plot plot(200, 200, "");
  Panel panel(plot, {50, 0, 100, 100}, axis(0, 1), axis(0.01, 10, true));
  panel.y_axis();
  for (const char* text : {">0.01<", ">0.1<", ">1<", ">10<"})
    EXPECT_NE(plot.inset().find(text), std::string::npos) << text;
  EXPECT_EQ(count(plot.inset(), "<text"), 4);
}

TEST(Panel, LinesBreakAtGapsAndStayInside) {
  Plot plot(100, 100, "");
  Panel panel(plot, {0, 0, 100, 100}, axis(0, 3), axis(0, 10));
  panel.line(Vector4d(0, 1, 2, 3), Vector4d(0, nan, 5, 99), Ink::blue);
  EXPECT_EQ(count(plot.inset(), "class=\"line blue\" d=\"M0.0 100.0M66.7 50.0L100.0 0.0\""), 1) << plot.inset();
}

TEST(Panel, DotsAreThoseThatTheAxesShow) {
  Plot plot(100, 100, "");
  Panel panel(plot, {0, 0, 100, 100}, axis(0, 3), axis(1, 10, true));
  panel.dots(Vector4d(0, 1, 2, 3), Vector4d(1, nan, 0, 10), Ink::pink);
  EXPECT_EQ(count(plot.inset(), "<circle class=\"area pink\""), 2);
}

TEST(Panel, LongSeriesHaveNoMorePointsThanPixels) {
  Plot plot(100, 100, "");
  Panel panel(plot, {0, 0, 100, 100}, axis(0, 1), axis(0, 1));
  panel.line(Eigen::VectorXd::LinSpaced(10000, 0, 1), Eigen::VectorXd::Zero(10000), Ink::blue);
  EXPECT_EQ(count(plot.inset(), "L"), 99);
}

TEST(Panel, BandsShadesAndBoxesCoverWhatTheyName) {
  Plot plot(100, 100, "");
  Panel panel(plot, {0, 0, 100, 100}, axis(0, 10), axis(10, 0));
  panel.band(Vector2d(0, 10), Vector2d(8, 6), Vector2d(2, 4));
  panel.shade(8, 12);
  panel.shade(11, 12);
  panel.box(5, 2, 1, 3, Ink::teal, 0.25);
  const std::string svg = plot.inset();
  EXPECT_EQ(count(svg, "class=\"area band\" d=\"M0.0 20.0L100.0 40.0L100.0 60.0L0.0 80.0Z\""), 1) << svg;
  EXPECT_EQ(count(svg, "class=\"area shade\""), 1) << "the second lies outside";
  EXPECT_EQ(count(svg, "class=\"area shade\" x=\"80.0\" y=\"0.0\" width=\"20.0\" height=\"100.0\""), 1) << svg;
  EXPECT_EQ(count(svg,
                  "class=\"area teal\" x=\"20.0\" y=\"10.0\" width=\"30.00\" height=\"20.00\" "
                  "fill-opacity=\"0.25\""),
            1)
      << svg;
}

TEST(Panel, LevelsAndMarksCrossIt) {
  Plot plot(100, 100, "");
  Panel panel(plot, {0, 0, 100, 100}, axis(0, 10), axis(0, 10));
  panel.level(3, "limit");
  panel.level(nan, "none");
  panel.mark(4);
  panel.mark(nan);
  panel.stroke(0, 0, 10, 10, Ink::olive);
  const std::string svg = plot.inset();
  EXPECT_EQ(count(svg, "d=\"M0.0 70.0H100.0\""), 1) << svg;
  EXPECT_EQ(count(svg, ">limit<"), 1);
  EXPECT_EQ(count(svg, "d=\"M40.0 0.0V100.0\""), 1) << svg;
  EXPECT_EQ(count(svg, "class=\"line olive\" d=\"M0.0 100.0L100.0 0.0\""), 1) << svg;
  EXPECT_EQ(count(svg, "dashed|none|nan"), 2) << svg;
}

}  // namespace
}  // namespace thermotwin::core
