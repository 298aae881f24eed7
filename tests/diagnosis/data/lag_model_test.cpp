// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/data/lag_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <map>
#include <numbers>
#include <random>

#include "core/error.h"
#include "diagnosis/data/data_diagnosis.h"
#include "diagnosis/data/data_hypotheses.h"
#include "diagnosis/judge/diagnosis.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;
using Eigen::Index;

/// Two temperatures over three days, a displacement that follows both by elements of 2 h and 20 min.
/// @param extra  of the time in hours, um
template <class Extra>
compensation::Measurement record(const Extra& extra, double days = 3.0, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  compensation::Measurement m;
  m.folder = "three_days";
  const auto add = [&](const char* id, compensation::ChannelKind kind, const char* unit, double uncertainty) {
    compensation::MeasuredChannel c;
    c.id = id;
    c.kind = kind;
    c.unit = unit;
    c.uncertainty = uncertainty;
    c.column = std::ssize(m.channels) + 1;
    m.channels.push_back(c);
  };
  add("T_hall", compensation::ChannelKind::temperature, "degC", 0.02);
  add("T_frame", compensation::ChannelKind::temperature, "degC", 0.02);
  add("z", compensation::ChannelKind::displacement, "um", 0.1);
  m.data.columns = {"time_s", "T_hall", "T_frame", "z"};
  const auto n = static_cast<Index>(days * 288.0);
  m.data.values.resize(n, 4);
  double slow = 0, fast = 0, walk = 0;
  for (Index i = 0; i < n; ++i) {
    const double hour = i / 12.0;
    const double hall =
        1.5 * std::sin(2 * std::numbers::pi * hour / 24) + 0.7 * std::sin(hour) + 0.4 * std::sin(2.7 * hour + 1);
    walk += 0.04 * normal(random) - 0.01 * walk;
    const double frame = walk + 0.3 * hall;
    slow += (hall - slow) * (1 - std::exp(-300.0 / 7200.0));
    fast += (frame - fast) * (1 - std::exp(-300.0 / 1200.0));
    m.data.values.row(i) << 300.0 * i, 20 + hall + 0.02 * normal(random), 20 + frame + 0.02 * normal(random),
        6.0 * slow - 4.0 * fast + extra(hour) + 0.1 * normal(random);
  }
  return m;
}

diagnosis::Diagnosis run(const compensation::Measurement& m) { return diagnosis::diagnose_data(m, {}); }

std::string listed(const diagnosis::Diagnosis& d) {
  std::string text = diagnosis::name_of(d.verdict) + ": " + d.sentence + "\n";
  for (const auto& r : d.ranking)
    text += "  " + name_of(r.parameter.kind) + " " + r.parameter.where + " " + std::to_string(r.probability) + "\n";
  for (const auto& note : d.notes) text += "  " + note + "\n";
  return text;
}

TEST(LagModel, FindsWhatAStepOfEachInputDoes) {
  const diagnosis::DataRecord data = diagnosis::data_record(record([](double) { return 0.0; }), 600);
  std::vector<Index> rows;
  for (Index i = 0; i < data.time.size(); ++i) rows.push_back(i);
  const diagnosis::LagModel model = diagnosis::fit_lag_model(data, 0, rows);
  for (const double hours : {1.0, 4.0, 24.0}) {
    EXPECT_NEAR(model.step_response(0, 3600 * hours), 6.0 * (1.0 - std::exp(-hours / 2.0)), 0.5) << hours;
    EXPECT_NEAR(model.step_response(1, 3600 * hours), -4.0 * (1.0 - std::exp(-hours * 3.0)), 0.7) << hours;
  }
}

TEST(DataRecord, AGapInATemperatureIsAStraightLine) {
  auto m = record([](double) { return 0.0; });
  for (Index i = 0; i < m.data.rows(); ++i) {
    m.data.values(i, 1) = 20.0 + 0.01 * i;
    if (i % 24 != 0 && i + 1 != m.data.rows()) m.data.values(i, 1) = std::nan("");
  }
  const diagnosis::DataRecord data = diagnosis::data_record(m, 600);
  for (Index i = 0; i < data.time.size(); ++i)
    EXPECT_NEAR(data.inputs(i, 0), 20.0 + 0.01 * data.time[i] / 300.0, 0.02) << i;
}

