// SPDX-License-Identifier: GPL-3.0-or-later
// What changes with the time of day, or in the course of a record, from files to diagnosis.json.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "core/interpolation.h"
#include "core/table.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/model_file.h"
#include "tests/cases/toy.h"
#include "tests/machines/meshed_boxes.h"
#include "tests/machines/rods_record.h"

namespace thermotwin::cases {
namespace {

const char* const sun = R"(
[[source]]
id = "sun"
law = [ { input = "day.time_h", at = [8, 9, 11, 12], power_W = [0, 150, 150, 0] } ]
place = [ { surface = "column.rails" } ]
)";

TEST(TimeOfDay, ALoadProgramDrivesALawOverIt) {
  const Toy toy;
  toy.write("machine.toml", read(toy.file("machine.toml")) + sun);
  const auto heat_at = [&](const std::string& starts_at) {
    toy.write("loads/day.toml",
              "schema = 1\n" + starts_at + "time_step_s = 600\noutput_s = 1800\n[[phase]]\nduration_h = 6\n");
    const Result result = toy.run({"simulate", toy.path(), "--load", "day", "--size", "2", "--quiet"});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(result.err.find("no time of day at the start") == std::string::npos, !starts_at.empty()) << result.err;
    return core::read_csv(toy.result("simulate/day/sensors.csv"));
  };
  const core::Table told = heat_at("starts_at = \"06:00\"\n"), untold = heat_at("");
  const auto column = [](const core::Table& table) { return table.column(table.columns[1]); };
  const Eigen::VectorXd change = column(told) - column(untold);
  EXPECT_NEAR(change.head(4).norm(), 0.0, 1e-9) << "nothing before eight";
  EXPECT_GT(change.cwiseAbs().maxCoeff(), 0.01) << change.transpose();
  // A file is warned of once, however often it is read.
  const Result reduced = toy.run({"reduce", toy.path(), "--size", "2", "--order", "10", "--quiet"});
  EXPECT_EQ(reduced.status, 0) << reduced.err;
  const std::string words = "mixed.toml starts_at: no time of day";
  const std::size_t first = reduced.err.find(words);
  ASSERT_NE(first, std::string::npos) << reduced.err;
  EXPECT_EQ(reduced.err.find(words, first + 1), std::string::npos) << reduced.err;
}

TEST(TimeOfDay, IsRefusedWhereItIsNone) {
  const Toy toy;
  toy.edit("loads/mixed.toml", "schema = 1\n", "schema = 1\nstarts_at = \"6 o'clock\"\n");
  const Result result = toy.run({"simulate", toy.path(), "--load", "mixed"});
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "starts_at");
  EXPECT_SAYS(result.err, "a time of day from \"00:00\" to \"23:59\"");
  toy.write("machine.toml",
            read(toy.file("machine.toml")) + std::string(sun).replace(std::string(sun).find("11, 12]"), 7, "11, 25]"));
  const Result beyond = toy.run({"mesh", toy.file("machine.toml")});
  EXPECT_EQ(beyond.status, 3);
  EXPECT_SAYS(beyond.err, "hours of a day, 0 to 24");
}

const char* const window = R"(
[[surface]]
id = "window"
body = "column"
rule = { box_min_mm = [60, 379, 300], box_max_mm = [121, 381, 480] }
[[source]]
id = "sun"
law = [ { input = "day.time_h", at = [9, 10, 12, 13], power_W = [0, 100, 100, 0] } ]
place = [ { surface = "window" } ]
)";

/// The machine of boxes with sun on its column from half past nine to half past twelve, measured from six on.
compensation::Measurement sunny_record() {
  const mesh::Machine sunny = mesh::parse_machine(meshed::machine_text() + window, "boxes/machine.toml"),
                      machine = compensation::perturbed(sunny, 12, 0.7);
  std::vector<mesh::Pose> poses;
  for (const char* pose : {"X=0,Z=0", "X=150,Z=80", "X=-150,Z=-80"})
    poses.push_back(mesh::parse_pose(machine, pose, "test"));
  return compensation::measure_virtually(meshed::full_model(machine, 2),
                                         meshed::load(machine, "shift", meshed::shift, "06:00"), poses,
                                         {.sensor_noise_K = 0.03, .probe_noise_um = 0.2, .seed = 12, .mesh_cache = {}});
}

/// A record without the channel of an input.
compensation::Measurement without(compensation::Measurement record, const std::string& input) {
  const auto channel =
      std::find_if(record.channels.begin(), record.channels.end(), [&](const auto& one) { return one.input == input; });
  if (channel == record.channels.end()) return record;
  const Eigen::Index column = channel->column, after = std::ssize(record.data.columns) - column - 1;
  record.data.columns.erase(record.data.columns.begin() + column);
  record.data.values.middleCols(column, after) = record.data.values.rightCols(after).eval();
  record.data.values.conservativeResize(Eigen::NoChange, column + after);
  record.channels.erase(channel);
  for (auto& other : record.channels)
    if (other.column > column) --other.column;
  return record;
}

