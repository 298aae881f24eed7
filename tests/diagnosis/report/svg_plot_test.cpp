// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/svg_plot.h"

#include <gtest/gtest.h>

#include <limits>
#include <regex>

namespace thermotwin::diagnosis {
namespace {

using Eigen::Vector3d;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::ptrdiff_t count(const std::string& text, const std::string& pattern) {
  const std::regex what(pattern);
  return std::distance(std::sregex_iterator(text.begin(), text.end(), what), std::sregex_iterator());
}

TEST(ResidualPlot, ShowsBothSeriesTheBandAndTheHeldOutTime) {
  ResidualPlot plot{"z", "um", Vector3d(0, 1, 2), Vector3d(3, nan, 5), Vector3d(1, 0, -1), Vector3d(2, 2, 2), 1.5};
  const std::string both = residual_svg(plot);
  EXPECT_EQ(count(both, "class=\"line orange\" d=\"M[^L]*M[^L]*\""), 1) << "a gap\n" << both;
  EXPECT_EQ(count(both, "class=\"line blue\" d=\"M[^L]*L[^L]*L[^L]*\""), 1) << both;
  EXPECT_EQ(count(both, "class=\"area band\""), 1);
  EXPECT_EQ(count(both, "class=\"area shade\""), 1);
  for (const char* text : {">um<", ">time in h<", "residual of z\""}) EXPECT_EQ(count(both, text), 1) << text;
  plot.show_after = false;
  EXPECT_EQ(count(residual_svg(plot), "class=\"line blue\""), 0);
}

TEST(ResidualPlot, WithoutRowsIsStillAPlot) {
  EXPECT_EQ(count(residual_svg({}), "nan|inf "), 0);
  EXPECT_EQ(count(residual_svg({}), "</svg>"), 1);
}

TEST(ResidualMap, OneCellAMeasuredTimeInTheColourOfItsSign) {
  ResidualMap map{{"T1", "z"}, Vector3d(0, 1, 2), Eigen::MatrixXd(3, 2), 1.0};
  map.ratio << 9.0, -9.0, nan, -0.5, 9.0, -9.0;
  const std::string svg = residual_map_svg(map);
  EXPECT_EQ(count(svg, "<rect class=\"area orange\""), 2) << svg;
  EXPECT_EQ(count(svg, "<rect class=\"area blue\""), 3);
  EXPECT_EQ(count(svg, "fill-opacity=\"0.06\""), 1) << "as expected: pale";
  for (const char* text : {">T1<", ">z<", ">time in h<", "line dashed grey"}) EXPECT_EQ(count(svg, text), 1) << text;
  map.hours.resize(1);
  EXPECT_EQ(residual_map_svg(map), "");
}

}  // namespace
}  // namespace thermotwin::diagnosis