TEST(DataDiagnosis, DaysThatFollowTheFirstAreNoDiscrepancy) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const diagnosis::Diagnosis d = run(record([](double) { return 0.0; }, 3.0, seed));
    EXPECT_EQ(d.verdict, diagnosis::Verdict::no_discrepancy) << seed << "\n" << listed(d);
    EXPECT_TRUE(d.causes.empty());
  }
}

TEST(DataDiagnosis, ADriftThatNoSensorFollowsIsNamedAndHolds) {
  const diagnosis::Diagnosis d = run(record([](double hour) { return hour < 20 ? 0.0 : 0.4 * (hour - 20); }));
  ASSERT_EQ(d.verdict, diagnosis::Verdict::explained) << listed(d);
  ASSERT_EQ(d.causes.size(), 1u);
  EXPECT_EQ(d.causes[0].parameter.kind, Kind::probe_drift);
  EXPECT_EQ(d.causes[0].parameter.where, "z");
  EXPECT_GT(d.ci95_low_percent, 0.0);
  EXPECT_LT(d.heldout_rms_after_um, d.heldout_rms_before_um);
}

TEST(DataDiagnosis, ASlowDriftIsNeverCalledNoDiscrepancy) {
  for (const double rate : {0.1, 0.25, -0.25, 1.0, -3.0}) {
    const diagnosis::Diagnosis d = run(record([&](double hour) { return hour < 24 ? 0.0 : rate * (hour - 24); }));
    ASSERT_EQ(d.verdict, diagnosis::Verdict::explained) << rate << "\n" << listed(d);
    ASSERT_EQ(d.causes.size(), 1u) << rate;
    EXPECT_EQ(d.causes[0].parameter.kind, Kind::probe_drift);
    EXPECT_NEAR(d.causes[0].value, rate, 0.15 * std::abs(rate) + 0.02);
  }
}

/// Slope and start lie between those of the grid. A start that is one of few makes a slope wrong by many deviations.
TEST(DataDiagnosis, ADriftLiesWithinItsUncertaintyWhereverItBegins) {
  double square = 0.0;
  int drifts = 0, far = 0;
  for (const double begins : {7.3, 14.9, 22.4, 29.7}) {
    for (const double rate : {0.5, -2.0}) {
      for (std::uint64_t seed = 31; seed <= 34; ++seed) {
        const diagnosis::Diagnosis d =
            run(record([&](double hour) { return rate * std::max(0.0, hour - begins); }, 3.0, seed));
        for (const auto& row : d.ranking) {
          if (row.parameter.kind != Kind::probe_drift) continue;
          const double off = (row.value - rate) / row.std;
          far += std::abs(off) > 4.0;
          square += off * off;
          ++drifts;
        }
      }
    }
  }
  ASSERT_EQ(drifts, 32);
  std::printf("RMS %.2f deviations, %d of %d beyond 4\n", std::sqrt(square / drifts), far, drifts);
  EXPECT_LT(std::sqrt(square / drifts), 2.0);
  EXPECT_LE(far, 1);
}

/// Two displacements, of which one drifts.
TEST(DataDiagnosis, EveryChannelHasProbabilitiesOfItsOwn) {
  auto m = record([](double) { return 0.0; });
  m.channels.push_back(m.channels[2]);
  m.channels[3].id = "y";
  m.channels[3].column = 4;
  m.data.columns.push_back("y");
  m.data.values.conservativeResize(Eigen::NoChange, 5);
  // The same temperatures, so the same clean part: only the drift comes on top.
  for (Index i = 0; i < m.data.rows(); ++i) {
    const double hour = i / 12.0;
    m.data.values(i, 4) = m.data.values(i, 3) + (hour < 20 ? 0.0 : 0.4 * (hour - 20));
  }
  const diagnosis::Diagnosis d = run(m);
  std::map<std::string, double> sums;
  for (const auto& row : d.ranking) sums[row.parameter.where] += row.probability;
  ASSERT_EQ(sums.size(), 2u) << listed(d);
  EXPECT_NEAR(sums["z"], 1.0, 1e-9);
  EXPECT_NEAR(sums["y"], 1.0, 1e-9);
  EXPECT_EQ(d.ranking.front().parameter.where, "y") << "the channel with a discrepancy comes first\n" << listed(d);
  EXPECT_EQ(d.verdict, diagnosis::Verdict::explained) << listed(d);
  ASSERT_EQ(d.causes.size(), 1u);
  EXPECT_EQ(d.causes[0].parameter.where, "y");
}

