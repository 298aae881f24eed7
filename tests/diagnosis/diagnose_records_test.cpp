// SPDX-License-Identifier: GPL-3.0-or-later
// Several records of one machine: three rods, measured on two days with other programs and another start.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/record/several_records.h"
#include "diagnosis/report/diagnosis_json.h"
#include "diagnosis/report/report.h"
#include "diagnosis/response/response.h"
#include "mesh/machine/file.h"
#include "tests/diagnosis/diagnosed_rods.h"

namespace {

using namespace thermotwin;
using compensation::Measurement;
using diagnosis::Diagnosis;
using diagnosis::Kind;
using diagnosis::Parameter;
using diagnosis::Verdict;
using lumped::listed;
using Faults = std::vector<std::pair<Parameter, double>>;

Measurement monday(const Faults& faults, double hours = 24) {
  Measurement m = lumped::measure(faults, {.hours = hours, .seed = 5, .spread = 0.5});
  m.folder = "monday";
  return m;
}
/// Cut from the middle of the program, so that other parts of it are fitted; warmer at the start.
Measurement friday(const Faults& faults, double hours = 18) {
  Measurement m = lumped::measure(faults, {.hours = hours, .sample_s = 180, .start_C = 22.1, .seed = 5, .spread = 0.5});
  m.folder = "friday";
  return m;
}

Diagnosis run_all(std::vector<Measurement> records, const reduction::ReducedModel& model = lumped::coarse_model()) {
  diagnosis::DiagnoseOptions how;
  how.temperature_error_percent = 3;
  return diagnosis::diagnose(model, std::move(records), how);
}

TEST(DiagnoseRecords, OneRecordGivesWhatItGaveAlone) {
  const Measurement m = monday({{lumped::find(Kind::source_power, "motor"), 1.5}});
  EXPECT_EQ(diagnosis::diagnosis_json(run_all({m})), diagnosis::diagnosis_json(lumped::run(m)));
}

TEST(DiagnoseRecords, CleanRecordsRaiseNoAlarm) {
  const Diagnosis d = run_all({monday({}), friday({})});
  EXPECT_EQ(d.verdict, Verdict::no_discrepancy) << listed(d);
  EXPECT_EQ(d.measurement, "monday, friday");
}

TEST(DiagnoseRecords, ACauseHoldsInAllOfThem) {
  const Faults faults{{lumped::find(Kind::source_power, "motor"), 1.5}};
  const Diagnosis both = run_all({monday(faults), friday(faults)}), one = lumped::run(monday(faults));
  lumped::expect_found(both, faults[0].first, 1.5, 0.15);
  ASSERT_EQ(both.verdict, Verdict::explained) << listed(both);
  ASSERT_EQ(one.verdict, Verdict::explained) << listed(one);
  EXPECT_LT(both.causes[0].std, one.causes[0].std) << "two records say more than one";
  const auto json = nlohmann::json::parse(diagnosis::diagnosis_json(both));
  ASSERT_EQ(json["records"].size(), 2U);
  EXPECT_EQ(json["records"][1]["name"], "friday");
  EXPECT_NEAR(json["records"][1]["heldout_from_s"].get<double>(), 0.7 * 18 * 3600.0, 700.0);
  for (const auto& record : json["records"])
    EXPECT_LT(record["heldout_rms_after_um"].get<double>(), record["heldout_rms_before_um"].get<double>()) << record;
  const auto& channels = json["residual"]["per_channel"];
  EXPECT_EQ(channels.front()["record"], "monday");
  EXPECT_EQ(channels.back()["record"], "friday");
  EXPECT_EQ(channels.back()["id"], "friday/dz_high");
}

TEST(DiagnoseRecords, WhatDiffersFromDayToDayIsNoCauseInTheMachine) {
  const Parameter fault = lumped::find(Kind::source_power, "motor");
  const Diagnosis d = run_all({monday({{fault, 1.6}}), friday({})});
  EXPECT_NE(d.verdict, Verdict::no_discrepancy) << listed(d);
  for (const diagnosis::RankedCause& cause : d.causes)
    EXPECT_FALSE(d.verdict == Verdict::explained && cause.parameter.kind == fault.kind &&
                 cause.parameter.where == fault.where)
        << listed(d);
}

TEST(DiagnoseRecords, AReadingMayBeOffInOneOfThem) {
  const Faults drift{{lumped::find(Kind::probe_drift, "dx_high"), 1.0}};
  const Diagnosis d = run_all({monday({}), friday(drift)});
  ASSERT_EQ(d.verdict, Verdict::explained) << listed(d);
  ASSERT_EQ(d.causes.size(), 1U) << listed(d);
  EXPECT_EQ(name_of(d.causes[0].parameter), "probe_drift of friday/dx_high") << listed(d);
  EXPECT_NEAR(d.causes[0].value, 1.0, 0.2);
  // The extended machine knows it, in that record alone.
  ASSERT_FALSE(d.extended_machine_text.empty()) << d.sentence;
  reduction::ReducedModel extended = lumped::coarse_model();
  extended.machine = mesh::parse_machine(d.extended_machine_text, extended.machine.path);
  EXPECT_EQ(run_all({monday({}), friday(drift)}, extended).verdict, Verdict::no_discrepancy);
  EXPECT_NE(run_all({friday({}), monday(drift)}, extended).verdict, Verdict::no_discrepancy);
}

TEST(DiagnoseRecords, ASensorThatIsOffInAllOfThemIsOneCause) {
  const Faults offset{{lumped::find(Kind::sensor_offset, "T3_reading"), 1.0}};
  const Diagnosis d = run_all({monday(offset), friday(offset)});
  ASSERT_EQ(d.verdict, Verdict::explained) << listed(d);
  ASSERT_EQ(d.causes.size(), 1U) << listed(d);
  EXPECT_EQ(name_of(d.causes[0].parameter), "sensor_offset of T3_reading") << listed(d);
  EXPECT_NEAR(d.causes[0].value, 1.0, 0.1);
}

TEST(DiagnoseRecords, ThePageHasATableAndPlotsOfEach) {
  const Diagnosis d = run_all({monday({}), friday({})});
  const mesh::Machine machine = lumped::machine();
  const std::string page = diagnosis::report_html(d, &machine, {}, {});
  EXPECT_NE(page.find("<td>friday</td><td class=\"n\">18.0</td>"), std::string::npos);
  EXPECT_NE(page.find("friday/dz_high"), std::string::npos);
  EXPECT_EQ(d.series.rows(), d.records[0].rows + d.records[1].rows);
  EXPECT_DOUBLE_EQ(d.series.column("record")[0], 1.0);
  EXPECT_DOUBLE_EQ(d.series.column("record")[d.series.rows() - 1], 2.0);
  EXPECT_LT(d.series.column("time_s")[d.records[1].first_row], 600.0) << "each in its own time";
}

/// Tangents of records below each other are those of each alone.
TEST(DiagnoseRecords, ResponsesAreThoseOfEachRecord) {
  const std::vector<Measurement> records = diagnosis::with_record_names({monday({}, 6), friday({}, 4)});
  const mesh::Machine machine = lumped::machine();
  std::vector<diagnosis::Observations> each;
  for (const Measurement& m : records) each.push_back(diagnosis::observe(m, machine, solver::Channels(machine), {}));
  const diagnosis::Observations all = diagnosis::joined(each, diagnosis::record_names(records));
  const diagnosis::Response both(lumped::coarse_model(), all);
  const std::vector<Parameter> parameters{lumped::find(Kind::source_power, "motor")};
  const Eigen::VectorXd at = Eigen::VectorXd::Constant(1, 1.2);
  const auto together = both.linearise(machine, parameters, at, true);
  Eigen::Index row = 0, column = 0;
  for (std::size_t k = 0; k < each.size(); ++k) {
    const diagnosis::Response one(lumped::coarse_model(), each[k]);
    const auto alone = one.linearise(machine, parameters, at, true);
    const Eigen::Index n = alone.predicted.size(), starts = alone.start.cols();
    EXPECT_EQ(together.predicted.segment(row, n), alone.predicted);
    EXPECT_EQ(together.sensitivity.middleRows(row, n), alone.sensitivity);
    EXPECT_EQ(together.start.block(row, column, n, starts), alone.start);
    EXPECT_EQ(together.start_std.segment(column, starts), alone.start_std);
    row += n;
    column += starts;
  }
  EXPECT_EQ(together.start.topRightCorner(each[0].size(), 1).norm(), 0.0);
  const mesh::Machine changed = diagnosis::with_parameter(machine, parameters[0], 1.2);
  EXPECT_LT((both.predict(changed) - together.predicted).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace
