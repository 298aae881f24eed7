// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/pauses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"
#include "diagnosis/response/response.h"
#include "diagnosis/response/start_modes.h"
#include "tests/diagnosis/diagnosed_rods.h"

namespace {

using namespace thermotwin;
using diagnosis::Diagnosis, diagnosis::Kind, diagnosis::Observations;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double hour = 3600.0;

/// Without the rows between two times, which stay.
compensation::Measurement paused(compensation::Measurement m, double from_h, double to_h) {
  std::vector<Index> kept;
  for (Index i = 0; i < m.data.rows(); ++i)
    if (const double at = m.data.values(i, 0); at <= from_h * hour + 1 || at >= to_h * hour - 1) kept.push_back(i);
  m.data.values = MatrixXd(m.data.values(kept, Eigen::all));
  return m;
}

Observations observed(const compensation::Measurement& m, const std::map<double, double>& changes = {}) {
  const mesh::Machine machine = lumped::machine();
  return diagnosis::observe(m, machine, solver::Channels(machine), {.changes = changes});
}

std::vector<Observations::MayHold> in_pause(const Observations& of) {
  std::vector<Observations::MayHold> found;
  for (const Observations::MayHold& may : of.may_hold)
    if (may.in_pause) found.push_back(may);
  return found;
}

Index column_of(const compensation::Measurement& m, const std::string& input) {
  return std::find_if(m.channels.begin(), m.channels.end(), [&](const auto& c) { return c.input == input; })->column;
}

TEST(Pauses, AnythingMayHaveRunInAnyPartOfThem) {
  // From 9 to 12 h the spindle stands and an axis moves.
  const compensation::Measurement whole = lumped::measure({}, {.noise_K = 0, .noise_um = 0});
  const Observations obs = observed(paused(whole, 9.5, 11.5));
  ASSERT_EQ(obs.pauses.size(), 1U);
  EXPECT_NEAR(obs.pauses[0].from, 9.5 * hour, 1e-9);
  EXPECT_NEAR(obs.pauses[0].shown, 11.5 * hour, 1e-9);
  const mesh::Machine machine = lumped::machine();
  const solver::Channels channels(machine);
  const int rpm = channels.index("spindle.speed_rpm"), feed = channels.index("axis.Z.feed_mm_min"),
            position = channels.index("axis.Z.position_mm");
  for (const auto& [channel, other] : {std::pair{rpm, 11000.0}, std::pair{feed, 0.0}}) {
    double covered = 0.0, ends = 11.5 * hour, longest = 0.0;
    for (const Observations::MayHold& may : in_pause(obs)) {
      if (std::ranges::count(may.channels, channel) == 0 || may.row[position] != 100) continue;
      EXPECT_EQ(may.row[channel], other);
      EXPECT_NEAR(may.to, ends, 1e-9) << "one after another, from the end";
      EXPECT_GE(may.to - may.from, longest) << "the last ones are short";
      EXPECT_NEAR(may.std, std::sqrt(1.0 / 3.0), 1e-9);
      longest = may.to - may.from;
      covered += longest;
      ends = may.from;
    }
    EXPECT_NEAR(covered, 2 * hour, 1e-6);
  }
  EXPECT_TRUE(in_pause(observed(whole)).empty());
  compensation::Measurement told = paused(whole, 9.5, 11.5);
  told.rows_at_changes = true;
  EXPECT_TRUE(in_pause(observed(told)).empty()) << "then nothing changed without a row";
}

TEST(Pauses, TemperaturesWanderOnThroughThem) {
  const compensation::Measurement m = paused(lumped::measure({}, {.noise_K = 0, .noise_um = 0}), 9.5, 15.5);
  const Observations obs = observed(m);
  const int air = solver::Channels(lumped::machine()).index("air.T_C");
  const auto at = [&](double when) {
    Index s = 0;
    while (obs.points[s + 1] <= when * hour) ++s;
    return obs.rows(s, air);
  };
  const double before = at(9.51), after = at(15.49);
  EXPECT_GT(std::abs(before - after), 0.5);
  EXPECT_NEAR(at(12.5), 0.5 * (before + after), 0.05);
  EXPECT_NEAR(at(11.0), 0.75 * before + 0.25 * after, 0.05);
}

/// Steps of five minutes in a pause from 0 to its end, with the same inputs in all of them.
Observations held_through(const VectorXd& row, double hours) {
  Observations obs;
  const Index steps = std::max<Index>(1, std::lround(12 * hours));
  obs.points = VectorXd::LinSpaced(steps + 1, 0.0, hours * hour);
  obs.rows = row.transpose().replicate(steps, 1);
  obs.pauses = {{0.0, hours * hour}};
  return obs;
}

TEST(Pauses, OfManyInputsHaveLongerParts) {
  for (const int inputs : {4, 20, 30, 60}) {
    std::vector<compensation::Channel> channels(inputs);
    std::vector<diagnosis::Watched> watched;
    for (int c = 0; c < inputs; ++c) watched.push_back({c, 1.0});
    MatrixXd rows = MatrixXd::Zero(2, inputs);
    rows.row(1).setOnes();
    Observations obs = held_through(VectorXd::Zero(inputs), 14);
    diagnosis::add_unknown_operation(rows, channels, watched, true, obs);
    EXPECT_LE(obs.may_hold.size(), 128U) << inputs;
    for (int c = 0; c < inputs; ++c) {
      double covered = 0.0;
      for (const auto& may : obs.may_hold) {
        if (may.channels != std::vector<Index>{c}) continue;
        covered += may.to - may.from;
        EXPECT_EQ(may.row[c], 1.0);
      }
      EXPECT_NEAR(covered, 14 * hour, 1e-6) << inputs;
    }
  }
}

TEST(Pauses, AnAxisMovesAsItDidOrStands) {
  using compensation::Quantity;
  const double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<compensation::Channel> channels(5);
  const Quantity quantities[] = {Quantity::feed, Quantity::position, Quantity::range, Quantity::range,
                                 Quantity::turning};
  for (int c = 0; c < 5; ++c) channels[c].quantity = quantities[c], channels[c].axis = c < 4 ? "Z" : "";
  MatrixXd rows(3, 5);
  rows << 0, 100, none, none, 0,  //
      15000, 250, 200, 300, 0,    //
      0, 100.4, none, none, 0;
  const std::vector<diagnosis::Watched> watched{{0, 15000}};
  const auto others = [&](const VectorXd& held) {
    Observations obs = held_through(held, 0.08);
    diagnosis::add_unknown_operation(rows, channels, watched, true, obs);
    return obs.may_hold;
  };
  const std::vector<Index> of_z{0, 1, 2, 3};
  const auto standing = others(rows.row(0).transpose());
  ASSERT_EQ(standing.size(), 2U) << "it moved, or stood elsewhere";
  EXPECT_EQ(standing[0].channels, of_z);
  EXPECT_EQ(standing[0].row.head(4), rows.row(1).head(4).transpose());
  EXPECT_EQ(standing[1].row[0], 0.0);
  EXPECT_EQ(standing[1].row[1], 250.0);
  const auto moving = others(rows.row(1).transpose());
  ASSERT_EQ(moving.size(), 2U);
  EXPECT_EQ(moving[0].channels, of_z);
  EXPECT_EQ(moving[0].row[0], 0.0);
  EXPECT_TRUE(std::isnan(moving[0].row[2]) && std::isnan(moving[0].row[3])) << "where it stands it does not swing";
  EXPECT_EQ(moving[1].row[1], 100.0);
}

// The speed changes at 3 h from 0 to 6000 rpm: before it something else ran, after it the spindle stood.
TEST(Pauses, WhatElseRanIsElseThanTheModelTakes) {
  const Observations obs =
      observed(paused(lumped::measure({}, {.noise_K = 0, .noise_um = 0}), 1.5, 5.5), {{5.5 * hour, 3.0 * hour}});
  const int rpm = solver::Channels(lumped::machine()).index("spindle.speed_rpm");
  int before = 0, after = 0;
  for (const Observations::MayHold& may : in_pause(obs)) {
    if (may.channels.front() != rpm) continue;
    const double middle = 0.5 * (may.from + may.to);
    EXPECT_EQ(may.row[rpm], middle < 3 * hour ? 11000.0 : 0.0) << middle;
    ++(middle < 3 * hour ? before : after);
  }
  EXPECT_GE(before, 1);
  EXPECT_GE(after, 2);
}

TEST(Pauses, OfManyTheLongestAreTaken) {
  compensation::Measurement m = lumped::measure({}, {.noise_K = 0, .noise_um = 0});
  for (int k = 0; k < 30; ++k) m = paused(m, 0.5 + 1.15 * k, 0.9 + 1.15 * k + 0.01 * k);
  const Observations obs = observed(m);
  EXPECT_EQ(obs.pauses.size(), 30U);
  const std::vector<Observations::MayHold> taken = in_pause(obs);
  EXPECT_LE(taken.size(), 128U);
  std::set<double> shown;
  for (const auto& may : taken) shown.insert(may.shown);
  ASSERT_FALSE(shown.empty());
  EXPECT_LT(shown.size(), 30U);
  EXPECT_TRUE(shown.contains(obs.pauses.back().shown));
  EXPECT_FALSE(shown.contains(obs.pauses.front().shown));
}

TEST(Pauses, WhatMayHaveRunDoesWhatItDoesWhereItIsLogged) {
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 9);
  const compensation::Measurement m = paused(lumped::measure({}, {.noise_K = 0, .noise_um = 0}), 9.5, 11.5);
  const Observations obs = observed(m);
  const diagnosis::Response response(model, obs);
  const diagnosis::Problem problem = diagnosis::make_problem(machine, m, obs, response, {});
  const auto held = std::ssize(obs.may_hold);
  const Index speed = column_of(m, "spindle.speed_rpm"), air = column_of(m, "air.T_C");
  int compared = 0;
  for (Index k = 0; k < held; ++k) {
    const Observations::MayHold& may = obs.may_hold[k];
    if (!may.in_pause || may.row[may.channels.front()] != 11000.0) continue;
    // Two rows without readings say that it ran.
    compensation::Measurement logged = m;
    MatrixXd& values = logged.data.values;
    Index before = 0;
    while (values(before, 0) < 9.5 * hour - 1) ++before;
    const double air_before = values(before, air), air_after = values(before + 1, air);
    for (const double at : {may.from, may.to}) {
      if (std::abs(at - values(before + 1, 0)) < 1) continue;  // the row after the pause ends it
      VectorXd row = values.row(before).transpose();
      for (const auto& channel : m.channels)
        if (channel.input.empty()) row[channel.column] = std::numeric_limits<double>::quiet_NaN();
      row[0] = at;
      row[air] = std::lerp(air_before, air_after, (at / hour - 9.5) / 2.0);
      row[speed] = at == may.from ? 11000.0 : 0.0;
      if (std::abs(at - values(before, 0)) < 1) {
        values(before, speed) = 11000.0;
        continue;
      }
      Index next = before + 1;
      while (values(next, 0) < at) ++next;
      const MatrixXd below = values.bottomRows(values.rows() - next);
      values.conservativeResize(values.rows() + 1, Eigen::NoChange);
      values.row(next) = row.transpose();
      values.bottomRows(below.rows()) = below;
    }
    const VectorXd truth = diagnosis::Response(model, observed(logged, {{11.5 * hour, 11.5 * hour}})).predict(machine) -
                           problem.predicted,
                   column = problem.columns.rightCols(held).col(k);
    ASSERT_EQ(truth.size(), column.size());
    EXPECT_GT(truth.cwiseAbs().maxCoeff(), 0.1) << k;
    EXPECT_LT((column - truth).norm(), 0.1 * truth.norm()) << may.from << " to " << may.to;
    ++compared;
  }
  EXPECT_GE(compared, 3);
}

