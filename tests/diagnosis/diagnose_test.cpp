// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/diagnose.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "core/error.h"
#include "core/file.h"
#include "core/thread_pool.h"
#include "diagnosis/hypothesis_fit.h"
#include "diagnosis/judgement.h"
#include "diagnosis/report.h"
#include "diagnosis/verdict.h"
#include "diagnosis/words.h"
#include "lumped_machine.h"
#include "reduction/model_file.h"

namespace {

using namespace thermotwin;
using diagnosis::Diagnosis;
using lumped::find;

const reduction::ReducedModel& coarse_model() {
  static const reduction::ReducedModel model = lumped::model(lumped::machine(), 9);
  return model;
}

Diagnosis run(const compensation::Measurement& measurement) {
  diagnosis::DiagnoseOptions how;
  how.temperature_error_percent = 3;  // 27 nodes
  return diagnosis::diagnose(coarse_model(), measurement, how);
}

std::string listed(const Diagnosis& d) {
  std::string text = d.verdict + ": " + d.sentence + "\n";
  for (std::size_t i = 0; i < std::min<std::size_t>(6, d.ranking.size()); ++i) {
    const auto& r = d.ranking[i];
    text += "  " + r.parameter.kind + " " + r.parameter.where + " p " + std::to_string(r.probability) +
            " log " + std::to_string(r.log_evidence) + " value " + std::to_string(r.value) + " +- " +
            std::to_string(r.std) + "\n";
  }
  return text;
}

/// The truth is named, or among those that share.
void expect_found(const Diagnosis& d, const diagnosis::Parameter& truth, double value, double tolerance) {
  SCOPED_TRACE(listed(d));
  ASSERT_TRUE(d.verdict == "explained" || d.verdict == "ambiguous");
  const auto& set = d.verdict == "explained" ? d.causes : d.ambiguous_set;
  const auto at = std::find_if(set.begin(), set.end(), [&](const diagnosis::RankedCause& c) {
    return c.parameter.kind == truth.kind && c.parameter.where == truth.where;
  });
  ASSERT_NE(at, set.end());
  if (d.verdict == "explained") {
    EXPECT_EQ(d.causes.size(), 1u);
    EXPECT_EQ(d.ranking.front().parameter.where, truth.where);
    EXPECT_NEAR(at->value, value, tolerance);
    // The fault comes on top of a perturbed nominal value, which no diagnosis can take apart.
    EXPECT_NEAR(at->value, value, 4 * std::hypot(at->std, value * truth.nominal_std));
  }
}

TEST(Diagnose, a_clean_machine_has_no_discrepancy) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Diagnosis d = run(lumped::measure({}, {.seed = seed}));
    EXPECT_EQ(d.verdict, "no_discrepancy") << "seed " << seed << "\n" << listed(d);
    EXPECT_TRUE(d.causes.empty());
    EXPECT_TRUE(d.extended_machine_text.empty());
  }
}

TEST(Diagnose, nominal_uncertainty_is_no_discrepancy) {
  int wrong = 0;
  for (std::uint64_t seed = 101; seed <= 110; ++seed) {
    const Diagnosis d = run(lumped::measure({}, {.seed = seed, .spread = 1.0}));
    if (d.verdict != "no_discrepancy") {
      ++wrong;
      std::cout << "seed " << seed << "\n" << listed(d);
    }
  }
  // Ten parameters drawn ten times: one beyond two and a half deviations may be told of.
  EXPECT_LE(wrong, 1);
}

struct Fault {
  const char *kind, *where;
  double value, tolerance;
};
void PrintTo(const Fault& fault, std::ostream* out) {
  *out << fault.kind << " of " << fault.where << " " << fault.value;
}

class DiagnoseFault : public ::testing::TestWithParam<Fault> {};

TEST_P(DiagnoseFault, is_found) {
  const Fault& fault = GetParam();
  const diagnosis::Parameter truth = find(fault.kind, fault.where);
  for (const std::uint64_t seed : {21, 22}) {
    const Diagnosis d = run(lumped::measure({{truth, fault.value}}, {.seed = seed, .spread = 0.7}));
    expect_found(d, truth, fault.value, fault.tolerance);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, DiagnoseFault,
                         ::testing::Values(Fault{"source_power", "motor", 1.6, 0.2},
                                           Fault{"source_power", "guide_friction", 2.0, 0.3},
                                           Fault{"film_coefficient", "column.film", 2.2, 0.5},
                                           Fault{"film_coefficient", "head.film", 0.3, 0.3},
                                           Fault{"ambient_offset", "air", 1.5, 0.4},
                                           Fault{"foundation_temperature", "foundation", -2.5, 0.8},
                                           Fault{"contact_conductance", "Z_guide", 0.25, 0.15},
                                           Fault{"sensor_offset", "T4_reading", 0.9, 0.15},
                                           Fault{"sensor_drift", "T2_reading", 0.06, 0.015},
                                           Fault{"sensor_lag", "T5_reading", 1500, 400},
                                           Fault{"sensor_detached", "T4_reading", 0.6, 0.15},
                                           Fault{"probe_drift", "dz_low", 0.8, 0.25},
                                           Fault{"clock_shift", "displacement", 1500, 300},
                                           Fault{"clock_shift", "dz_high", 2400, 400},
                                           Fault{"source_speed_law", "motor", 0.9, 0.4},
                                           Fault{"standstill_power", "motor", 60, 15},
                                           Fault{"radiation_load", "head.film", 90, 30},
                                           Fault{"coolant_coupling", "main.jacket", 0.3, 0.2}),
                         [](const auto& test) {
                           std::string name = std::string(test.param.kind) + "_" + test.param.where;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return c == '.'; }, '_');
                           return name;
                         });

