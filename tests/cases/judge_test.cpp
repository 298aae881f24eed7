// SPDX-License-Identifier: GPL-3.0-or-later
// `evaluate` and `diagnose` with and without a machine.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using nlohmann::json;

/// A drift that lags behind two temperatures, of something that is no machine of ours.
void write_drift(const Toy& toy) {
  std::string data = "time_s,T_hall,T_frame,z\n";
  double frame = 20, z = 0;
  for (int i = 0; i < 600; ++i) {
    const double time = 300.0 * i, hall = 20 + 2 * std::sin(time / 20000.0);
    frame += (hall - frame) * 0.02;
    z = 5 * (frame - 20) - 2 * (hall - 20);
    data += std::to_string(time) + "," + std::to_string(hall) + "," + std::to_string(frame) + "," + std::to_string(z) +
            "\n";
  }
  toy.write("drift/data.csv", data);
  toy.write(
      "drift/channels.toml",
      "[[channel]]\nid = \"T_hall\"\nkind = \"temperature\"\nunit = \"degC\"\nuncertainty = 0.05\nsensor = \"hall\"\n"
      "[[channel]]\nid = \"T_frame\"\nkind = \"temperature\"\nunit = \"degC\"\nuncertainty = 0.05\nsensor = \"frame\"\n"
      "[[channel]]\nid = \"z\"\nkind = \"displacement\"\nunit = \"um\"\nuncertainty = 0.1\ndirection = \"z\"\n");
}