/// Of a record without a discrepancy: probabilities are prior times evidence.
TEST(DataDiagnosis, LogEvidenceIsAgainstNone) {
  const diagnosis::Diagnosis d = run(record([](double) { return 0.0; }));
  ASSERT_EQ(d.verdict, diagnosis::Verdict::no_discrepancy) << listed(d);
  const auto row = [&](Kind kind) {
    return *std::find_if(d.ranking.begin(), d.ranking.end(), [&](const auto& r) { return r.parameter.kind == kind; });
  };
  const auto none = row(Kind::none), unknown = row(Kind::unknown), drift = row(Kind::probe_drift);
  EXPECT_EQ(none.log_evidence, 0.0);
  EXPECT_NE(unknown.log_evidence, 0.0);
  const double causes = static_cast<double>(d.ranking.size()) - 2.0;
  EXPECT_NEAR(std::log(unknown.probability / none.probability),
              std::log(diagnosis::prior_unknown / diagnosis::prior_none) + unknown.log_evidence, 1e-6);
  EXPECT_NEAR(std::log(drift.probability / none.probability),
              std::log(diagnosis::prior_cause / causes / diagnosis::prior_none) + drift.log_evidence, 1e-6);
}

/// It drifts for two parts and stands where it began in the last.
TEST(DataDiagnosis, ALikelyCauseThatTheLastPartRefusesIsSaid) {
  const diagnosis::Diagnosis d =
      run(record([](double hour) { return hour < 20 || hour > 48 ? 0.0 : 0.4 * (hour - 20); }));
  EXPECT_EQ(d.verdict, diagnosis::Verdict::unexplained) << listed(d);
  EXPECT_NE(d.sentence.find("before the last part and does not hold there"), std::string::npos) << d.sentence;
}

/// Two displacements drift, a third swings as nothing does.
TEST(DataDiagnosis, SeveralCausesHoldInThePlural) {
  auto m = record([](double) { return 0.0; });
  const Index n = m.data.rows();
  m.data.values.conservativeResize(Eigen::NoChange, 6);
  for (const auto& [id, column] : {std::pair{"y", 4}, {"x", 5}}) {
    m.channels.push_back(m.channels[2]);
    m.channels.back().id = id;
    m.channels.back().column = column;
    m.data.columns.emplace_back(id);
    m.data.values.col(column) = m.data.values.col(3);
  }
  for (Index i = 0; i < n; ++i) {
    const double hour = i / 12.0;
    if (hour >= 20) m.data.values.row(i).segment(4, 2).array() += 0.4 * (hour - 20);
    if (hour >= 24) m.data.values(i, 3) += 5.0 * std::sin(0.011 * hour * hour);
  }
  const diagnosis::Diagnosis d = run(m);
  ASSERT_EQ(d.verdict, diagnosis::Verdict::unexplained) << listed(d);
  ASSERT_EQ(d.causes.size(), 2U) << listed(d);
  EXPECT_NE(d.sentence.find("only probe_drift of y, probe_drift of x hold in the last part"), std::string::npos)
      << d.sentence;
}

TEST(DataDiagnosis, TwoElementsOnOneInputAreNoDiscrepancy) {
  auto m = record([](double) { return 0.0; });
  double slow = 0;
  for (Index i = 0; i < m.data.rows(); ++i) {
    slow += (m.data.values(i, 2) - 20.0 - slow) * (1 - std::exp(-300.0 / 25000.0));
    m.data.values(i, 3) += 12.0 * slow;
  }
  const diagnosis::Diagnosis d = run(m);
  EXPECT_EQ(d.verdict, diagnosis::Verdict::no_discrepancy) << listed(d);
  for (const auto& cause : d.ranking) {
    if (cause.parameter.kind == Kind::none) {
      EXPECT_LT(cause.probability, 1.0) << "a prior that nothing moved is not certain";
    }
  }
}

