// SPDX-License-Identifier: GPL-3.0-or-later
// `compensate --state`: the state of the model outlives the process.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Rows of the held-out load with readings of its sensors, the header first; first <= row < last.
std::string rows(std::size_t first, std::size_t last) {
  const std::vector<std::string> inputs = lines_of(read(toy_run() / "campaign/mixed/inputs.csv")),
                                 sensors = lines_of(read(toy_run() / "campaign/mixed/sensors.csv"));
  std::string text;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (i == 0 || (i > first && i <= last)) text += inputs[i] + sensors[i].substr(sensors[i].find(',')) + "\n";
  }
  return text;
}

std::string without_header(const std::string& text) { return text.substr(text.find('\n') + 1); }

class State : public ::testing::Test {
protected:
  std::string file(const std::string& name) const { return toy_.file(name); }
  Result compensate(const std::string& text, std::vector<std::string> more = {},
                    const Surroundings& around = {}) const {
    std::vector<std::string> arguments = {"compensate", toy_model(), "--state", file("state")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return thermotwin(arguments, text, around);
  }
  Toy toy_;
};

TEST_F(State, TwoRunsGiveWhatOneGives) {
  const Result whole = thermotwin({"compensate", toy_model(), "--state", file("whole")}, rows(0, 91));
  ASSERT_EQ(whole.status, 0) << whole.err;
  const Result first = compensate(rows(0, 40)), second = compensate(rows(40, 91));
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_SAYS(first.err, "does not exist yet: cold start");
  EXPECT_EQ(second.status, 0) << second.err;
  EXPECT_SAYS(second.err, "goes on from " + file("state") + ": state at ");
  EXPECT_EQ(first.out + without_header(second.out), whole.out);
  EXPECT_EQ(read(file("state")), read(file("whole"))) << "to the last bit";
}

/// Rows of a minute; the probed value of the middle one, um, was measured with offsets.
std::string probed_rows(int first, int last) {
  std::string text = "time_s,spindle.speed_rpm,probe_dz_um\n";
  for (int i = first; i < last; ++i) text += fmt::format("{},9000,{}\n", 60 * i, i == 60 ? "3" : "");
  return text;
}

// The offsets of the state's last row are those that the first value after it was measured with.
TEST_F(State, AValueProbedAfterARestartCountsTheOffsetsOfBefore) {
  const std::vector<std::string> probed = {"--probed-compensated"};
  const Result whole =
      thermotwin({"compensate", toy_model(), "--state", file("whole"), "--probed-compensated"}, probed_rows(0, 90));
  ASSERT_EQ(whole.status, 0) << whole.err;
  const Result first = compensate(probed_rows(0, 60), probed), second = compensate(probed_rows(60, 90), probed);
  EXPECT_EQ(first.out + without_header(second.out), whole.out);
  EXPECT_EQ(read(file("state")), read(file("whole")));
  const Result bare = thermotwin({"compensate", toy_model()}, probed_rows(0, 90));
  EXPECT_NE(bare.out, whole.out) << "a value of the bare machine is another one";
}

// What the rows before a bad one have said is kept where they cannot be read again.
TEST_F(State, ABadRowOfAPipeKeepsTheStateBeforeIt) {
  std::string quick;  // the last rows follow the state of a minute ago too soon for it to be written again
  for (int i = 1; i <= 5; ++i) quick += fmt::format("{},{}\n", 10 * i, 6000);
  const std::string text = "time_s,spindle.speed_rpm\n0,6000\n" + quick;
  ASSERT_EQ(thermotwin({"compensate", toy_model(), "--state", file("quick")}, text).status, 0);
  const Result stopped = compensate(text + "60,fast\n", {"--strict"});
  EXPECT_EQ(stopped.status, 3) << stopped.err;
  EXPECT_EQ(read(file("state")), read(file("quick")));
}

// Rows of a file can be run again: a run that fails leaves the state that they start from, as it leaves the offsets.
TEST_F(State, AFileThatFailsHalfWayLeavesTheStateBeforeIt) {
  ASSERT_EQ(compensate(rows(0, 20)).status, 0);
  const std::string before = read(file("state")), right = rows(20, 91);
  const std::vector<std::string> files = {"--in", file("rows.csv"), "--out", file("offsets.csv")};
  toy_.write("rows.csv", right + lines_of(right)[1] + "\n");  // back in time
  const Result failed = compensate("", files);
  EXPECT_EQ(failed.status, 3) << failed.err;
  EXPECT_FALSE(std::filesystem::exists(file("offsets.csv")));
  EXPECT_EQ(read(file("state")), before);
  toy_.write("rows.csv", right);
  EXPECT_EQ(compensate("", files).status, 0);
  const std::string after = read(file("state"));
  toy_.write("state", before);
  EXPECT_EQ(compensate(right).out, read(file("offsets.csv")));
  EXPECT_EQ(read(file("state")), after);
}

// A folder of any name beside the model is nobody's business: HDF5 refuses names that exist.
TEST_F(State, AFolderCalledModelIsNoObstacle) {
  std::filesystem::create_directories(file("model"));
  std::filesystem::copy_file(toy_model(), file("model/model.rom.h5"));
  const Result result =
      thermotwin({"export", "model/model.rom.h5", "--c", "source"}, "", {.output = "", .folder = file("")});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_TRUE(std::filesystem::is_directory(file("source")));
}

// The exported source and `compensate` are the same core: their states are the same file.
TEST_F(State, TheExportedSourceSavesTheSameBytes) {
  ASSERT_EQ(thermotwin({"export", toy_model(), "--c", file("c")}).status, 0);
  ASSERT_EQ(std::system(("cd " + file("c") + " && cc -std=c99 -O2 -ffp-contract=off *.c -o twin -lm").c_str()), 0);
  toy_.write("rows.csv", rows(0, 91));
  const std::string c = file("c") + "/";
  ASSERT_EQ(std::system((c + "twin --state " + c + "state < " + file("rows.csv") + " > " + c + "out").c_str()), 0);
  ASSERT_EQ(compensate(rows(0, 91)).status, 0);
  EXPECT_EQ(read(file("state")), read(c + "state"));
}

TEST_F(State, AKillCostsAtMostAMinute) {
  const std::string header = "time_s,spindle.speed_rpm,axis.X.position_mm,air.T_C\n";
  {
    Program program({"compensate", toy_model(), "--quiet", "--state", file("state")});
    program.write(header);
    program.read_line();
    for (int i = 0; i <= 100; ++i) {
      program.write(std::to_string(10 * i) + ",6000,10,20.5\n");
      ASSERT_TRUE(program.read_line().starts_with(std::to_string(10 * i) + ","));
    }
    program.send(SIGKILL);
    EXPECT_EQ(program.wait().status, -SIGKILL);
  }
  const Result again = compensate(header + "1010,6000,10,20.5\n");
  EXPECT_EQ(again.status, 0) << again.err;
  double at = 0;
  const std::string words = "state at ";
  ASSERT_NE(again.err.find(words), std::string::npos) << again.err;
  at = std::stod(again.err.substr(again.err.find(words) + words.size()));
  EXPECT_GE(at, 940.0);
  EXPECT_LE(at, 1000.0);
}

TEST_F(State, WhatIsNoStateOfThisModelIsRefusedAndKept) {
  ASSERT_EQ(compensate(rows(0, 20)).status, 0);
  const std::string good = read(file("state"));
  const auto refused = [&](const std::string& bytes, const std::vector<std::string>& options, const char* words) {
    toy_.write("state", bytes);
    const Result result = compensate(rows(20, 40), options);
    EXPECT_EQ(result.status, 3) << words;
    EXPECT_EQ(result.out, "") << words;
    EXPECT_SAYS(result.err, words);
    EXPECT_SAYS(result.err, file("state"));
    EXPECT_SAYS(result.err, "allowed: ");
    EXPECT_EQ(read(file("state")), bytes) << words;
  };
  refused(good, {"--order", "5"}, "a state of another model");
  refused(good, {"--step", "30"}, "a state of another model, or of the same model with other options");
  refused(good.substr(0, good.size() - 8), {}, "cut off");
  refused("time_s\n", {}, "no saved state");
  std::string older = good;
  older[8] = 1;
  refused(older, {}, "another version");
  toy_.write("state", good);
  const Result backwards = compensate(rows(10, 20));
  EXPECT_EQ(backwards.status, 3);
  EXPECT_SAYS(backwards.err, "of the saved state");
  EXPECT_EQ(read(file("state")), good);
}

TEST_F(State, OneProcessGoesOnFromAState) {
  Program first({"compensate", toy_model(), "--quiet", "--state", file("state")});
  first.write("time_s\n0\n");
  first.read_line();
  first.read_line();
  const Result second = compensate("time_s\n0\n");
  EXPECT_EQ(second.status, 3);
  EXPECT_SAYS(second.err, "another process goes on from this state");
  EXPECT_EQ(first.wait().status, 0);
  EXPECT_EQ(compensate("time_s\n60\n").status, 0);
}

TEST_F(State, AFullDiskEndsNoControl) {
  ASSERT_EQ(compensate(rows(0, 20)).status, 0);
  const std::string before = read(file("state"));
  Surroundings full;
  full.largest_file = 1000;
  const Result result = compensate(rows(20, 40), {}, full);
  EXPECT_EQ(lines_of(result.out).size(), 21U);
  const std::size_t warned = result.err.find("warning: " + file("state"));
  ASSERT_NE(warned, std::string::npos) << result.err;
  EXPECT_EQ(result.err.find("warning: ", warned + 1), std::string::npos) << "said once";
  EXPECT_EQ(result.status, 3) << "the last state cannot be written either";
  EXPECT_EQ(read(file("state")), before);
}

TEST_F(State, APauseIsAMachineThatIsOffAndFortyDaysAreAColdStart) {
  const std::string header = "time_s,spindle.speed_rpm,air.T_C\n";
  std::string work = header;
  for (int minute = 0; minute <= 120; ++minute) work += fmt::format("{},6000,20\n", 60 * minute);
  ASSERT_EQ(compensate(work).status, 0);
  const std::string saved = read(file("state"));
  const Result night = compensate(header + "36000,0,20\n36060,0,20\n");
  EXPECT_EQ(night.status, 0) << night.err;
  EXPECT_SAYS(night.err, "pause of 28800 s since the saved state: computed as a machine that is off");
  toy_.write("state", saved);
  const Result late = compensate(header + "3463200,0,20\n");  // 40 days and 2 h
  EXPECT_EQ(late.status, 0) << late.err;
  EXPECT_SAYS(late.err, "40.0 days older than the first row");
  EXPECT_SAYS(late.err, "cold start");
  EXPECT_SAYS(late.out, "\n3463200,0.000,0.000,0.000,");
}

TEST_F(State, ASmallerOrderStatesALargerError) {
  const auto last_std = [](const std::string& out) {
    const std::vector<std::string> lines = lines_of(out);
    double std_x = 0;
    EXPECT_EQ(std::sscanf(lines.back().c_str(), "%*f,%*f,%*f,%*f,%lf", &std_x), 1) << lines.back();
    return std_x;
  };
  const Result whole = thermotwin({"compensate", toy_model()}, rows(0, 91)),
               small = thermotwin({"compensate", toy_model(), "--order", "4"}, rows(0, 91));
  ASSERT_EQ(small.status, 0) << small.err;
  EXPECT_SAYS(small.err, "order 4");
  EXPECT_GT(last_std(small.out), 1.01 * last_std(whole.out));
  const Result beyond = thermotwin({"compensate", toy_model(), "--order", "4000"}, rows(0, 2));
  EXPECT_EQ(beyond.status, 3);
  EXPECT_SAYS(beyond.err, "--order: 4000; allowed: 1 to ");
  const Result exported = thermotwin({"export", toy_model(), "--c", file("c"), "--order", "4", "--json"});
  EXPECT_EQ(exported.status, 0) << exported.err;
  EXPECT_SAYS(exported.out, "\"states\":4,");
}

}  // namespace
}  // namespace thermotwin::cases
