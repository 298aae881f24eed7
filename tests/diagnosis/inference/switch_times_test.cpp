// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/switch_times.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"
#include "tests/machines/rods_record.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;
using diagnosis::Observations;
using Eigen::Index;
using Eigen::MatrixXd;

/// A log with rows about so many minutes apart of a record each minute: the changes each three hours are seen by a part
/// of that late.
compensation::Measurement sparse(const compensation::Measurement& dense, unsigned seed, Index minutes = 5) {
  compensation::Measurement m = dense;
  std::mt19937 random(seed);
  std::vector<Index> kept{0};
  for (Index row = minutes * 3 / 5; row + 1 < dense.data.rows(); row += minutes)
    kept.push_back(row + static_cast<Index>(random() % 3) - 1);
  m.data.values = MatrixXd(dense.data.values(kept, Eigen::all));
  return m;
}

TEST(LateChanges, AreMovedToWhereTheyCame) {
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 17);
  const compensation::Measurement m =
      sparse(lumped::measure({}, {.hours = 24, .sample_s = 60, .noise_K = 0.02, .noise_um = 0.1}), 3, 15);
  diagnosis::DiagnoseOptions how;
  how.temperature_error_percent = how.displacement_error_percent = 0.2;  // the model has the machine's own cells
  const diagnosis::Seen seen = diagnosis::see(model, m, how);
  int moved = 0;
  for (const Observations::MayHold& may : seen.observations->may_hold) {
    if (may.earlier || may.shown > seen.observations->split) continue;
    const double truth = 3 * 3600 * std::floor(may.shown / (3 * 3600.0));
    EXPECT_NEAR(may.from, truth, 270) << may.shown << ", of nine to ten minutes";
    ++moved;
  }
  EXPECT_GE(moved, 2);
  // A log with a row at each change is taken as it is.
  const diagnosis::Seen as_said = diagnosis::see(model, lumped::measure({}, {.hours = 24, .sample_s = 300}), how);
  ASSERT_FALSE(as_said.observations->may_hold.empty());
  for (const Observations::MayHold& may : as_said.observations->may_hold) EXPECT_EQ(may.to, may.shown);
}

TEST(LateChanges, ALogThatSeesThemLateRaisesNoAlarm) {
  const reduction::ReducedModel model = lumped::model(lumped::machine(), 9);
  diagnosis::DiagnoseOptions how;
  how.temperature_error_percent = 3;  // 27 nodes
  for (const unsigned seed : {5U, 6U, 7U}) {
    const diagnosis::Diagnosis d = diagnosis::diagnose(
        model, sparse(lumped::measure({}, {.sample_s = 60, .seed = seed, .spread = 0.5}), seed), how);
    EXPECT_EQ(d.verdict, diagnosis::Verdict::no_discrepancy) << seed << ": " << d.sentence;
  }
}

TEST(LateChanges, LeaveACauseToBeFound) {
  const reduction::ReducedModel model = lumped::model(lumped::machine(), 9);
  diagnosis::DiagnoseOptions how;
  how.temperature_error_percent = 3;
  const diagnosis::Diagnosis d =
      diagnosis::diagnose(model,
                          sparse(lumped::measure({{lumped::find(Kind::source_power, "motor"), 1.6}},
                                                 {.sample_s = 60, .seed = 8, .spread = 0.5}),
                                 8),
                          how);
  ASSERT_EQ(d.verdict, diagnosis::Verdict::explained) << d.sentence;
  ASSERT_EQ(d.causes.size(), 1U);
  EXPECT_EQ(d.causes[0].parameter.kind, Kind::source_power);
  EXPECT_EQ(d.causes[0].parameter.where, "motor");
  EXPECT_NEAR(d.causes[0].value, 1.6, 3 * d.causes[0].std);
  EXPECT_LT(d.causes[0].std, 0.15);
}

TEST(LateChanges, InAGapAreMovedEitherWay) {
  // Speeds change each three hours; of rows each five minutes three are lost there, behind the change or before it.
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 17);
  diagnosis::DiagnoseOptions how;
  how.temperature_error_percent = how.displacement_error_percent = 0.2;
  compensation::Measurement m = lumped::measure({}, {.hours = 24, .sample_s = 60, .noise_K = 0.02, .noise_um = 0.1});
  std::vector<Index> kept;
  for (Index row = 0; row < m.data.rows(); ++row) {
    const Index part = row / 180, minute = row % 180;
    if (row % 5 == 0 && (part % 2 == 0 || (minute > 10 && minute < 165))) kept.push_back(row);
  }
  m.data.values = MatrixXd(m.data.values(kept, Eigen::all));
  const diagnosis::Seen seen = diagnosis::see(model, m, how);
  int early = 0, late = 0;
  for (const Observations::MayHold& may : seen.observations->may_hold) {
    if (!may.earlier || may.shown > seen.observations->split) continue;
    const double truth = 3 * 3600 * std::round(may.shown / (3 * 3600.0)), middle = 0.5 * (may.from + may.shown);
    EXPECT_NEAR(may.to, truth, 120) << may.shown;
    (may.to < middle ? early : late) += std::abs(may.to - middle) > 1.0;
  }
  EXPECT_GE(early, 1);
  EXPECT_GE(late, 1);
}

}  // namespace