TEST(Diagnose, a_sensor_is_told_from_physics) {
  const auto truth = find("sensor_offset", "T5_reading");
  const Diagnosis d = run(lumped::measure({{truth, -1.2}}, {.seed = 31, .spread = 0.7}));
  expect_found(d, truth, -1.2, 0.15);
  ASSERT_EQ(d.verdict, "explained") << listed(d);
  // It says nothing about the displacements, yet its own readings come right.
  EXPECT_NEAR(d.reduction_percent, 0.0, 1e-9);
  const auto own = std::find_if(d.residuals.begin(), d.residuals.end(),
                                [](const auto& r) { return r.id == "T5_reading"; });
  EXPECT_LT(own->rms_after, 0.3 * own->rms_before);
  EXPECT_FALSE(d.extended_machine_text.empty());
}

TEST(Diagnose, a_probe_that_drifts_gets_a_reading_where_its_own_gain_is_certain) {
  const auto truth = find("probe_drift", "dz_low");
  const Diagnosis d = run(lumped::measure({{truth, 0.8}}, {.seed = 31, .spread = 0.7}));
  ASSERT_EQ(d.verdict, "explained") << listed(d);
  EXPECT_NE(d.extended_machine_text.find("[[reading]]"), std::string::npos);
}

TEST(Diagnose, two_causes_are_both_named) {
  const auto a = find("source_power", "motor"), b = find("sensor_offset", "T2_reading");
  const Diagnosis d = run(lumped::measure({{a, 1.7}, {b, 0.8}}, {.seed = 41, .spread = 0.5}));
  SCOPED_TRACE(listed(d));
  ASSERT_EQ(d.verdict, "explained");
  std::set<std::string> named;
  for (const auto& cause : d.causes) named.insert(cause.parameter.where);
  EXPECT_EQ(named, (std::set<std::string>{"motor", "T2_reading"}));
  const mesh::Machine extended = mesh::parse_machine(d.extended_machine_text, lumped::machine().path);
  EXPECT_NEAR(extended.sources[0].scale.value, 1.7, 0.2);
  EXPECT_NEAR(extended.sensors[1].offset, 0.8, 0.15);
}

TEST(Diagnose, what_no_parameter_describes_is_not_called_explained_well) {
  // A gauge that wanders by itself and a sensor that drifts.
  compensation::Measurement m = lumped::measure({}, {.seed = 51});
  for (Eigen::Index i = 0; i < m.data.rows(); ++i) {
    const double hour = m.data.values(i, 0) / 3600.0;
    m.data.values(i, m.channels[8].column) += 9.0 * std::sin(1.1 * hour);
    m.data.values(i, m.channels[3].column) += 1.2 * std::sin(0.9 * hour + 1.0);
    m.data.values(i, m.channels[5].column) += 0.9 * std::cos(1.3 * hour);
  }
  const Diagnosis d = run(m);
  EXPECT_EQ(d.verdict, "unexplained") << listed(d);
  EXPECT_TRUE(d.extended_machine_text.empty());
}

TEST(Diagnose, a_loose_sensor_in_steady_air_is_not_something_unknown) {
  // Where the air stays as it is, its reading is in proportion to the model's response.
  for (const double share : {0.3, 0.6})
    for (const char* sensor : {"T4_reading", "T5_reading"}) {
      const auto loose = find("sensor_detached", sensor);
      const Diagnosis d = run(lumped::measure({{loose, share}}, {.seed = 47, .spread = 0.5, .air_swing = 0}));
      SCOPED_TRACE(listed(d));
      EXPECT_EQ(d.verdict, "explained") << share;
      ASSERT_FALSE(d.causes.empty());
      EXPECT_EQ(d.causes[0].parameter.kind, "sensor_detached");
      EXPECT_EQ(d.causes[0].parameter.where, sensor);
      EXPECT_NEAR(d.causes[0].value, share, 2.5 * d.causes[0].std);
      EXPECT_LT(d.causes[0].std, 0.06);
    }
}

TEST(Diagnose, a_lag_of_two_elements_is_one_lag) {
  const auto lag = find("sensor_lag", "T5_reading");
  compensation::Measurement m = lumped::measure({}, {.seed = 45, .spread = 0.5, .noise_K = 0});
  for (int element = 0; element < 2; ++element) lumped::spoil(m, lag, 1500.0);
  std::mt19937 random(46);
  std::normal_distribution<double> noise(0.0, 0.05);
  for (auto& channel : m.channels) {
    if (channel.kind != compensation::ChannelKind::temperature) continue;
    channel.uncertainty = 0.05;
    for (double& value : m.data.values.col(channel.column)) value += noise(random);
  }
  const Diagnosis d = run(m);
  SCOPED_TRACE(listed(d));
  ASSERT_EQ(d.verdict, "explained");
  ASSERT_EQ(d.causes.size(), 1U);
  EXPECT_EQ(d.causes[0].parameter.kind, "sensor_lag");
  EXPECT_NEAR(d.causes[0].value, 3000, 2.5 * d.causes[0].std) << "of both";
  EXPECT_LT(d.causes[0].std, 300);
}

