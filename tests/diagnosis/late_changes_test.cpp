// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/late_changes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "lumped_machine.h"

namespace {

using namespace thermotwin;
using diagnosis::Observations;
using Eigen::Index;
using Eigen::MatrixXd;

/// A log with rows three to seven minutes apart of a record each minute: the changes each three hours are seen two to four minutes late.
compensation::Measurement sparse(const compensation::Measurement& dense, unsigned seed) {
  compensation::Measurement m = dense;
  std::mt19937 random(seed);
  std::vector<Index> kept{0};
  for (Index row = 3; row + 1 < dense.data.rows(); row += 5) kept.push_back(row + static_cast<Index>(random() % 3) - 1);
  m.data.values = MatrixXd(dense.data.values(kept, Eigen::all));
  return m;
}

TEST(LateChanges, are_moved_to_where_they_came) {
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 17);
  const compensation::Measurement m = sparse(lumped::measure({}, {.hours = 24, .sample_s = 60, .noise_K = 0.02, .noise_um = 0.1}), 3);
  diagnosis::DiagnoseOptions how;
  how.temperature_error_percent = how.displacement_error_percent = 0.2;  // the model has the machine's own cells
  const diagnosis::Seen seen = diagnosis::see(model, m, how);
  int moved = 0;
  for (const Observations::MayHold& may : seen.observations->may_hold) {
    if (may.earlier || may.shown > seen.observations->split) continue;
    const double truth = 3 * 3600 * std::floor(may.shown / (3 * 3600.0));
    EXPECT_NEAR(may.from, truth, 60) << may.shown;
    ++moved;
  }
  EXPECT_GE(moved, 2);
  // A log with a row at each change is taken as it is.
  const diagnosis::Seen as_said = diagnosis::see(model, lumped::measure({}, {.hours = 24, .sample_s = 300}), how);
  ASSERT_FALSE(as_said.observations->may_hold.empty());
  for (const Observations::MayHold& may : as_said.observations->may_hold) EXPECT_EQ(may.to, may.shown);
}

TEST(LateChanges, a_log_that_sees_them_late_raises_no_alarm) {
  const reduction::ReducedModel model = lumped::model(lumped::machine(), 9);
  diagnosis::DiagnoseOptions how;
  how.temperature_error_percent = 3;  // 27 nodes
  for (const unsigned seed : {5U, 6U, 7U}) {
    const diagnosis::Diagnosis d = diagnosis::diagnose(model, sparse(lumped::measure({}, {.sample_s = 60, .seed = seed, .spread = 0.5}), seed), how);
    EXPECT_EQ(d.verdict, "no_discrepancy") << seed << ": " << d.sentence;
  }
}

}  // namespace
