// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/plots.h"

#include <gtest/gtest.h>

#include <limits>
#include <regex>

namespace thermotwin::compensation {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::ptrdiff_t count(const std::string& text, const std::string& pattern) {
  const std::regex what(pattern);
  return std::distance(std::sregex_iterator(text.begin(), text.end(), what), std::sregex_iterator());
}

Standing standing(const std::string& model, double percent) {
  Standing result;
  result.model = model;
  result.channels = 3;
  result.reduction_percent = percent;
  return result;
}

/// Four models over two hours; the fits saw the first half of them.
Evaluation evaluation() {
  Evaluation result;
  result.leaderboard = {standing("reduced_model", 80.0), standing("grey_box", 60.0), standing("arx", -500.0),
                        standing("static_regression", nan)};
  EvaluationRow row;
  row.model = "reduced_model";
  row.channel = "z";
  row.unit = "um";
  row.to_s = 3600.0;
  result.rows = {row};
  row.training = true;
  for (const char* model : {"grey_box", "arx"}) {
    row.model = model;
    result.rows.push_back(row);
  }
  result.predictions.columns = {"time_s", "z_measured"};
  for (const Standing& each : result.leaderboard) result.predictions.columns.push_back("z_" + each.model);
  result.predictions.values.resize(3, 6);
  result.predictions.values << 0, 1, 1, 1, 1, 1,  //
      3600, 4, 3, 3, 3, 3,                        //
      7200, 5, 5, 5, 5, 50;
  return result;
}

TEST(Plots, TheLeaderboardHasABarAModelThatGivesANumber) {
  Evaluation made = evaluation();
  made.leaderboard[1].seen_by_fit = true;
  made.leaderboard[2].caution = "wild";
  const std::string svg = leaderboard_svg(made);
  EXPECT_EQ(count(svg, "<rect class=\"area "), 3) << svg;
  EXPECT_EQ(count(svg, "<rect class=\"area orange\""), 1) << "the reduced model";
  for (const char* text : {">reduced_model<", ">grey_box \\(fit\\)<", ">arx \\*<", ">80.0 \\(3\\)<", ">-500.0 \\(3\\)<",
                           "ranked last", ">static_regression<", "\u2212100<"})
    EXPECT_EQ(count(svg, text), 1) << text << "\n" << svg;
  EXPECT_EQ(count(svg, "held out</text>"), 1) << "says that this is the fit";
}

TEST(Plots, AChannelShowsTheBestModelsAndTheStaticRegression) {
  const std::string svg = channel_svg(evaluation(), "z");
  EXPECT_EQ(count(svg, "class=\"line black\""), 1) << "measured";
  EXPECT_EQ(count(svg, "class=\"line grey\""), 2) << "prediction and residual of the static regression";
  EXPECT_EQ(count(svg, "class=\"line "), 1 + 2 * 4) << svg;
  EXPECT_EQ(count(svg, "class=\"area shade\""), 2) << "the training hour in both panels";
  for (const char* text : {">measured<", ">grey_box<", ">arx<", ">z in µm<", ">measured minus predicted in µm<",
                           ">time in h<", "shaded: training data"})
    EXPECT_EQ(count(svg, text), 1) << text;
  EXPECT_EQ(count(svg, "nan"), 0);
  Evaluation unfitted = evaluation();
  unfitted.rows.resize(1);
  EXPECT_EQ(count(channel_svg(unfitted, "z"), "area shade|shaded"), 0);
}

TEST(Plots, TheLengthStudyHasABoxAMeasurementAndTheOutliers) {
  LengthStudy study;
  study.channel = "z";
  study.model = "grey_box";
  study.unit = "um";
  study.hours = Eigen::Vector2d(4.0, 8.0);
  study.fit_rms = Eigen::MatrixXd::Constant(2, 6, 1.0);
  study.rest_rms = Eigen::MatrixXd::Constant(2, 6, 2.0);
  study.rest_rms(1, 5) = 9.0;
  study.fit_rms.row(1).setConstant(nan);
  const std::string svg = length_study_svg(study);
  EXPECT_EQ(count(svg, "<rect class=\"area blue\""), 1) << "no section of 8 h could be fitted";
  EXPECT_EQ(count(svg, "<rect class=\"area orange\""), 2);
  EXPECT_EQ(count(svg, "<circle class=\"area orange\""), 1);
  for (const char* text :
       {">4 h<", ">8 h<", ">RMS residual in µm<", ">outside of it<", "grey_box of z: residual over the length[^\"]*<"})
    EXPECT_EQ(count(svg, text), 1) << text << "\n" << svg;
}

TEST(Quartiles, OfFiniteValues) {
  Eigen::VectorXd values(7);
  values << 1, 2, 3, 4, 5, nan, 40;
  const Quartiles found = quartiles(values);
  EXPECT_DOUBLE_EQ(found.low, 2.25);
  EXPECT_DOUBLE_EQ(found.median, 3.5);
  EXPECT_DOUBLE_EQ(found.high, 4.75);
  EXPECT_DOUBLE_EQ(found.whisker_low, 1.0);
  EXPECT_DOUBLE_EQ(found.whisker_high, 5.0);
  EXPECT_EQ(found.outliers, (std::vector<double>{40.0}));
}

}  // namespace
}  // namespace thermotwin::compensation