TEST(Diagnose, a_lag_beside_late_clocks_is_found_far_from_nominal) {
  // Neither shows on the tangent at nominal, and of the two the lag only beside the clocks.
  const auto clocks = find("clock_shift", "temperature"), lag = find("sensor_lag", "T5_reading");
  const Diagnosis d = run(lumped::measure({{clocks, -3000.0}, {lag, 3000.0}}, {.seed = 43, .spread = 0.5}));
  SCOPED_TRACE(listed(d));
  ASSERT_EQ(d.verdict, "explained");
  ASSERT_EQ(d.causes.size(), 2u);
  for (const auto& cause : d.causes)
    if (cause.parameter.kind == "clock_shift") {
      EXPECT_EQ(cause.parameter.where, "temperature");
      EXPECT_NEAR(cause.value, -3000, 300);
    } else {
      EXPECT_EQ(cause.parameter.where, "T5_reading");
      EXPECT_NEAR(cause.value, 3000, 400);
    }
}

/// Half more heat than stated, and a sensor whose reading swings as no kind describes.
compensation::Measurement heat_and_a_swinging_sensor(double heat = 1.6) {
  compensation::Measurement m = lumped::measure({{find("source_power", "motor"), heat}}, {.seed = 61});
  for (Eigen::Index i = 0; i < m.data.rows(); ++i) m.data.values(i, m.channels[3].column) += 0.8 * std::sin(1.9 * m.data.values(i, 0) / 3600.0);
  return m;
}

TEST(Diagnose, a_cause_beside_something_unknown_is_named_with_the_rest_left_open) {
  const Diagnosis d = run(heat_and_a_swinging_sensor());
  SCOPED_TRACE(listed(d));
  ASSERT_EQ(d.verdict, "ambiguous");
  ASSERT_EQ(d.causes.size(), 1u);
  EXPECT_EQ(d.causes[0].parameter.where, "motor");
  EXPECT_NEAR(d.causes[0].value, 1.6, 0.25);
  ASSERT_EQ(d.ambiguous_set.size(), 1u);
  EXPECT_EQ(d.ambiguous_set[0].parameter.kind, "unknown");
  EXPECT_NE(d.sentence.find("something beside it that no kind describes"), std::string::npos) << d.sentence;
  EXPECT_TRUE(d.extended_machine_text.empty());
  EXPECT_TRUE(std::any_of(d.notes.begin(), d.notes.end(), [](const std::string& note) { return note.find("one channel alone: T4_reading") != std::string::npos; }));
}

/// A second parameter in what is decided, and the probabilities that both are needed and that something is unknown.
struct Second { double value = 1.0, probability = 0.0, log_evidence = 30.0, pair = 0.0, unknown = 0.0; };

/// What is decided about two parameters of stated deviation 0.1 and nominal value 1.
Diagnosis decided(double value, double probability, double log_evidence, const Second& second = {}) {
  diagnosis::Problem problem;
  diagnosis::SearchResult found;
  found.hypotheses.resize(4);
  for (const int i : {0, 1}) {
    diagnosis::Parameter p = i == 0 ? find("source_power", "motor") : find("film_coefficient", "column.film");
    p.nominal_std = 0.1;
    problem.parameters.push_back(p);
    diagnosis::Hypothesis& h = found.hypotheses[static_cast<std::size_t>(i) + 1];
    h.members = {i};
    h.value = Eigen::VectorXd::Constant(1, i == 0 ? value : second.value);
    h.std = Eigen::VectorXd::Constant(1, 0.02);
    h.log_evidence = i == 0 ? log_evidence : second.log_evidence;
  }
  diagnosis::Hypothesis& both = found.hypotheses.back();
  both.members = {0, 1};
  both.value.resize(2);
  both.value << value, second.value;
  both.std = Eigen::VectorXd::Constant(2, 0.02);
  both.probability = second.pair;
  problem.nominal = Eigen::VectorXd::Ones(2);
  problem.columns.resize(0, 2);
  found.marginal.resize(2);
  found.marginal << probability, second.probability;
  found.probability_none = 1e-4;
  found.probability_unknown = second.unknown;
  Diagnosis d;
  diagnosis::decide(problem, found, d);
  d.sentence = diagnosis::sentence_of(d);
  return d;
}

TEST(Verdict, a_sure_cause_within_its_stated_uncertainty_is_ambiguous_if_it_is_strong) {
  const Diagnosis strong = decided(1.2, 0.98, 30.0);
  EXPECT_EQ(strong.verdict, "ambiguous");
  ASSERT_EQ(strong.causes.size(), 1U);
  ASSERT_EQ(strong.ambiguous_set.size(), 1U);
  EXPECT_EQ(strong.ambiguous_set[0].parameter.kind, "unknown");
  EXPECT_NE(strong.sentence.find("is no further off than is stated of it"), std::string::npos) << strong.sentence;
  EXPECT_EQ(decided(1.2, 0.98, 5.0).verdict, "no_discrepancy");
  EXPECT_EQ(decided(1.2, 0.85, 30.0).verdict, "no_discrepancy");
  EXPECT_EQ(decided(1.5, 0.98, 30.0).verdict, "explained");
  // A second one that is sure and further off than stated is not lost behind it.
  const Diagnosis two = decided(1.2, 0.99, 30.0, {.value = 1.6, .probability = 0.95});
  EXPECT_EQ(two.verdict, "ambiguous");
  EXPECT_EQ(two.causes.size(), 2U);
}

