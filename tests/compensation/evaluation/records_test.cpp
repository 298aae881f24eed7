// SPDX-License-Identifier: GPL-3.0-or-later
// Records as they come: probes that start late, channels that stay.
#include "tests/compensation/records.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "compensation/evaluation/evaluate.h"
#include "compensation/evaluation/result.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;

/// A lag behind one of two temperatures, every five minutes.
Measurement record(Index rows) {
  Measurement m;
  m.folder = "record";
  m.data.source = "record";
  m.data.columns = {"time_s", "hall", "frame", "z", "y"};
  m.data.values.resize(rows, 5);
  test::Uniform uniform(2);
  double frame = 20.0;
  for (Index i = 0; i < rows; ++i) {
    const double time = 300.0 * i, hall = 20.0 + 2.0 * std::sin(time / 9000.0) + 0.01 * uniform.normal();
    frame += 0.05 * (hall - frame);
    m.data.values.row(i) << time, hall, frame, 5.0 * (frame - 20.0) - 2.0 * (hall - 20.0), 0.0;
  }
  for (const char* id : {"hall", "frame", "z", "y"}) {
    const bool displacement = m.channels.size() > 1;
    MeasuredChannel channel;
    channel.id = id;
    channel.unit = displacement ? "um" : "degC";
    channel.kind = displacement ? ChannelKind::displacement : ChannelKind::temperature;
    channel.uncertainty = displacement ? 0.1 : 0.05;
    if (!displacement) channel.sensor = id;
    channel.column = std::ssize(m.channels) + 1;
    m.channels.push_back(channel);
  }
  return m;
}

TEST(EvaluateRecords, TrainingBeginsWhereDisplacementsDo) {
  Measurement m = record(600);  // 50 h, displacements in the last 16 h only
  m.data.values.col(3).head(408).setConstant(std::numeric_limits<double>::quiet_NaN());
  m.data.values.col(4).head(408).setConstant(std::numeric_limits<double>::quiet_NaN());
  EvaluateOptions options;
  options.models = {"static_regression"};
  const Evaluation evaluation = evaluate(m, nullptr, options);
  ASSERT_FALSE(evaluation.leaderboard.empty());
  EXPECT_GT(evaluation.leaderboard.front().reduction_percent, 99.0);
  bool seen = false, unseen = false;
  for (const EvaluationRow& row : evaluation.rows) (row.training ? seen : unseen) = true;
  EXPECT_TRUE(seen && unseen);
}

TEST(EvaluateRecords, AChannelThatStaysSpoilsNoStanding) {
  EvaluateOptions options;
  options.models = {"static_regression"};
  const Evaluation evaluation = evaluate(record(600), nullptr, options);
  ASSERT_EQ(evaluation.leaderboard.size(), 1U);
  EXPECT_EQ(evaluation.leaderboard.front().channels, 2);
  EXPECT_GT(evaluation.leaderboard.front().reduction_percent, 99.0);
}

// Two folders of one name are two: neither hides the other, nor is one held out because the other trains.
TEST(EvaluateRecords, FoldersOfOneNameAreJudgedEach) {
  const Measurement all = record(600);
  Measurement twice = all, wrong = all;
  twice.folder = "one/record";
  wrong.folder = "two/record";
  wrong.data.values.col(3) *= -1.0;
  EvaluateOptions options;
  options.models = {"static_regression"};
  const auto removed = [&](const std::vector<Measurement>& others, const std::vector<Measurement>& training) {
    return evaluate(all, nullptr, options, others, training).leaderboard.front().reduction_percent;
  };
  const Evaluation both = evaluate(all, nullptr, options, {twice, wrong});
  ASSERT_EQ(both.other_predictions.size(), 2U);
  EXPECT_EQ(both.other_predictions[0].first, "record");
  EXPECT_EQ(both.other_predictions[1].first, "record_2");
  EXPECT_NEAR(removed({twice, wrong}, {}), removed({wrong, twice}, {}), 1e-9);
  EXPECT_LT(removed({twice, wrong}, {}), removed({twice}, {}) - 10.0);
  EXPECT_LT(removed({wrong}, {twice}), removed({}, {twice}) - 10.0);
}

}  // namespace
}  // namespace thermotwin::compensation