// From 12 to 18 h the spindle runs at two speeds, of which the log has no row.
TEST(Pauses, WhatRanInThemRaisesNoAlarm) {
  for (std::uint64_t seed = 31; seed <= 33; ++seed) {
    const Diagnosis d =
        lumped::run(paused(lumped::measure({}, {.sample_s = 300, .seed = seed, .spread = 0.5}), 11.75, 18.25));
    EXPECT_EQ(d.verdict, diagnosis::Verdict::no_discrepancy) << seed << lumped::listed(d);
    EXPECT_TRUE(std::any_of(d.warnings.begin(), d.warnings.end(), [](const std::string& text) {
      return text.find("a pause of 6.5 h") != std::string::npos;
    }));
  }
}

TEST(Pauses, LeaveACauseToBeFound) {
  const Diagnosis d = lumped::run(paused(
      lumped::measure({{lumped::find(Kind::source_power, "motor"), 1.6}}, {.sample_s = 300, .seed = 34, .spread = 0.5}),
      11.75, 18.25));
  lumped::expect_found(d, lumped::find(Kind::source_power, "motor"), 1.6, 0.2);
  EXPECT_EQ(d.verdict, diagnosis::Verdict::explained) << lumped::listed(d);
}

/// Without the first hours: the machine is at work, and warm, when the record begins.
compensation::Measurement begun_late(compensation::Measurement m, double from_h) {
  Index first = 0;
  while (m.data.values(first, 0) < from_h * hour) ++first;
  const MatrixXd kept = m.data.values.bottomRows(m.data.rows() - first);
  m.data.values = kept;
  for (const auto& channel : m.channels)
    if (channel.zero == compensation::Zero::first)
      m.data.values.col(channel.column).array() -= m.data.values(0, channel.column);
  return m;
}