TEST(Verdict, of_two_that_are_sure_the_stronger_one_leads) {
  // An uncertain value that is seen better beside a large cause does not make that cause no discrepancy.
  const Diagnosis d = decided(1.6, 0.95, 300.0, {.value = 1.2, .probability = 0.99, .log_evidence = 3.0, .pair = 0.99});
  EXPECT_EQ(d.verdict, "explained");
  ASSERT_EQ(d.causes.size(), 1U);
  EXPECT_EQ(d.causes[0].parameter.where, "motor");
  EXPECT_EQ(d.ranking.front().parameter.where, "motor");
}

TEST(Verdict, a_cause_and_something_unknown_share_where_neither_is_sure) {
  const Diagnosis d = decided(1.6, 0.39, 95.0, {.unknown = 0.61});
  EXPECT_EQ(d.verdict, "ambiguous");
  EXPECT_TRUE(d.causes.empty());
  ASSERT_EQ(d.ambiguous_set.size(), 2U);
  EXPECT_EQ(d.ambiguous_set[0].parameter.kind, "unknown");
  EXPECT_EQ(d.ambiguous_set[1].parameter.where, "motor");
  EXPECT_NE(d.sentence.find("something that no kind describes, probability 0.61; source_power of motor"), std::string::npos) << d.sentence;
  ASSERT_EQ(diagnosis::marked_causes(d).size(), 1U);
  EXPECT_EQ(decided(1.6, 0.06, 95.0, {.unknown = 0.94}).verdict, "ambiguous");
  EXPECT_EQ(decided(1.6, 0.06, 95.0, {.unknown = 0.96}).verdict, "unexplained");
  EXPECT_EQ(decided(1.6, 0.04, 95.0, {.unknown = 0.85}).verdict, "unexplained");
  EXPECT_EQ(decided(1.2, 0.39, 95.0, {.unknown = 0.61}).verdict, "unexplained");
  // Less probable than a cause, it is in the set too.
  const Diagnosis cause = decided(1.6, 0.6, 95.0, {.unknown = 0.4});
  EXPECT_EQ(cause.verdict, "ambiguous");
  ASSERT_EQ(cause.ambiguous_set.size(), 2U);
  EXPECT_EQ(cause.ambiguous_set[1].parameter.kind, "unknown");
}

TEST(Words, a_change_of_nothing_has_no_minus) {
  EXPECT_EQ(diagnosis::percent_text(-0.03), "0");
  EXPECT_EQ(diagnosis::percent_text(-0.04, 1), "0.0");
  EXPECT_EQ(diagnosis::percent_text(-0.06, 1), "-0.1");
  EXPECT_EQ(diagnosis::percent_text(12.6), "13");
}

/// Each column plus a share of another one.
compensation::Measurement mixed(compensation::Measurement m, const std::string& into, const std::string& from, double share) {
  const auto column = [&](const std::string& id) {
    return std::find_if(m.channels.begin(), m.channels.end(), [&](const auto& c) { return c.id == id; })->column;
  };
  const Eigen::VectorXd added = share * (m.data.values.col(column(from)).array() - (from.starts_with("T") ? 20.0 : 0.0));
  m.data.values.col(column(into)) += added;
  return m;
}

TEST(Diagnose, a_mesh_that_turns_the_motion_a_little_is_no_discrepancy) {
  // dz moves several times as far as dx: what a mesh is off by is a share of the whole motion, not of dx alone.
  int alarms = 0, seen = 0;
  for (const std::uint64_t seed : {301U, 302U, 303U, 304U}) {
    const compensation::Measurement clean = lumped::measure({}, {.seed = seed});
    for (const double sign : {-1.0, 1.0}) {
      const Diagnosis little = run(mixed(mixed(clean, "dx_low", "dz_low", 0.1 * sign), "dx_high", "dz_high", 0.1 * sign));
      if (little.verdict != "no_discrepancy") ++alarms, std::cout << listed(little);
    }
    seen += run(mixed(mixed(clean, "dx_low", "dz_low", 0.3), "dx_high", "dz_high", 0.3)).verdict != "no_discrepancy";
  }
  EXPECT_EQ(alarms, 0);
  EXPECT_GE(seen, 3);
}

TEST(Diagnose, the_stated_error_of_temperatures_is_what_they_may_be_off_by) {
  const compensation::Measurement off = mixed(lumped::measure({}, {.seed = 311}), "T5_reading", "T5_reading", 0.25);
  const auto verdict = [&](double percent) {
    diagnosis::DiagnoseOptions how;
    how.temperature_error_percent = percent;
    return diagnosis::diagnose(coarse_model(), off, how).verdict;
  };
  EXPECT_EQ(verdict(40.0), "no_discrepancy");
  EXPECT_NE(verdict(1.0), "no_discrepancy");
}

