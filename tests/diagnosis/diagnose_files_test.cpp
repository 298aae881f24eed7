// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <set>

#include "core/file.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/report/diagnosis_json.h"
#include "diagnosis/report/report.h"
#include "diagnosis/report/write_diagnosis.h"
#include "mesh/machine/file.h"
#include "reduction/model/model_file.h"
#include "tests/core/temporary_folder.h"
#include "tests/diagnosis/diagnosed_rods.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;
using diagnosis::Diagnosis;
using lumped::coarse_model, lumped::find, lumped::listed, lumped::run;

TEST(DiagnoseFiles, JsonHasTheKeysOfTheContract) {
  const Diagnosis d = run(lumped::measure({{find(Kind::source_power, "motor"), 1.6}}, {.seed = 71}));
  const auto json = nlohmann::json::parse(diagnosis::diagnosis_json(d));
  const auto keys = [](const nlohmann::json& object) {
    std::set<std::string> result;
    for (const auto& item : object.items()) result.insert(item.key());
    return result;
  };
  EXPECT_EQ(keys(json),
            (std::set<std::string>{"schema", "verdict", "sentence", "actions", "causes", "ranking", "ambiguous_set",
                                   "explanations", "reading_steps", "residual", "detectability", "gain",
                                   "next_measurement", "extended_machine", "warnings", "notes"}));
  EXPECT_EQ(json["sentence"], d.sentence);
  EXPECT_EQ(json["warnings"], nlohmann::json(d.warnings));
  EXPECT_EQ(json["notes"], nlohmann::json(d.notes));
  EXPECT_FALSE(d.sentence.empty() || d.notes.empty());
  ASSERT_EQ(json["causes"].size(), 1u);
  EXPECT_EQ(keys(json["causes"][0]), (std::set<std::string>{"kind", "where", "probability", "parameters"}));
  EXPECT_EQ(json["causes"][0]["kind"], "source_power");
  EXPECT_EQ(json["causes"][0]["where"], "motor");
  EXPECT_EQ(keys(json["causes"][0]["parameters"]["factor"]), (std::set<std::string>{"value", "std", "unit"}));
  EXPECT_EQ(keys(json["ranking"][0]), (std::set<std::string>{"kind", "where", "probability", "log_evidence"}));
  ASSERT_EQ(json["residual"]["per_channel"].size(), 10u);
  EXPECT_EQ(keys(json["residual"]["per_channel"][0]),
            (std::set<std::string>{"id", "rms_before", "rms_after", "unit", "p_value_white"}));
  EXPECT_EQ(keys(json["gain"]), (std::set<std::string>{"heldout_rms_before_um", "heldout_rms_after_um",
                                                       "reduction_percent", "ci95_percent"}));
  EXPECT_EQ(json["gain"]["ci95_percent"].size(), 2u);
  EXPECT_EQ(keys(json["next_measurement"]),
            (std::set<std::string>{"load", "channel", "why", "duration_h", "outcomes"}));
  EXPECT_EQ(json["extended_machine"], "extended/machine.toml");
}

TEST(DiagnoseFiles, AllFilesAreWrittenAndAgree) {
  const core::TemporaryFolder out;
  const Diagnosis d = run(lumped::measure({{find(Kind::film_coefficient, "column.film"), 2.4}}, {.seed = 72}));
  ASSERT_EQ(d.verdict, diagnosis::Verdict::explained) << listed(d);
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

TEST(DiagnoseFiles, AnExtendedModelIsCleanOnTheNextMeasurement) {
  const auto truth = find(Kind::source_power, "motor");
  const Diagnosis d = run(lumped::measure({{truth, 1.6}}, {.seed = 74}));
  ASSERT_FALSE(d.extended_machine_text.empty()) << listed(d);
  reduction::ReducedModel extended = coarse_model();
  extended.machine = mesh::parse_machine(d.extended_machine_text, extended.machine.path);
  const Diagnosis next = diagnosis::diagnose(extended, lumped::measure({{truth, 1.6}}, {.seed = 75}), {});
  EXPECT_EQ(next.verdict, diagnosis::Verdict::no_discrepancy) << listed(next);
}

}  // namespace
