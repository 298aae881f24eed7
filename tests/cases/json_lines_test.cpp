// SPDX-License-Identifier: GPL-3.0-or-later
// `compensate --json-lines`: an object a row, with the numbers of the CSV.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using nlohmann::json;

/// Half a second apart: X moves after a while, a sensor is in kelvin, and three rows cannot be read whole.
std::string some_rows() {
  std::string text = "time_s,spindle.speed_rpm,axis.X.position_mm,air.T_C,T1_C,T2_C\n";
  text += ",6000,0,25,25,25\n";
  for (int i = 0; i < 40; ++i)
    text += fmt::format("{},6000,{},25,{},25\n", 100 + 0.5 * i, i < 30 ? 0 : 12 * (i - 29), i < 20 ? "25" : "298.15");
  return text + "130,fast,120,25,25,\n,6000,120,25,25,25\n131,6000,120\n3600,6000,120,25,25,25\n";
}

std::vector<json> objects(const std::string& text) {
  std::vector<json> all;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    all.push_back(json::parse(line, nullptr, false));
    EXPECT_TRUE(all.back().is_object()) << line;
  }
  return all;
}

TEST(JsonLines, EveryRowHasTheNumbersOfTheCsv) {
  const Result as_csv = thermotwin({"compensate", toy_model()}, some_rows()),
               as_json = thermotwin({"compensate", toy_model(), "--json-lines"}, some_rows());
  ASSERT_EQ(as_csv.status, 0) << as_csv.err;
  ASSERT_EQ(as_json.status, 0) << as_json.err;
  const std::vector<json> all = objects(as_json.out);
  ASSERT_EQ(all.size(), 45U);
  std::istringstream csv(as_csv.out);
  std::string line;
  std::getline(csv, line);
  for (const json& object : all) {
    ASSERT_TRUE(std::getline(csv, line));
    double time = 0, value[6] = {};
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%lf", &time, &value[0], &value[1], &value[2],
                          &value[3], &value[4], &value[5]),
              7);
    EXPECT_EQ(object["time_s"], time);
    EXPECT_EQ(object["status"], line.substr(line.rfind(',') + 1));
    int k = 0;
    for (const char* key : {"offset_um", "std_um"}) {
      EXPECT_EQ(object[key].size(), 3U);
      for (const char* axis : {"x", "y", "z"}) EXPECT_NEAR(object[key][axis], value[k++], 6e-4) << line;
    }
  }
  EXPECT_EQ(all[0]["status"], "input_missing time_s=missing");
  EXPECT_EQ(all[41]["status"], "input_missing spindle.speed_rpm=unreadable");
  EXPECT_EQ(all[43]["status"], "input_missing row=unreadable");
  // The file has the same bytes.
  const Toy toy;
  EXPECT_EQ(thermotwin({"compensate", toy_model(), "--json-lines", "--out", toy.file("lines")}, some_rows()).status, 0);
  EXPECT_EQ(read(toy.file("lines")), as_json.out);
}

/// An hour and a half in rows of 4 s: the spindle runs, rests and runs faster. readings: an object a row, or nullptr
std::string quick_rows(double speed_share, const std::vector<json>* readings) {
  std::string text = "time_s,spindle.speed_rpm,air.T_C";
  for (int s = 1; readings && s <= 4; ++s) text += fmt::format(",T{}_C", s);
  text += "\n";
  for (int i = 0; i <= 1350; ++i) {
    const double speed = i <= 450 ? 6000 : i <= 900 ? 0 : 9000;
    text += fmt::format("{},{},20", 4 * i, speed_share * speed);
    for (int s = 0; readings && s < 4; ++s)
      text += fmt::format(",{:.1f}", double{(*readings)[i]["sensors"][s]["predicted_C"]});
    text += "\n";
  }
  return text;
}

// Nothing is wrong with the sensors of a machine whose spindle is a little hotter than the model's; they have digits of
// 0.1 K. The model learns it, and follows each start of the spindle late.
TEST(JsonLines, QuickRowsOfAHotterMachineBlameNoSensor) {
  const Result machine =
      thermotwin({"compensate", toy_model(), "--json-lines", "--no-sensors", "--step", "4"}, quick_rows(1.1, nullptr));
  const std::vector<json> readings = objects(machine.out);
  ASSERT_EQ(readings.size(), 1351U) << machine.err;
  const Result done = thermotwin({"compensate", toy_model(), "--json-lines"}, quick_rows(1.0, &readings));
  const std::vector<json> all = objects(done.out);
  ASSERT_EQ(all.size(), 1351U) << done.err;
  int blamed = 0;
  for (const json& object : all) blamed += std::string(object["status"]).starts_with("sensor_failed");
  std::printf("  sensors left out in %d of %zu rows\n", blamed, all.size());
  EXPECT_EQ(blamed, 0);
  const double told = readings.back()["wanted_um"][2], wanted = all.back()["wanted_um"][2];
  EXPECT_NEAR(wanted, told, 0.02 * std::abs(told)) << "with its sensors the model follows the machine";
}

