// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/observations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "mesh/machine/file.h"
#include "tests/machines/rods_record.h"

namespace {

using namespace thermotwin;
using Eigen::Index;

const diagnosis::ObservedChannel& channel_of(const diagnosis::Observations& seen, const std::string& id) {
  for (const diagnosis::ObservedChannel& channel : seen.channels)
    if (channel.channel.id == id) return channel;
  throw std::logic_error("no channel " + id);
}

diagnosis::Observations observed(const mesh::Machine& machine, const compensation::Measurement& m) {
  return diagnosis::observe(m, machine, solver::Channels(machine), {});
}

Index machine_speed(const compensation::Measurement& m) {
  const auto at = std::find_if(m.channels.begin(), m.channels.end(), [](const compensation::MeasuredChannel& channel) {
    return channel.kind == compensation::ChannelKind::speed;
  });
  return at->column;
}

/// T5 reads the coolant's return, whose pump switches every three hours.
TEST(Observations, MeansOfAReturnThatTouchASwitchOfItsPumpAreLeftOut) {
  std::string text = lumped::machine_text();
  const std::string solid = "id = \"T5\"\nbody = \"head\"\npoint_mm = [0, 0, 900]";
  text.replace(text.find(solid), solid.size(), "id = \"T5\"\nreturn_of = \"main\"");
  const mesh::Machine machine = mesh::parse_machine(text, "rods/machine.toml");
  compensation::Measurement m = lumped::measure({}, {.hours = 12, .sample_s = 60});
  compensation::MeasuredChannel pump;
  pump.id = pump.input = "coolant.main.on";
  pump.kind = compensation::ChannelKind::state;
  pump.column = m.data.values.cols();
  m.data.values.conservativeResize(Eigen::NoChange, pump.column + 1);
  m.data.columns.push_back(pump.id);
  m.channels.push_back(pump);
  const Eigen::VectorXd time = m.time();
  std::set<Index> switched;
  for (Index i = 0; i < time.size(); ++i) {
    m.data.values(i, pump.column) = static_cast<Index>(time[i] / 10800.0) % 2 == 0 ? 1.0 : 0.0;
    if (i > 0 && m.data.values(i, pump.column) != m.data.values(i - 1, pump.column))
      for (const Index row : {i - 1, i}) switched.insert(std::min<Index>(static_cast<Index>(time[row] / 600.0), 71));
  }
  ASSERT_EQ(switched.size(), 7U) << "the last switch falls on the end";
  const diagnosis::Observations seen = observed(machine, m);
  const auto left_out = [&](const std::string& id) {
    std::set<Index> all;
    for (Index k = 0; k < seen.intervals; ++k) all.insert(k);
    for (const Index k : channel_of(seen, id).interval) all.erase(k);
    return all;
  };
  EXPECT_EQ(left_out("T5_reading"), switched);
  EXPECT_TRUE(left_out("T4_reading").empty()) << "a sensor in a body does not jump";
}

TEST(Observations, RowsMoreThanAMinuteApartLeaveTheTimesOfChangesOpen) {
  const mesh::Machine machine = lumped::machine();
  EXPECT_FALSE(observed(machine, lumped::measure({}, {.hours = 8, .sample_s = 100})).may_hold.empty());
  EXPECT_TRUE(observed(machine, lumped::measure({}, {.hours = 8, .sample_s = 60})).may_hold.empty());
}

TEST(Observations, ARecordWithARowAtEachChangeHasNoChangesOfUncertainTime) {
  compensation::Measurement m = lumped::measure({}, {.hours = 8, .sample_s = 300});
  const mesh::Machine machine = lumped::machine();
  EXPECT_FALSE(observed(machine, m).may_hold.empty());
  EXPECT_GT(observed(machine, m).told_row_s, 0.0);
  m.rows_at_changes = true;
  EXPECT_TRUE(observed(machine, m).may_hold.empty());
  EXPECT_EQ(observed(machine, m).told_row_s, 0.0);
}

/// Beside a source a temperature rises with the root of the time since a switch. Straight lines over a step of five
/// minutes made of it a clock of a minute.
TEST(Observations, MeansAfterASwitchFollowACourseThatBends) {
  const mesh::Machine machine = lumped::machine();
  const compensation::Measurement m = lumped::measure({}, {.hours = 12, .sample_s = 60});
  const Index speed = machine_speed(m);
  Index row = 1;
  while (m.data.values(row, speed) == m.data.values(row - 1, speed)) ++row;
  const double switched = m.time()[row];
  const auto risen = [&](double time) { return std::sqrt(std::max(0.0, time - switched)); };
  const diagnosis::Observations seen = observed(machine, m);
  const Eigen::VectorXd at_points = seen.points.unaryExpr(risen);
  const diagnosis::ObservedChannel& channel = channel_of(seen, "T4_reading");
  const Eigen::VectorXd means = channel.means(at_points);
  for (const Index interval : {0, 1}) {
    double sum = 0.0, count = 0.0;
    for (const double time : m.time())
      if (time >= switched + 600.0 * interval && time < switched + 600.0 * (interval + 1)) sum += risen(time), ++count;
    const auto at =
        std::find(channel.interval.begin(), channel.interval.end(), std::lround(switched / 600.0) + interval);
    ASSERT_NE(at, channel.interval.end());
    EXPECT_NEAR(means[at - channel.interval.begin()] / (sum / count), 1.0, 0.015) << "interval " << interval;
  }
}

/// Inputs hold from row to row, but the clock does not wait.
TEST(Observations, TheTimeOfDayRunsOnThroughAPause) {
  compensation::Measurement m = lumped::measure({}, {.hours = 12, .sample_s = 300});
  m.starts_at_h = 22.0;
  std::vector<Index> kept;
  for (Index i = 0; i < m.data.values.rows(); ++i)
    if (m.time()[i] < 3.1 * 3600 || m.time()[i] > 6.9 * 3600) kept.push_back(i);
  m.data.values = Eigen::MatrixXd(m.data.values(kept, Eigen::all));
  mesh::Machine machine = lumped::machine();
  machine.asks_time_of_day = true;
  const solver::Channels channels(machine);
  const diagnosis::Observations seen = observed(machine, m);
  ASSERT_GT(seen.rows.rows(), 100);
  for (Index s = 0; s < seen.rows.rows(); ++s) {
    const double middle = 0.5 * (seen.points[s] + seen.points[s + 1]);
    EXPECT_NEAR(seen.rows(s, channels.index("day.time_h")), 22.0 + middle / 3600.0, 1e-9) << "step " << s;
  }
}

}  // namespace