TEST(Diagnose, held_out_time_is_never_fitted) {
  const auto truth = find("source_power", "motor");
  compensation::Measurement m = lumped::measure({{truth, 1.6}}, {.seed = 61});
  const Diagnosis d = run(m);
  // Nonsense behind the split changes the judgement, not the estimate.
  for (Eigen::Index i = 0; i < m.data.rows(); ++i)
    if (m.data.values(i, 0) >= d.heldout_from_s)
      for (const auto& channel : m.channels)
        if (!channel.quantity.empty()) m.data.values(i, channel.column) = 100.0 * ((i % 3) - 1);
  const Diagnosis spoilt = run(m);
  ASSERT_EQ(d.causes.size(), 1u) << listed(d);
  ASSERT_EQ(spoilt.causes.size(), 1u) << listed(spoilt);
  EXPECT_NEAR(d.causes[0].value, spoilt.causes[0].value, 0.05 * d.causes[0].std);
  EXPECT_GT(d.ci95_low_percent, 30.0);
  EXPECT_FALSE(d.extended_machine_text.empty());
  EXPECT_LT(spoilt.ci95_low_percent, 5.0);
}

TEST(Diagnose, what_a_part_of_the_record_leaves_open_is_decided_by_more_of_it) {
  const auto truth = find("probe_drift", "dz_low");
  compensation::Measurement m = lumped::measure({{truth, 0.2}}, {.seed = 21, .spread = 0.7});
  const Diagnosis d = run(m);
  const auto says_so = [](const std::string& note) { return note.find("left the cause open") != std::string::npos; };
  EXPECT_EQ(std::count_if(d.notes.begin(), d.notes.end(), says_so), 1);
  const Eigen::VectorXd time = m.data.values.col(0);
  EXPECT_NEAR(d.heldout_from_s, 0.85 * time[time.size() - 1], 600.0) << "half of what was held out";
  ASSERT_EQ(d.causes.size(), 1u) << listed(d);
  EXPECT_EQ(d.causes[0].parameter.kind, "probe_drift");
  EXPECT_NEAR(d.causes[0].value, 0.2, 4 * d.causes[0].std);
  // Nonsense behind the later split changes the judgement, not the estimate.
  for (Eigen::Index i = 0; i < time.size(); ++i)
    if (time[i] >= d.heldout_from_s)
      for (const auto& channel : m.channels)
        if (!channel.quantity.empty()) m.data.values(i, channel.column) = 100.0 * ((i % 3) - 1);
  const Diagnosis spoilt = run(m);
  ASSERT_EQ(spoilt.ranking.size(), d.ranking.size());
  EXPECT_NEAR(spoilt.ranking.front().value, d.ranking.front().value, 0.05 * d.ranking.front().std);
  EXPECT_EQ(spoilt.heldout_from_s, d.heldout_from_s);

  // Gauges that stop before: the first look is all there is.
  compensation::Measurement early = lumped::measure({{truth, 0.2}}, {.seed = 21, .spread = 0.7});
  for (Eigen::Index i = 0; i < time.size(); ++i)
    if (time[i] >= 0.83 * time[time.size() - 1])
      for (const auto& channel : early.channels)
        if (!channel.quantity.empty()) early.data.values(i, channel.column) = std::nan("");
  const Diagnosis one_look = run(early);
  EXPECT_NEAR(one_look.heldout_from_s, 0.7 * time[time.size() - 1], 600.0);
  EXPECT_GT(one_look.heldout_rms_before_um, 0.0);

  const Diagnosis sure = run(lumped::measure({{find("source_power", "motor"), 1.6}}, {.seed = 21}));
  EXPECT_EQ(std::count_if(sure.notes.begin(), sure.notes.end(), says_so), 0);
  EXPECT_NEAR(sure.heldout_from_s, 0.7 * time[time.size() - 1], 600.0);
}

/// A record whose held-out displacements are those of another one.
compensation::Measurement contradicted(compensation::Measurement m, const compensation::Measurement& heldout) {
  const double split = run(m).heldout_from_s;
  for (Eigen::Index i = 0; i < m.data.rows(); ++i)
    if (m.data.values(i, 0) >= split)
      for (const auto& channel : m.channels)
        if (!channel.quantity.empty()) m.data.values(i, channel.column) = heldout.data.values(i, channel.column);
  return m;
}

TEST(Diagnose, a_cause_whose_displacements_others_had_cancelled_is_named_where_what_comes_is_as_foretold) {
  Diagnosis d;
  d.causes.emplace_back();
  d.heldout_rms_before_um = 1.0, d.heldout_rms_after_um = 2.0, d.ci95_low_percent = -120, d.ci95_high_percent = -80;
  EXPECT_EQ(diagnosis::heldout_objection(d, 0.4), "");
  EXPECT_NE(diagnosis::heldout_objection(d, 3.0), "");
  d.ci95_high_percent = 10;
  EXPECT_EQ(diagnosis::heldout_objection(d, 3.0), "");

  // What a hypothesis foretells of held-out time, where it is the truth and where the truth becomes another.
  const auto truth = find("source_power", "motor");
  const auto foretold = [&](const compensation::Measurement& m) {
    const mesh::Machine machine = lumped::machine();
    const reduction::ReducedModel model = lumped::model(machine, 9);
    const diagnosis::Observations seen = diagnosis::observe(m, machine, solver::Channels(machine), {});
    const diagnosis::Response response(model, seen);
    const diagnosis::Problem problem = diagnosis::make_problem(machine, m, seen, response, {});
    diagnosis::Hypothesis h;
    for (int i = 0; i < static_cast<int>(problem.parameters.size()); ++i)
      if (problem.parameters[static_cast<std::size_t>(i)].kind == truth.kind && problem.parameters[static_cast<std::size_t>(i)].where == truth.where) h.members = {i};
    h.value = Eigen::VectorXd::Constant(1, 1.6);
    diagnosis::linearise(h, problem, response, machine);
    return diagnosis::strain_of(problem, h);
  };
  const compensation::Measurement right = lumped::measure({{truth, 1.6}}, {.seed = 61});
  EXPECT_LT(foretold(right).heldout_chi_square, 1.3);
  EXPECT_LT(foretold(right).freedom, 2.0);
  const diagnosis::Strain wrong = foretold(contradicted(right, lumped::measure({{truth, 0.4}}, {.seed = 61})));
  EXPECT_GT(wrong.heldout_chi_square, 3.0);
  EXPECT_GT(wrong.freedom, 2.5);
}