TEST(EarlierOperation, IsWhatALongerRecordWouldShow) {
  // At 5 h the spindle has run for two hours at 6000 rpm; a field of a longer run of the model begins the record.
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 9);
  const Observations obs = observed(begun_late(lumped::measure({}, {.hours = 24, .noise_K = 0, .noise_um = 0}), 5.0));
  ASSERT_FALSE(obs.before.empty());
  EXPECT_NEAR(obs.before.front().to, 5.0 * hour, 1e-6);
  EXPECT_NEAR(obs.before.back().from, (5.0 - 36.0) * hour, 1e-6);
  const diagnosis::MachineInTime as_stated(machine);
  const MatrixXd rows = MatrixXd::Zero(1, model.system.order());
  const MatrixXd fields = diagnosis::earlier_operation({model, obs, as_stated, rows, model.system.capacity});
  ASSERT_EQ(fields.cols(), std::ssize(obs.before));
  const int rpm = solver::Channels(machine).index("spindle.speed_rpm");
  double largest = 0.0;
  for (Index i = 0; i < fields.cols(); ++i) {
    if (obs.before[i].channels.front() != rpm) continue;
    const VectorXd read = model.system.sensors * fields.col(i);
    EXPECT_LT(read.maxCoeff(), 0.05) << "the spindle stood instead";
    largest = std::max(largest, -read.minCoeff());
  }
  EXPECT_GT(largest, 1.0);
  Observations even = obs;
  even.start_spread_K = 0.2;
  even.start_second_K = 0.9;
  EXPECT_EQ(diagnosis::earlier_operation({model, even, as_stated, rows, model.system.capacity}).cols(), 0);
}