TEST(JsonLines, GuardAndMotionAreThoseOfTheRow) {
  const Result done = thermotwin({"compensate", toy_model(), "--json-lines"}, some_rows());
  const std::vector<json> all = objects(done.out);
  ASSERT_EQ(all.size(), 45U);
  EXPECT_EQ(all[1]["guard"], "limited") << "offsets begin at zero";
  EXPECT_EQ(all[44]["guard"], "following");
  int moving = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_EQ(all[i]["wanted_um"].size(), 3U);
    const bool moves = i > 30 && i < 41;
    if (moves) {
      EXPECT_GT(all[i]["motion_um"], 0.0) << i;
    } else {
      EXPECT_EQ(all[i]["motion_um"], 0.0) << i;
    }
    moving += moves;
    if (all[i]["guard"] != "following") continue;
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(all[i]["wanted_um"][k], all[i]["offset_um"][std::string(1, "xyz"[k])], 1e-3) << i;
  }
  EXPECT_EQ(moving, 10);
  double z = all[2]["wanted_um"][2];
  EXPECT_GT(std::abs(z), std::abs(double{all[2]["offset_um"]["z"]}) + 0.2) << "wanted is before the guard";
}

TEST(JsonLines, OnceASecondSensorsAndErrorsOfTheWorkspaceAreAdded) {
  const Result done = thermotwin({"compensate", toy_model(), "--json-lines"}, some_rows());
  const std::vector<json> all = objects(done.out);
  ASSERT_EQ(all.size(), 45U);
  double last = 0, largest = 0, rate = 0;
  ASSERT_EQ(std::sscanf(done.err.c_str(), "offset limits: %lf um, %lf um/s", &largest, &rate), 2) << done.err;
  int whole = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double time = all[i]["time_s"];
    if (!all[i].contains("sensors")) {
      EXPECT_LT(time - last, 1.0) << i;
      continue;
    }
    EXPECT_GE(time - last, 1.0) << i;
    last = time;
    ++whole;
    EXPECT_EQ(all[i]["axes"], json::parse(R"(["x", "y", "z"])"));
    EXPECT_NEAR(all[i]["limits"]["largest_um"], largest, 0.5);
    EXPECT_NEAR(all[i]["limits"]["rate_um_s"], rate, 0.005 * rate);
    EXPECT_EQ(all[i]["errors_um"].size(), 3U * 27U);
    EXPECT_FALSE(all[i]["modes"].empty()) << "scene.bin lies beside the model";
    ASSERT_EQ(all[i]["sensors"].size(), 4U);
  }
  EXPECT_EQ(whole, 22);
  const json& early = all[1]["sensors"];
  EXPECT_EQ(early[0]["id"], "T1");
  EXPECT_EQ(early[0]["reading_C"], 25.0);
  EXPECT_EQ(early[0]["fault"], "");
  EXPECT_TRUE(early[2]["reading_C"].is_null()) << "has no column";
  EXPECT_EQ(all[39]["sensors"][0]["fault"], "kelvin");
  for (const json& sensor : early) EXPECT_NEAR(sensor["predicted_C"], 25.0, 0.5) << sensor;
  // After an hour at 6000 rpm the spindle is warm, whose sensor still reads 25; the other sensors sit elsewhere.
  const json& late = all[44]["sensors"];
  EXPECT_GT(late[0]["predicted_C"], 35.0);
  EXPECT_EQ(late[0]["fault"], "stuck");
  for (int s = 1; s < 4; ++s) EXPECT_NEAR(late[s]["predicted_C"], 25.0, 1.0) << late[s];
  // The last row stands at a pose of the grid, and its offsets undo the error there.
  const json &offset = all[44]["offset_um"], &errors = all[44]["errors_um"];
  double nearest = 1e9;
  for (std::size_t p = 0; p + 2 < errors.size(); p += 3) {
    const double x = errors[p], y = errors[p + 1], z = errors[p + 2];
    nearest = std::min(nearest, std::hypot(x + double{offset["x"]}, y + double{offset["y"]}, z + double{offset["z"]}));
  }
  EXPECT_LT(nearest, 0.002) << "um";
  EXPECT_GT(std::abs(double{offset["z"]}), 1.0);
  EXPECT_NE(errors, all[1]["errors_um"]);
  EXPECT_NE(all[44]["modes"], all[1]["modes"]);
}

// The axes may have moved while the program was started again.
TEST(JsonLines, TheFirstRowAfterAStateKnowsTheMotionSinceThen) {
  const Toy toy;
  const std::string header = "time_s,spindle.speed_rpm,axis.X.position_mm,air.T_C\n";
  const std::vector<std::string> words = {"compensate", toy_model(), "--json-lines", "--state", toy.file("own.state")};
  ASSERT_EQ(thermotwin(words, header + "0,6000,0,20\n3600,6000,0,20\n").status, 0);
  const std::vector<json> all = objects(thermotwin(words, header + "3610,6000,100,20\n").out);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_GT(all[0]["motion_um"], 0.0);
}

TEST(JsonLines, ADeviceIsAnOutputToo) {
  const Result done = thermotwin({"compensate", toy_model(), "--out", "/dev/null"}, some_rows());
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_SAYS(done.out, "offsets in /dev/null");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace thermotwin::cases