TEST(Verdict, what_strains_an_explanation_leaves_it_open) {
  diagnosis::Problem problem;
  problem.parameters = {find("source_power", "motor"), find("contact_conductance", "foot")};
  const auto left_open = [&](double freedom, double other) {
    Diagnosis d;
    d.verdict = "explained";
    d.causes.emplace_back();
    d.causes.front().parameter = problem.parameters[0];
    d.causes.front().value = 1.5, d.causes.front().std = 0.05, d.causes.front().probability = 1;
    diagnosis::leave_open(problem, {}, {.freedom = freedom, .other = other, .which = 1}, d);
    EXPECT_EQ(d.verdict == "ambiguous", !d.strained.empty());
    EXPECT_EQ(d.verdict == "ambiguous", diagnosis::only_unknown_shares(d));
    if (d.verdict == "ambiguous") { EXPECT_NE(diagnosis::sentence_of(d).find(d.strained), std::string::npos); }
    return d.strained;
  };
  EXPECT_EQ(left_open(1.7, 3.1), "");
  EXPECT_NE(left_open(4.0, 1.0).find("4.0 times"), std::string::npos);
  EXPECT_NE(left_open(1.0, 4.2).find("contact_conductance of foot"), std::string::npos);
}

TEST(Diagnose, what_nobody_recorded_and_what_is_stuck_is_said_first) {
  compensation::Measurement m = lumped::measure({}, {.seed = 5});
  const auto says = [](const Diagnosis& d, const std::string& words) {
    return std::any_of(d.warnings.begin(), d.warnings.end(), [&](const std::string& w) { return w.find(words) != std::string::npos; });
  };
  const Diagnosis whole = run(m);
  EXPECT_FALSE(says(whole, "spindle.speed_rpm"));
  EXPECT_FALSE(says(whole, "stuck"));
  EXPECT_FALSE(says(whole, "home position"));
  std::erase_if(m.channels, [](const auto& c) { return c.input == "spindle.speed_rpm" || c.input == "air.T_C"; });
  for (auto& channel : m.channels) {
    if (channel.sensor == "T1") m.data.values.col(channel.column).setConstant(21.3);
    if (!channel.pose_text.empty()) channel.pose_text = channel.pose_text.substr(0, channel.pose_text.rfind(','));
  }
  const Diagnosis d = run(m);
  EXPECT_TRUE(says(d, "spindle.speed_rpm 0"));
  EXPECT_TRUE(says(d, "air.T_C 20"));
  EXPECT_TRUE(says(d, "stuck: T1"));
  const std::string page = diagnosis::report_html(d, lumped::machine(), {});
  EXPECT_LT(page.find("stuck: T1"), page.find("<h2>")) << "beside the verdict, before all else";
}

TEST(Diagnose, a_pose_that_leaves_an_axis_out_is_said) {
  mesh::Machine machine = lumped::machine();
  machine.axes.push_back(machine.axes.front());
  machine.axes.back().id = "Y";
  const compensation::Measurement m = lumped::measure({}, {.hours = 6});
  diagnosis::Problem problem;
  problem.observations = diagnosis::observe(m, lumped::machine(), solver::Channels(lumped::machine()), {});
  const auto said = [&] {
    const std::vector<std::string> warnings = diagnosis::warnings_of(machine, m, problem);
    return std::any_of(warnings.begin(), warnings.end(), [](const std::string& w) { return w.find("dz_low leaves out Y") != std::string::npos; });
  };
  EXPECT_TRUE(said());
  for (diagnosis::ObservedChannel& observed : problem.observations.channels) observed.channel.pose_text = " Z = 100 , Y = 5";
  EXPECT_FALSE(said());
}

TEST(Diagnose, what_held_out_time_contradicts_is_not_named) {
  const auto truth = find("source_power", "motor");
  const Diagnosis d = run(contradicted(lumped::measure({{truth, 1.6}}, {.seed = 61}), lumped::measure({{truth, 0.4}}, {.seed = 61})));
  EXPECT_EQ(d.verdict, "unexplained") << listed(d);
  EXPECT_TRUE(d.causes.empty() && d.extended_machine_text.empty());
  EXPECT_NEAR(d.heldout_rms_after_um, d.heldout_rms_before_um, 1e-9);
  EXPECT_TRUE(std::any_of(d.warnings.begin(), d.warnings.end(), [](const std::string& note) { return note.find("held-out time") != std::string::npos && note.find("not named") != std::string::npos; }));
}