TEST(TimeOfDay, SunIsNamedWithItsHoursWhereARecordStatesTheTimeOfDay) {
  const core::TemporaryFolder folder;
  const std::string model = (folder.path() / "boxes.rom.h5").string(), data = (folder.path() / "record").string();
  reduction::write_model(model, meshed::reduced());
  compensation::Measurement record = sunny_record();
  record = without(std::move(record), mesh::time_of_day);
  const auto diagnosed = [&] {
    compensation::write_measurement(data, record);
    const Result result =
        thermotwin({"diagnose", "--model", model, "--data", data, "--out", (folder.path() / "out").string(), "--json"});
    EXPECT_EQ(result.status, 0) << result.err;
    return nlohmann::json::parse(result.out);
  };
  EXPECT_EQ(diagnosed().dump().find("day.time_h"), std::string::npos) << "not stated";
  record.starts_at_h = 6.0;
  const nlohmann::json d = diagnosed(), &cause = d["causes"][0];
  ASSERT_EQ(d["verdict"], "explained") << d["sentence"];
  EXPECT_EQ(cause["kind"], "source_missing") << d["sentence"];
  EXPECT_EQ(cause["location"]["body"], "column");
  EXPECT_EQ(cause["follows"], "day.time_h");
  EXPECT_NEAR(cause["hours_of_day"][0].get<double>(), 9.5, 0.6) << cause.dump(1);
  EXPECT_NEAR(cause["hours_of_day"][1].get<double>(), 12.5, 0.6) << cause.dump(1);
  EXPECT_SAYS(d["actions"][0].get<std::string>(), "every day (sun, heating, a shift, a neighbour)");
  const std::string extended = read(folder.path() / "out/diagnosis/extended/machine.toml");
  EXPECT_SAYS(extended, "input = \"day.time_h\"");
  const mesh::Machine named = mesh::parse_machine(extended, "boxes/machine.toml");
  const mesh::PowerLaw& law = named.sources.back().laws.front();
  EXPECT_NEAR(core::linear_at(law.at, law.power, 11.0), 100.0, 25.0);
  EXPECT_NEAR(core::linear_at(law.at, law.power, 15.0), 0.0, 1e-9);
  // Who runs the extended model has to tell it the time of day.
  const std::string by_hour = (folder.path() / "out/diagnosis/extended/model.rom.h5").string();
  const Result rows = thermotwin({"compensate", by_hour}, "time_s,air.T_C\n0,20\n60,20\n");
  EXPECT_EQ(rows.status, 0) << rows.err;
  EXPECT_SAYS(rows.err, "warning: standard input:1: no column day.time_h");
  record.starts_at_h = std::numeric_limits<double>::quiet_NaN();
  compensation::write_measurement(data, record);
  const Result untold = thermotwin(
      {"diagnose", "--model", by_hour, "--data", data, "--out", (folder.path() / "untold").string(), "--json"});
  EXPECT_SAYS(untold.out, "The time of day is not recorded");
  // A sensor that is loose from the middle of the record on is named with its rows.
  const auto sensor = std::find_if(record.channels.begin(), record.channels.end(),
                                   [](const auto& channel) { return !channel.sensor.empty(); });
  ASSERT_NE(sensor, record.channels.end());
  record.data.values.col(sensor->column).tail(record.data.rows() / 2).setConstant(120.0);
  compensation::write_measurement(data, record);
  const Result judged = thermotwin(
      {"evaluate", "--data", data, "--model", by_hour, "--out", (folder.path() / "judged").string(), "--json"});
  ASSERT_EQ(judged.status, 0) << judged.err;
  const std::string notes = nlohmann::json::parse(judged.out)["notes"].dump();
  EXPECT_SAYS(notes, "the time of day is not recorded");
  EXPECT_SAYS(notes, "sensors left out: " + sensor->sensor + "=");
}

TEST(ChangingRecord, AStepInFrictionIsNamedWithItsTime) {
  const core::TemporaryFolder folder;
  const std::string model = (folder.path() / "rods.rom.h5").string(), data = (folder.path() / "record").string();
  reduction::write_model(model, lumped::model(lumped::machine(), 9));
  compensation::write_measurement(
      data, lumped::measure({}, {.seed = 91, .spread = 0.7, .changing = "motor", .factor = [](double hour) {
                                   return hour < 14.2 ? 1.0 : 1.9;
                                 }}));
  const Result result = thermotwin({"diagnose", "--model", model, "--data", data, "--temperature-error", "3", "--out",
                                    (folder.path() / "out").string(), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const nlohmann::json d = nlohmann::json::parse(result.out);
  ASSERT_EQ(d["verdict"], "explained") << d["sentence"];
  EXPECT_EQ(d["causes"][0]["kind"], "source_step") << d["sentence"];
  EXPECT_EQ(d["causes"][0]["where"], "motor");
  EXPECT_NEAR(d["causes"][0]["parameters"]["factor"]["value"].get<double>(), 1.9, 0.4);
  EXPECT_NEAR(d["causes"][0]["since_h"]["value"].get<double>(), 14.2, 1.0);
  EXPECT_SAYS(d["sentence"].get<std::string>(), "since ");
  const std::string extended = read(folder.path() / "out/diagnosis/extended/machine.toml");
  EXPECT_SAYS(extended, "# diagnosis: source_step factor 1.");
}

}  // namespace
}  // namespace thermotwin::cases
