// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/line_chart.h"

#include <gtest/gtest.h>

#include <limits>
#include <regex>

namespace thermotwin::core {
namespace {

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(LineChart, DrawsEveryPointAndBreaksAtGaps) {
  LineChart chart;
  chart.title = "a < b";
  chart.lines = {{"one", {{0, 1}, {1, 10}, {2, std::numeric_limits<double>::quiet_NaN()}, {3, 100}}},
                 {"two", {{0, 2}, {3, 0}}}};
  chart.log_y = true;
  const std::string svg = chart.svg();
  EXPECT_EQ(count(svg, "<circle"), 4u) << "neither the gap nor the 0 of a logarithmic axis";
  EXPECT_NE(svg.find("a &lt; b"), std::string::npos);
  EXPECT_EQ(count(svg, "nan"), 0u);
  const std::regex two_strokes("class=\"line \\w+\" d=\"M[^\"]*M[^\"]*\"");
  EXPECT_TRUE(std::regex_search(svg, two_strokes));
  for (const char* name : {">one<", ">two<"}) EXPECT_EQ(count(svg, name), 1u) << name;
}

TEST(LineChart, LargerValuesAreHigherUp) {
  LineChart chart;
  chart.lines = {{"one", {{0, 1}, {1, 5}}}};
  std::smatch match;
  const std::string svg = chart.svg();
  ASSERT_TRUE(
      std::regex_search(svg, match, std::regex("class=\"line \\w+\" d=\"M([0-9.]+) ([0-9.]+)L([0-9.]+) ([0-9.]+)\"")));
  EXPECT_LT(std::stod(match[1]), std::stod(match[3]));
  EXPECT_GT(std::stod(match[2]), std::stod(match[4]));
}

TEST(LineChart, TheTargetIsInThePicture) {
  LineChart chart;
  chart.lines = {{"one", {{0, 1}, {1, 5}}}};
  EXPECT_EQ(count(chart.svg(), "line dashed"), 0u);
  chart.target = 50.0;
  chart.target_name = "tolerance";
  const std::string svg = chart.svg();
  EXPECT_EQ(count(svg, "line dashed"), 1u);
  EXPECT_EQ(count(svg, ">tolerance<"), 1u);
  EXPECT_EQ(count(svg, ">50<"), 1u) << "the axis reaches it";
}

TEST(LineChart, WithoutPointsIsStillAChart) {
  const std::string svg = LineChart().svg();
  EXPECT_EQ(count(svg, "nan") + count(svg, " inf"), 0u);
  EXPECT_EQ(count(svg, "</svg>"), 1u);
}

}  // namespace
}  // namespace thermotwin::core