TEST(Diagnose, nor_is_it_named_beside_something_unknown) {
  const Diagnosis d = run(contradicted(heat_and_a_swinging_sensor(), heat_and_a_swinging_sensor(0.4)));
  EXPECT_EQ(d.verdict, "unexplained") << listed(d);
  EXPECT_TRUE(d.causes.empty() && d.ambiguous_set.empty());
  EXPECT_NEAR(d.heldout_rms_after_um, d.heldout_rms_before_um, 1e-9);
}

TEST(Diagnose, gain_is_computed_from_before_and_after) {
  const Diagnosis d = run(lumped::measure({{find("source_power", "motor"), 1.6}}, {.seed = 62}));
  EXPECT_NEAR(d.reduction_percent, 100 * (1 - d.heldout_rms_after_um / d.heldout_rms_before_um), 1e-9);
  EXPECT_LE(d.ci95_low_percent, d.reduction_percent);
  EXPECT_GE(d.ci95_high_percent, d.reduction_percent);
}

TEST(Diagnose, probabilities_add_up) {
  const Diagnosis d = run(lumped::measure({{find("source_power", "pump"), 2.0}}, {.seed = 63}));
  std::set<std::string> kinds;
  for (const auto& r : d.ranking) {
    EXPECT_GE(r.probability, 0.0);
    EXPECT_LE(r.probability, 1.0 + 1e-12);
    kinds.insert(r.parameter.kind);
  }
  EXPECT_TRUE(kinds.count("none") && kinds.count("unknown"));
  for (std::size_t i = 1; i < d.ranking.size(); ++i)
    EXPECT_GE(d.ranking[i - 1].probability, d.ranking[i].probability);
}

TEST(Diagnose, is_the_same_for_any_threads) {
  const compensation::Measurement m =
      lumped::measure({{find("source_power", "motor"), 1.5}}, {.hours = 12, .seed = 64});
  core::set_thread_count(1);
  const std::string one = diagnosis::diagnosis_json(run(m));
  core::set_thread_count(4);
  const std::string four = diagnosis::diagnosis_json(run(m));
  core::set_thread_count(0);
  EXPECT_EQ(one, four);
}

TEST(Diagnose, bad_options_are_refused) {
  const compensation::Measurement m = lumped::measure({}, {.hours = 3});
  EXPECT_THROW(diagnosis::diagnose(coarse_model(), m, {.heldout_share = 1.0}), core::InputError);
  EXPECT_THROW(diagnosis::diagnose(coarse_model(), m, {.displacement_error_percent = 0}), core::InputError);
  EXPECT_THROW(diagnosis::diagnose(coarse_model(), m, {.temperature_error_percent = 0}), core::InputError);
  EXPECT_THROW(diagnosis::diagnose(coarse_model(), m, {.interval_s = -1}), core::InputError);
}

TEST(Diagnose, a_third_of_the_values_may_be_missing) {
  const auto truth = find("source_power", "motor");
  compensation::Measurement m = lumped::measure({{truth, 1.6}}, {.seed = 81});
  std::mt19937_64 random(5);
  for (Eigen::Index i = 1; i < m.data.rows(); ++i)
    for (const auto& channel : m.channels)
      if (random() % 10 < 3) m.data.values(i, channel.column) = std::nan("");
  const Diagnosis d = run(m);
  expect_found(d, truth, 1.6, 0.2);
}