// At 8 h the spindle has run for five hours, and stands from 9 h on.
TEST(EarlierOperation, RaisesNoAlarm) {
  for (std::uint64_t seed = 41; seed <= 43; ++seed) {
    const Diagnosis d =
        lumped::run(begun_late(lumped::measure({}, {.sample_s = 300, .seed = seed, .spread = 0.5}), 8.0));
    EXPECT_EQ(d.verdict, diagnosis::Verdict::no_discrepancy) << seed << lumped::listed(d);
  }
}

// Steady heat that had begun before the record moves no probe, which are zero at its first row.
TEST(EarlierOperation, MayBeWhatLooksLikeAnOffset) {
  const auto m =
      lumped::measure({{lumped::find(Kind::sensor_offset, "T4_reading"), 3.0}}, {.sample_s = 300, .seed = 45});
  EXPECT_EQ(lumped::run(m).verdict, diagnosis::Verdict::explained);
  const Diagnosis d = lumped::run(begun_late(m, 8.0));
  EXPECT_EQ(d.verdict, diagnosis::Verdict::ambiguous) << lumped::listed(d);
  EXPECT_NE(d.sentence.find("steady heat near T4_reading"), std::string::npos) << d.sentence;
}

TEST(EarlierOperation, LeavesACauseToBeFound) {
  const Diagnosis d = lumped::run(begun_late(
      lumped::measure({{lumped::find(Kind::source_power, "motor"), 1.6}}, {.sample_s = 300, .seed = 44, .spread = 0.5}),
      8.0));
  lumped::expect_found(d, lumped::find(Kind::source_power, "motor"), 1.6, 0.25);
  EXPECT_EQ(d.verdict, diagnosis::Verdict::explained) << lumped::listed(d);
}

}  // namespace