TEST(DataDiagnosis, ASwingThatNothingFollowsIsUnexplained) {
  const diagnosis::Diagnosis d =
      run(record([](double hour) { return hour < 24 ? 0.0 : 5.0 * std::sin(0.011 * hour * hour); }));
  EXPECT_EQ(d.verdict, diagnosis::Verdict::unexplained) << listed(d);
  EXPECT_TRUE(d.causes.empty());
  EXPECT_NEAR(d.reduction_percent, 0.0, 1e-9);
}

TEST(DataDiagnosis, TheLastDayIsNeverFitted) {
  auto m = record([](double hour) { return 0.3 * hour; });
  const diagnosis::Diagnosis d = run(m);
  for (Index i = 0; i < m.data.rows(); ++i)
    if (m.data.values(i, 0) >= d.heldout_from_s) m.data.values(i, 3) = 50.0 * ((i % 3) - 1);
  const diagnosis::Diagnosis spoilt = run(m);
  for (const auto& r : d.ranking) {
    for (const auto& s : spoilt.ranking) {
      if (r.parameter.kind == s.parameter.kind && r.parameter.kind == Kind::probe_drift) {
        EXPECT_NEAR(r.value, s.value, 1e-9);
      }
    }
  }
  EXPECT_NE(spoilt.verdict, diagnosis::Verdict::explained) << listed(spoilt);
}

TEST(DataDiagnosis, RecordsThatSayTooLittleAreRefused) {
  auto still = record([](double) { return 0.0; });
  still.data.values.col(1).setConstant(20.0);
  still.data.values.col(2).setConstant(20.0);
  EXPECT_THROW(run(still), core::InputError);
  EXPECT_THROW(run(record([](double) { return 0.0; }, 0.1)), core::InputError);
  auto lost = record([](double) { return 0.0; });
  for (Index i = 0; i < lost.data.rows(); ++i)
    if (lost.data.values(i, 0) >= 86400.0) lost.data.values(i, 3) = std::nan("");
  EXPECT_THROW(run(lost), core::InputError);
  auto blind = record([](double) { return 0.0; });
  blind.channels.pop_back();
  EXPECT_THROW(run(blind), core::InputError);
}

TEST(DataDiagnosis, GapsDoNotMatter) {
  auto m = record([](double hour) { return hour < 20 ? 0.0 : 0.4 * (hour - 20); });
  std::mt19937_64 random(3);
  for (Index i = 1; i < m.data.rows(); ++i) {
    for (Index c = 1; c < 4; ++c)
      if (random() % 10 < 3) m.data.values(i, c) = std::nan("");
  }
  const diagnosis::Diagnosis d = run(m);
  ASSERT_EQ(d.causes.size(), 1u) << listed(d);
  EXPECT_EQ(d.causes[0].parameter.kind, Kind::probe_drift);
}

/// The drift of a real machine: whatever is said has to hold on its last day.
TEST(DataDiagnosis, OfARealDriftIsHonest) {
  const char* given = std::getenv("THERMOTWIN_DATA");
  const std::filesystem::path folder =
      std::filesystem::path(given ? given : THERMOTWIN_SOURCE_DIR "/../shared/data") / "measured_drift";
  if (!std::filesystem::exists(folder / "data.csv")) GTEST_SKIP() << folder / "data.csv";
  const diagnosis::Diagnosis d = run(compensation::read_measurement(folder));
  EXPECT_NE(d.verdict, diagnosis::Verdict::no_discrepancy) << listed(d);
  if (d.causes.empty()) {
    EXPECT_EQ(d.heldout_rms_after_um, d.heldout_rms_before_um);
  } else {
    EXPECT_GT(d.ci95_low_percent, 0.0) << listed(d);
  }
  EXPECT_FALSE(d.notes.empty());
}

}  // namespace