bool says(const Diagnosis& d, const std::string& words) {
  return std::any_of(d.notes.begin(), d.notes.end(), [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

TEST(Diagnose, a_channel_without_data_is_named_and_not_missed) {
  compensation::Measurement m = lumped::measure({}, {.hours = 12, .seed = 82});
  m.data.values.col(m.channels[2].column).setConstant(std::nan(""));
  const Diagnosis d = run(m);
  EXPECT_TRUE(says(d, "Left out")) << listed(d);
  EXPECT_TRUE(says(d, m.channels[2].id));
  for (const auto& r : d.ranking) EXPECT_NE(r.parameter.where, m.channels[2].id);
}

TEST(Diagnose, what_nothing_excites_is_named) {
  // Nothing runs: what the spindle heats cannot be judged.
  compensation::Measurement m = lumped::measure({}, {.hours = 12, .seed = 83});
  for (const auto& channel : m.channels)
    if (channel.input.ends_with("_rpm") || channel.input.ends_with("_mm_min")) m.data.values.col(channel.column).setZero();
  const Diagnosis d = run(m);
  EXPECT_TRUE(says(d, "source_power of motor") && says(d, "source_speed_law of motor")) << listed(d);
  for (const auto& r : d.ranking) EXPECT_FALSE(r.parameter.kind == "source_power" && r.parameter.where == "motor");
}

TEST(Diagnose, a_short_record_says_so) {
  EXPECT_TRUE(says(run(lumped::measure({}, {.hours = 4, .seed = 84})), "slowest time constant"));
  EXPECT_FALSE(says(run(lumped::measure({}, {.hours = 60, .sample_s = 600, .seed = 84})), "slowest time constant"));
}

TEST(Diagnose, residuals_say_when_and_what_they_follow) {
  const Diagnosis d = run(lumped::measure({{find("source_power", "motor"), 1.8}}, {.seed = 85}));
  ASSERT_EQ(d.analysis.size(), d.residuals.size());
  const auto own = std::find_if(d.analysis.begin(), d.analysis.end(), [](const auto& a) { return a.id == "T5_reading"; });
  ASSERT_NE(own, d.analysis.end());
  EXPECT_GT(own->ratio, 2.0);
  EXPECT_EQ(own->follows, "spindle.speed_rpm");
  EXPECT_GT(own->correlation, 0.8);
  EXPECT_GT(own->peak, 0.0);
  EXPECT_GT(own->memory_s, 600.0);
}

class Folder {
 public:
  Folder()
      : path_(std::filesystem::temp_directory_path() /
              ("thermotwin_diagnosis_" + std::to_string(::getpid()))) {}
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

TEST(DiagnoseFiles, json_has_the_keys_of_the_contract) {
  const Diagnosis d = run(lumped::measure({{find("source_power", "motor"), 1.6}}, {.seed = 71}));
  const auto json = nlohmann::json::parse(diagnosis::diagnosis_json(d));
  const auto keys = [](const nlohmann::json& object) {
    std::set<std::string> result;
    for (const auto& item : object.items()) result.insert(item.key());
    return result;
  };
  EXPECT_EQ(keys(json), (std::set<std::string>{"verdict", "causes", "ranking", "ambiguous_set", "residual",
                                               "gain", "next_measurement", "extended_machine"}));
  ASSERT_EQ(json["causes"].size(), 1u);
  EXPECT_EQ(keys(json["causes"][0]), (std::set<std::string>{"kind", "where", "probability", "parameters"}));
  EXPECT_EQ(json["causes"][0]["kind"], "source_power");
  EXPECT_EQ(json["causes"][0]["where"], "motor");
  EXPECT_EQ(keys(json["causes"][0]["parameters"]["factor"]), (std::set<std::string>{"value", "std", "unit"}));
  EXPECT_EQ(keys(json["ranking"][0]),
            (std::set<std::string>{"kind", "where", "probability", "log_evidence"}));
  ASSERT_EQ(json["residual"]["per_channel"].size(), 10u);
  EXPECT_EQ(keys(json["residual"]["per_channel"][0]),
            (std::set<std::string>{"id", "rms_before", "rms_after", "unit", "p_value_white"}));
  EXPECT_EQ(keys(json["gain"]), (std::set<std::string>{"heldout_rms_before_um", "heldout_rms_after_um",
                                                       "reduction_percent", "ci95_percent"}));
  EXPECT_EQ(json["gain"]["ci95_percent"].size(), 2u);
  EXPECT_EQ(keys(json["next_measurement"]), (std::set<std::string>{"load", "channel", "why"}));
  EXPECT_EQ(json["extended_machine"], "extended/machine.toml");
}

TEST(DiagnoseFiles, all_files_are_written_and_agree) {
  const Folder out;
  const Diagnosis d = run(lumped::measure({{find("film_coefficient", "column.film"), 2.4}}, {.seed = 72}));
  ASSERT_EQ(d.verdict, "explained") << listed(d);
  diagnosis::write_diagnosis(out.path(), d, coarse_model());
  EXPECT_EQ(core::read_file(out.path() / "diagnosis.json"), diagnosis::diagnosis_json(d));
  const mesh::Machine extended =
      mesh::parse_machine(core::read_file(out.path() / "extended/machine.toml"), "machine.toml");
  EXPECT_NEAR(extended.films[1].coefficient.value, 9 * d.causes[0].value, 1e-6);
  const reduction::ReducedModel model = reduction::read_model(out.path() / "extended/model.rom.h5");
  EXPECT_EQ(model.machine.films[1].coefficient.value, extended.films[1].coefficient.value);
  EXPECT_EQ(model.system.conduction, coarse_model().system.conduction);
  const core::Table series = core::read_csv(out.path() / "residuals.csv");
  EXPECT_EQ(series.columns.front(), "time_s");
  const std::string html = core::read_file(out.path() / "report.html");
  EXPECT_LT(html.size(), 1000000u);
  EXPECT_EQ(html.find("http"), std::string::npos);
  EXPECT_EQ(html.find("<script"), std::string::npos);
  for (const auto& r : d.residuals) {
    EXPECT_TRUE(series.find(r.id + "_before") && series.find(r.id + "_after"));
    EXPECT_NE(html.find("residual of " + r.id), std::string::npos) << r.id;
    EXPECT_NE(html.find("<tr><td>" + r.id + "</td>"), std::string::npos) << r.id;
  }
  EXPECT_NE(html.find("column.film"), std::string::npos);

  // A later diagnosis without a finding leaves no extension behind.
  diagnosis::write_diagnosis(out.path(), run(lumped::measure({}, {.seed = 73})), coarse_model());
  EXPECT_FALSE(std::filesystem::exists(out.path() / "extended"));
}

TEST(DiagnoseFiles, an_extended_model_is_clean_on_the_next_measurement) {
  const auto truth = find("source_power", "motor");
  const Diagnosis d = run(lumped::measure({{truth, 1.6}}, {.seed = 74}));
  ASSERT_FALSE(d.extended_machine_text.empty()) << listed(d);
  reduction::ReducedModel extended = coarse_model();
  extended.machine = mesh::parse_machine(d.extended_machine_text, extended.machine.path);
  const Diagnosis next = diagnosis::diagnose(extended, lumped::measure({{truth, 1.6}}, {.seed = 75}), {});
  EXPECT_EQ(next.verdict, "no_discrepancy") << listed(next);
}

}  // namespace