TEST(Evaluate, NeedsNoMachine) {
  const Toy toy;
  write_drift(toy);
  const Result result = toy.run({"evaluate", "--data", toy.file("drift"), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json summary = json::parse(result.out);
  std::set<std::string> models;
  for (const json& row : summary["rows"]) {
    models.insert(row["model"]);
    // z is a sum of the two temperatures, so the regression that may use both has it all.
    if (row["model"] == "static_regression") {
      EXPECT_GT(row["rms_reduction_percent"], 99.0) << row;
    }
  }
  for (const char* model : {"static_regression", "first_order", "grey_box", "arx", "armax", "output_error",
                            "heating_cooling", "composite", "feed_forward", "memory_network"}) {
    EXPECT_TRUE(models.contains(model)) << model;
  }
  // What needs several poses says so instead of taking part.
  EXPECT_FALSE(models.contains("transfer_grid") || models.contains("one_point"));
  EXPECT_SAYS(summary["notes"].dump(), "one_point z: measured at one pose only");
  EXPECT_SAYS(read(toy.result("evaluation/leaderboard.svg")), "grey_box");
  EXPECT_SAYS(read(toy.result("evaluation/z.svg")), "</svg>");
  EXPECT_SAYS(read(toy.result("evaluation/tables.txt")), "static_regression");
  const core::Table predictions = core::read_csv(summary["predictions"].get<std::string>());
  EXPECT_EQ(predictions.rows(), 600);
  EXPECT_TRUE(predictions.find("z_measured").has_value());
}

// Six hours in five-minute rows: all models in one table are more lines than a terminal shows.
TEST(Evaluate, LeavesLongTablesToTheFileAndSaysWhereTrainingIsShort) {
  const Toy toy;
  write_drift(toy);
  const Result result = toy.run({"evaluate", "--data", toy.file("drift"), "--train-until", "3"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "fitted on only 2.9 h; the tests of ISO 230-3 last 4 h");
  const std::string tables = read(toy.result("evaluation/tables.txt"));
  EXPECT_SAYS(tables, "z (um)");
  EXPECT_SAYS(result.out, "tables.txt");
  EXPECT_EQ(result.out.find("PK before"), std::string::npos)
      << "a table of " << std::count(tables.begin(), tables.end(), '\n');
  EXPECT_LT(std::count(result.out.begin(), result.out.end(), '\n'), 60);
}

TEST(Evaluate, JudgesTheMachineBesideTheDataModels) {
  const Toy toy;
  const std::string data = (toy_run() / "measurement").string(), model = (toy_run() / "model.rom.h5").string();
  const Result result = toy.run({"evaluate", toy.path(), "--data", data, "--model", model, "--train-until", "3",
                                 "--models", "static_regression,grey_box_all", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  std::set<std::string> models;
  const json summary = json::parse(result.out);
  for (const json& row : summary["rows"]) models.insert(row["model"]);
  EXPECT_EQ(models,
            (std::set<std::string>{"grey_box_all", "static_regression", "reduced_model", "reduced_model_sensors"}));
  // Fitted or not, a model stands on the leaderboard by the rows that no fit saw.
  for (const json& standing : summary["leaderboard"]) {
    double before = 0, after = 0;
    std::map<std::string, std::array<double, 3>> sums;  // squares before and after, rows
    for (const json& row : summary["rows"]) {
      if (row["model"] != standing["model"] || row["part"] == "training") continue;
      const double lever = row["unit"] == "um/m" ? 0.3 : 1.0, count = row["count"];
      auto& sum = sums[row["channel"]];
      sum[0] += count * std::pow(lever * row["rms_before"].get<double>(), 2);
      sum[1] += count * std::pow(lever * row["rms"].get<double>(), 2);
      sum[2] += count;
    }
    for (const auto& [channel, sum] : sums) {
      before += sum[0] / sum[2];
      after += sum[1] / sum[2];
    }
    EXPECT_NEAR(standing["rms_reduction_percent"].get<double>(), 100 * (1 - std::sqrt(after / before)), 1e-6)
        << standing;
    EXPECT_EQ(standing["predicted_percent"], 100.0) << standing;
  }
}

TEST(Evaluate, SignsUnitsAndSensorsThatMisleadAreNamed) {
  const Toy toy;
  toy.take_measurement();
  core::Table data = core::read_csv(toy.file("measurement/data.csv"));
  const std::string model = (toy_run() / "model.rom.h5").string();
  const json channels = json::parse(read(toy_run() / "diagnosis/diagnosis.json"))["residual"]["per_channel"];
  std::vector<std::string> gauges;
  for (const json& channel : channels)
    if (channel["unit"] == "um") gauges.push_back(channel["id"]);
  // Those that move most: a direction without motion has no sign.
  std::sort(gauges.begin(), gauges.end(), [&](const std::string& a, const std::string& b) {
    return data.column(a).array().abs().maxCoeff() > data.column(b).array().abs().maxCoeff();
  });
  ASSERT_GE(gauges.size(), 3U);
  data.values.col(*data.find(gauges[0])) *= -1.0;
  data.values.col(*data.find(gauges[1])) *= 1e-3;
  const auto notes_of = [&] {
    core::write_csv(toy.file("measurement/data.csv"), data, 12);
    const Result evaluated = toy.run({"evaluate", toy.path(), "--data", toy.file("measurement"), "--model", model,
                                      "--models", "static_regression", "--json"});
    EXPECT_EQ(evaluated.status, 0) << evaluated.err;
    return json::parse(evaluated.out)["notes"].get<std::vector<std::string>>();
  };
  const std::string reversed = "reduced_model: Channel " + gauges[0] + ": its sign may be reversed";
  const auto hint_in = [&](const std::vector<std::string>& notes) {
    const auto found =
        std::find_if(notes.begin(), notes.end(), [&](const std::string& note) { return note.starts_with(reversed); });
    return found == notes.end() ? std::string() : *found;
  };
  const std::string hint = hint_in(notes_of());
  EXPECT_SAYS(hint, reversed);
  data.values.col(*data.find("T1")).array() += 4.0;
  const std::vector<std::string> notes = notes_of();
  EXPECT_EQ(hint_in(notes), hint) << "judged by a prediction that no reading has bent";
  const Result diagnosed =
      toy.run({"diagnose", toy.path(), "--data", toy.file("measurement"), "--model", model, "--json"});
  ASSERT_EQ(diagnosed.status, 0) << diagnosed.err;
  const json d = json::parse(diagnosed.out);
  const std::string warnings = d["warnings"].dump();
  EXPECT_SAYS(warnings, "Channel " + gauges[0] + ": its sign may be reversed");
  EXPECT_SAYS(warnings, "Channel " + gauges[1] + ": its numbers may be mm");
  EXPECT_EQ(warnings.find("Channel " + gauges[2]), std::string::npos) << warnings;
  EXPECT_SAYS(d["sentence"].get<std::string>(), "check signs and units");
  EXPECT_SAYS(json(notes).dump(), "the temperature sensors worsen reduced_model");
}

TEST(Evaluate, RefusesATrainingFolderOfAnotherMachineByName) {
  const Toy toy;
  const std::string model = (toy_run() / "model.rom.h5").string();
  std::filesystem::copy(toy_run() / "measurement", toy.file("other"), std::filesystem::copy_options::recursive);
  const std::string channels = read(toy.file("other/channels.toml")), sensor = "sensor = \"T1\"";
  std::string changed = channels;
  ASSERT_NE(changed.find(sensor), std::string::npos);
  changed.replace(changed.find(sensor), sensor.size(), "sensor = \"A_drive\"");
  const auto judge = [&](const char* option) {
    return toy.run({"evaluate", toy.path(), "--data", (toy_run() / "measurement").string(), "--model", model, option,
                    toy.file("other"), "--models", "static_regression"});
  };
  EXPECT_EQ(judge("--train-data").status, 0);
  const std::string stated = "machine = \"toy\"";
  ASSERT_NE(channels.find(stated), std::string::npos) << "a virtual record states its machine";
  std::string renamed = channels;
  renamed.replace(renamed.find(stated), stated.size(), "machine = \"ac5\"");
  toy.write("other/channels.toml", renamed);
  for (const char* option : {"--train-data", "--also"}) {
    const Result refused = judge(option);
    EXPECT_EQ(refused.status, 3) << option;
    for (const std::string& words : {toy.file("other"), std::string("'ac5'"), std::string("'toy'")})
      EXPECT_SAYS(refused.err, words);
  }
  const Result diagnosed = toy.run({"diagnose", "--data", toy.file("other"), "--model", model});
  EXPECT_EQ(diagnosed.status, 3);
  EXPECT_SAYS(diagnosed.err, "'ac5'; allowed: 'toy'");
  toy.write("other/channels.toml", changed);
  for (const char* option : {"--train-data", "--also"}) {
    const Result refused = judge(option);
    EXPECT_EQ(refused.status, 3) << option;
    for (const std::string& words : {toy.file("other"), std::string("machine 'toy'"), std::string("A_drive")})
      EXPECT_SAYS(refused.err, words);
  }
}

TEST(Evaluate, JudgesTheExtendedModelBesideTheNominalOne) {
  const Toy toy;
  const std::string data = (toy_run() / "measurement").string(), model = (toy_run() / "model.rom.h5").string();
  const std::string extended = (toy_run() / "diagnosis/extended/model.rom.h5").string();
  const Result result = toy.run({"evaluate", toy.path(), "--data", data, "--model", model, "--extended", extended,
                                 "--train-until", "3", "--models", "static_regression", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  std::map<std::string, double> removed;  // of the channel that moves most
  double largest = 0;
  const json summary = json::parse(result.out);
  for (const json& row : summary["rows"]) {
    if (row["unit"] == "um") largest = std::max(largest, row["rms_before"].get<double>());
  }
  for (const json& row : summary["rows"]) {
    if (row["unit"] == "um" && row["rms_before"] == largest) removed[row["model"]] = row["rms_reduction_percent"];
  }
  // The record has a source that is stronger than stated: what names it predicts better, with sensors and without.
  ASSERT_TRUE(removed.contains("extended_model") && removed.contains("extended_model_sensors")) << result.out;
  EXPECT_GT(removed["extended_model"], removed["reduced_model"] + 5.0);
  EXPECT_GT(removed["extended_model_sensors"], removed["reduced_model_sensors"]);
  const Result both =
      toy.run({"evaluate", toy.path(), "--data", data, "--extended", extended, "--fitted", toy.file("models.toml")});
  EXPECT_EQ(both.status, 2);
  for (const char* words : {"--fitted", "--extended"}) EXPECT_SAYS(both.err, words);
}

TEST(Evaluate, ModelsCarryToAnotherRecordAndCross) {
  const Toy toy;
  write_drift(toy);
  const Result first =
      toy.run({"evaluate", "--data", toy.file("drift"), "--models", "static_regression,first_order", "--also",
               toy.file("drift"), "--cross", "--length-study", "first_order", "z", "--json"});
  ASSERT_EQ(first.status, 0) << first.err;
  const json summary = json::parse(first.out);
  EXPECT_EQ(summary["cross"]["programs"].size(), 3U) << "days 0, 1 and 2";
  EXPECT_EQ(summary["cross"]["models"][0]["rms_reduction_percent"].size(), 3U);
  EXPECT_EQ(summary["length_study"].size(), 8U);
  bool judged_elsewhere = false;
  for (const json& row : summary["rows"]) judged_elsewhere = judged_elsewhere || row["part"] == "drift";
  EXPECT_TRUE(judged_elsewhere);
  const Result carried = toy.run(
      {"evaluate", "--data", toy.file("drift"), "--fitted", toy.result("evaluation/models.toml").string(), "--json"});
  ASSERT_EQ(carried.status, 0) << carried.err;
  std::set<std::string> models;
  const json elsewhere = json::parse(carried.out);
  for (const json& row : elsewhere["rows"]) models.insert(row["model"]);
  EXPECT_EQ(models, (std::set<std::string>{"static_regression_as_is", "static_regression_corrected",
                                           "first_order_as_is", "first_order_corrected"}));
  const Result unknown = toy.run({"evaluate", "--data", toy.file("drift"), "--models", "grey_bocks"});
  EXPECT_EQ(unknown.status, 3);
  for (const char* words : {"grey_bocks", "nearest: grey_box"}) EXPECT_SAYS(unknown.err, words);
}

TEST(Diagnose, NeedsNoMachine) {
  const Toy toy;
  write_drift(toy);
  const Result result = toy.run({"diagnose", "--data", toy.file("drift"), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json d = json::parse(result.out);
  // Two first-order elements are what it is.
  EXPECT_EQ(d["verdict"], "no_discrepancy") << result.out;
  EXPECT_EQ(d["residual"]["per_channel"][0]["id"], "z");
  EXPECT_TRUE(d["extended_machine"].is_null());
  for (const char* file : {"diagnosis/diagnosis.json", "diagnosis/report.html", "diagnosis/residuals.csv"})
    EXPECT_TRUE(std::filesystem::exists(toy.result(file))) << file;
}

TEST(Diagnose, AMeshErrorNeedsAMesh) {
  const Toy toy;
  write_drift(toy);
  const Result without = toy.run({"diagnose", "--data", toy.file("drift"), "--temperature-error", "3"});
  EXPECT_EQ(without.status, 2);
  for (const char* words : {"--temperature-error", "a CASE or --model"}) EXPECT_SAYS(without.err, words);
  const std::string data = (toy_run() / "measurement").string(), model = (toy_run() / "model.rom.h5").string();
  const Result negative = toy.run({"diagnose", "--model", model, "--data", data, "--temperature-error", "-1"});
  EXPECT_EQ(negative.status, 2);
  EXPECT_SAYS(negative.err, "--temperature-error");
}

TEST(Diagnose, SeveralRecordsAreOneQuestion) {
  const Toy toy;
  toy.take_measurement();
  std::filesystem::rename(toy.file("measurement"), toy.file("monday"));
  std::filesystem::copy(toy.file("monday"), toy.file("friday"));
  const std::string model = (toy_run() / "model.rom.h5").string();
  const Toy elsewhere;
  const Result both = toy.run({"diagnose", "--data", toy.file("monday"), toy.path(), "--data", toy.file("friday"),
                               "--model", model, "--json", "--accept", elsewhere.file("accepted")});
  ASSERT_EQ(both.status, 0) << both.err;
  const json d = json::parse(both.out), one = json::parse(read(toy_run() / "diagnosis/diagnosis.json"));
  EXPECT_EQ(d["verdict"], "explained") << both.out;
  ASSERT_EQ(d["records"].size(), 2U);
  EXPECT_EQ(d["records"][0]["name"], "monday");
  EXPECT_EQ(d["causes"][0]["where"], one["causes"][0]["where"]);
  EXPECT_EQ(d["residual"]["per_channel"].size(), 2 * one["residual"]["per_channel"].size());
  EXPECT_SAYS(read(toy.result("diagnosis/report.html")), "<h2>Records</h2>");
  EXPECT_SAYS(read(toy.result("diagnosis/report.html")),
              "--data " + toy.file("monday") + " --data " + toy.file("friday"));

  const Result twice =
      toy.run({"diagnose", toy.path(), "--data", toy.file("monday"), "--data", toy.file("monday"), "--model", model});
  EXPECT_EQ(twice.status, 3);
  for (const char* words : {"--data", "the same record twice", "each record once"}) EXPECT_SAYS(twice.err, words);
  const Result inside = toy.run(
      {"diagnose", toy.path(), "--data", toy.file("monday"), "--model", model, "--accept", toy.file("accepted")});
  EXPECT_EQ(inside.status, 3);
  EXPECT_SAYS(inside.err, "a folder inside of the case");
  const Result bare = toy.run({"diagnose", "--data", toy.file("monday"), "--data", toy.file("friday")});
  EXPECT_EQ(bare.status, 2);
  EXPECT_SAYS(bare.err, "they need a CASE or --model");
}

TEST(Diagnose, DataOfAnotherMachineAreRefused) {
  const Toy toy;
  write_drift(toy);
  // Refused at once: nothing is meshed or simulated for it.
  const Result foreign = toy.run({"diagnose", toy.path(), "--data", toy.file("drift")});
  EXPECT_EQ(foreign.status, 3);
  for (const char* words : {"channels.toml", "'hall'", "T1, T2, T3, T4", "thermotwin diagnose --data "})
    EXPECT_SAYS(foreign.err, words);
  EXPECT_TRUE(files_in(toy.out()).empty());
}

TEST(Diagnose, ModelAloneWillDo) {
  const Toy toy;
  const std::string data = (toy_run() / "measurement").string(), model = (toy_run() / "model.rom.h5").string();
  const Result result = toy.run({"diagnose", "--model", model, "--data", data});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "spindle.bearings");
  EXPECT_EQ(read(toy.result("diagnosis/diagnosis.json")), read(toy_run() / "diagnosis/diagnosis.json"));
}

TEST(Diagnose, ModelOfAnotherMachineIsPointedOut) {
  const Toy toy;
  toy.edit("machine.toml", "conductivity_W_mK = 46", "conductivity_W_mK = 47");
  const Result result = toy.run({"diagnose", toy.path(), "--model", (toy_run() / "model.rom.h5").string(), "--data",
                                 (toy_run() / "measurement").string(), "--quiet"});
  EXPECT_EQ(result.status, 0);
  EXPECT_SAYS(result.err, "another machine.toml");
  // Another name is another machine.
  toy.edit("machine.toml", "name = \"toy\"", "name = \"lathe\"");
  const Result named = toy.run({"diagnose", toy.path(), "--model", (toy_run() / "model.rom.h5").string(), "--data",
                                (toy_run() / "measurement").string(), "--quiet"});
  EXPECT_EQ(named.status, 3);
  EXPECT_SAYS(named.err, "a model of the machine 'toy'");
  EXPECT_SAYS(named.err, "a model of 'lathe'");
}

}  // namespace
}  // namespace thermotwin::cases
