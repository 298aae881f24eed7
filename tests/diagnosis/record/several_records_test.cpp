// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/several_records.h"

#include <gtest/gtest.h>

#include "tests/machines/rods_record.h"

namespace {

using namespace thermotwin;
using compensation::Measurement;
using Eigen::Index;

Measurement record(const std::string& folder, double hours, double first_s) {
  Measurement m = lumped::measure({}, {.hours = hours});
  m.folder = folder;
  m.data.values.col(0).array() += first_s;
  return m;
}

TEST(SeveralRecords, AreNamedByTheirFolders) {
  std::vector<Measurement> records{record("a/monday", 3, 0), record("b/monday/", 3, 0), record("b/friday", 3, 0)};
  EXPECT_EQ(diagnosis::record_names(records), (std::vector<std::string>{"monday", "monday_2", "friday"}));
  const std::vector<Measurement> named = diagnosis::with_record_names(records);
  EXPECT_EQ(named[1].channels.front().id, "monday_2/T1_reading");
  EXPECT_EQ(named[1].channels.front().column, records[1].channels.front().column);
  records.resize(1);
  EXPECT_EQ(diagnosis::record_names(records), (std::vector<std::string>{""}));
  EXPECT_EQ(diagnosis::with_record_names(records)[0].channels.front().id, "T1_reading");
}

TEST(SeveralRecords, LieOneAfterAnotherWithTheirOwnTimeKept) {
  const std::vector<Measurement> records =
      diagnosis::with_record_names({record("monday", 4, 0), record("friday", 3, 7200)});
  const mesh::Machine machine = lumped::machine();
  std::vector<diagnosis::Observations> each;
  for (const Measurement& m : records) each.push_back(diagnosis::observe(m, machine, solver::Channels(machine), {}));
  const diagnosis::Observations alone = each[1], all = diagnosis::joined(each, diagnosis::record_names(records));
  ASSERT_EQ(all.each().size(), 2U);
  EXPECT_EQ(all.size(), each[0].size() + each[1].size());
  EXPECT_EQ(all.intervals, each[0].intervals + each[1].intervals);
  EXPECT_EQ(all.points.size(), all.rows.rows() + 1);
  EXPECT_DOUBLE_EQ(all.end - all.start, 7 * 3600.0);
  EXPECT_EQ(all.points.tail(alone.points.size()), (alone.points.array() + (4 * 3600.0 - 7200.0)).matrix());
  const std::size_t first = each[0].channels.size();
  for (std::size_t k = 0; k < alone.channels.size(); ++k) {
    const diagnosis::ObservedChannel &here = all.channels[first + k], &own = alone.channels[k];
    EXPECT_EQ(here.record, 1);
    EXPECT_EQ(here.value, own.value);
    EXPECT_EQ(here.fitted, own.fitted) << "each has its own held-out end";
    EXPECT_EQ(here.interval.front(), own.interval.front() + each[0].intervals);
    const Eigen::MatrixXd own_values = Eigen::VectorXd::LinSpaced(alone.points.size(), 1.0, 3.0);
    Eigen::MatrixXd values = Eigen::MatrixXd::Constant(all.points.size(), 1, 99.0);
    values.bottomRows(own_values.rows()) = own_values;
    EXPECT_LT((here.means(values) - own.means(own_values)).cwiseAbs().maxCoeff(), 1e-12);
  }
  const diagnosis::ObservedChannel& channel = all.channels[first];
  EXPECT_EQ(channel.device(), "friday/temperature");
  for (const char* id : {"friday/T1_reading", "T1_reading", "friday/temperature", "temperature"})
    EXPECT_TRUE(channel.is_called(id)) << id;
  for (const char* id : {"monday/T1_reading", "monday/temperature", "displacement", "T2_reading"})
    EXPECT_FALSE(channel.is_called(id)) << id;
}

TEST(SeveralRecords, HaveIntervalsOfOneLength) {
  Measurement week = record("week", 3, 0);
  week.data.values.col(0) *= 100.0;
  const std::vector<Measurement> records{record("day", 3, 0), week};
  EXPECT_DOUBLE_EQ(diagnosis::common_interval_s(records, 600), 300 * 3600.0 / 600.0);
  EXPECT_DOUBLE_EQ(diagnosis::common_interval_s({records.data(), 1}, 600), 600.0);
}

}  // namespace
