// SPDX-License-Identifier: GPL-3.0-or-later
// Ctrl-C: exit status 130, what was finished stays, and --resume ends with the same bytes as a run
// that nobody stopped.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;

/// Sends SIGINT once the file is there. @return how the program ended
Result stop_when(Program& program, const fs::path& file) {
  // There from an earlier run: the program has to come to what follows.
  if (fs::exists(file)) std::this_thread::sleep_for(std::chrono::milliseconds(500));
  while (!fs::exists(file) && program.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_TRUE(program.is_running()) << "it ended before it could be stopped";
  program.send(SIGINT);
  return program.wait();
}

void expect_interrupted(const Result& result) {
  EXPECT_EQ(result.status, 130) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_SAYS(result.err, "interrupted");
}

TEST(Interrupt, ACampaignGoesOnWhereItStopped) {
  const Toy toy;
  // Long enough to be stopped in.
  toy.edit("loads/mixed.toml", "time_step_s = 120", "time_step_s = 5");
  const std::vector<std::string> campaign{"campaign", toy.path()};
  std::vector<std::string> arguments = campaign;
  arguments.insert(arguments.end(), {"--out", toy.out()});
  Program program(arguments);
  expect_interrupted(stop_when(program, toy.result("campaign/warm_up/done")));

  auto left = files_in(toy.result("campaign"));
  EXPECT_GT(std::erase_if(left, [](const auto& file) { return is_checkpoint(file.first); }), 0U);
  EXPECT_EQ(left.size(), 10U) << "two loads with four tables and their stamp";
  for (const char* name : {"ambient/done", "ambient/tcp.csv", "warm_up/done", "warm_up/sensors.csv"}) EXPECT_EQ(left.count(name), 1U) << name;
  const auto written = fs::last_write_time(toy.result("campaign/warm_up/tcp.csv"));

  arguments.push_back("--resume");
  const Result resumed = thermotwin(arguments);
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_EQ(fs::last_write_time(toy.result("campaign/warm_up/tcp.csv")), written) << "a finished load was run again";

  const std::string whole = toy.file("whole");
  ASSERT_EQ(thermotwin({"campaign", toy.path(), "--out", whole}).status, 0);
  EXPECT_EQ(files_in(toy.result("campaign")), files_in(fs::path(whole) / "campaign"));
}

/// Names and bytes of a run's results but for the one file that tells how long it took.
std::map<std::string, std::string> timeless(const fs::path& folder) {
  auto files = files_in(folder);
  EXPECT_EQ(files.erase("summary.json"), 1U);
  files.erase("machine.png");
  return files;
}

// Stopped in the campaign, then in the reduction, then let go to its end.
TEST(Interrupt, ARunGoesOnWhereItStopped) {
  const Toy toy;
  const std::vector<std::string> arguments{"run", toy_case().string(), "--resume", "--out", toy.out()};
  for (const char* finished : {"campaign/mixed/done", "campaign/warm_up/done"}) {
    Program program(arguments);
    expect_interrupted(stop_when(program, toy.result(finished)));
    for (const char* later : {"model.rom.h5", "summary.json"}) EXPECT_FALSE(fs::exists(toy.result(later))) << later;
  }
  const auto written = fs::last_write_time(toy.result("campaign/warm_up/tcp.csv"));
  const Result resumed = thermotwin(arguments);
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_EQ(fs::last_write_time(toy.result("campaign/warm_up/tcp.csv")), written) << "a finished load was run again";
  const auto expected = timeless(toy_run()), found = timeless(toy.out());
  EXPECT_EQ(changes(expected, found), std::vector<std::string>());
  EXPECT_EQ(found.size(), expected.size()) << "a checkpoint is left";
}

TEST(Interrupt, EarlierResultsStay) {
  const Toy toy;
  toy.take_results();
  auto before = files_in(toy.out());
  toy.edit("loads/mixed.toml", "time_step_s = 120", "time_step_s = 5");
  fs::remove_all(toy.result("campaign/ambient"));
  std::erase_if(before, [](const auto& file) { return file.first.starts_with("campaign/ambient/"); });
  Program program({"campaign", toy.path(), "--load", "ambient", "--load", "mixed", "--out", toy.out()});
  expect_interrupted(stop_when(program, toy.result("campaign/ambient/done")));
  auto after = files_in(toy.out());
  EXPECT_EQ(std::erase_if(after, [](const auto& file) { return file.first.starts_with("campaign/ambient/"); }), 5U);
  EXPECT_EQ(changes(before, after), std::vector<std::string>());
}

// A control that is switched off sends no more rows: the compensator must not wait for one.
TEST(Interrupt, ACompensatorThatWaits) {
  Program program({"compensate", (toy_run() / "model.rom.h5").string(), "--quiet"});
  program.write("time_s,spindle.speed_rpm\n0,6000\n");
  EXPECT_TRUE(program.read_line().starts_with("time_s,"));
  EXPECT_TRUE(program.read_line().starts_with("0,"));
  program.send(SIGINT);
  const auto from = std::chrono::steady_clock::now();
  while (program.is_running() && std::chrono::steady_clock::now() - from < std::chrono::seconds(20))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_FALSE(program.is_running()) << "it still waits";
  EXPECT_EQ(program.wait().status, 130);
}

}  // namespace
}  // namespace thermotwin::cases
