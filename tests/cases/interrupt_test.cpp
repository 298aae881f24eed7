// SPDX-License-Identifier: GPL-3.0-or-later
// Ctrl-C: exit status 130, what was finished stays, and --resume ends with the same bytes as a run
// that nobody stopped.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <csignal>
#include <fstream>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <tuple>
#include <unistd.h>

#include "tests/cases/nc_programs.h"
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
  EXPECT_EQ(left.size(), 12U) << "two loads with four tables, their fields and their stamp";
  for (const char* name : {"ambient/done", "ambient/tcp.csv", "warm_up/done", "warm_up/sensors.csv"})
    EXPECT_EQ(left.count(name), 1U) << name;
  const auto written = fs::last_write_time(toy.result("campaign/warm_up/tcp.csv"));

  arguments.push_back("--resume");
  const Result resumed = thermotwin(arguments);
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_EQ(fs::last_write_time(toy.result("campaign/warm_up/tcp.csv")), written) << "a finished load was run again";

  const std::string whole = toy.file("whole");
  ASSERT_EQ(thermotwin({"campaign", toy.path(), "--out", whole}).status, 0);
  const auto expected = results_in(whole), found = results_in(toy.out());
  EXPECT_EQ(changes(expected, found), std::vector<std::string>());
  EXPECT_EQ(found.size(), expected.size()) << "a checkpoint is left";
}

/// Names and bytes of a run's results but for the one file that tells how long it took.
std::map<std::string, std::string> timeless(const fs::path& folder) {
  auto files = results_in(folder);
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
  EXPECT_EQ(std::erase_if(after, [](const auto& file) { return file.first.starts_with("campaign/ambient/"); }), 6U);
  EXPECT_EQ(changes(before, after), std::vector<std::string>());
}

/// Programs that a signal finds where no loop asks for it: in a library, or waiting for a file.
struct Busy {
  const char* name;
  std::vector<std::string> arguments;
};

class InterruptAnywhere : public testing::TestWithParam<std::tuple<int, int>> {
protected:
  std::vector<Busy> all() {
    const std::string pipe = (folder_ / "pipe").string();
    EXPECT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    const std::string model = (toy_run() / "model.rom.h5").string(), out = (folder_ / "out").string();
    return {{"mesh", {"mesh", pipe, "--out", out}},
            {"offsets", {"offsets", "--chain", "V [w b Y X Z (C1) t]", "--in", pipe, "--out", out + "/offsets.csv"}},
            {"diagnose",
             {"diagnose", toy_case().string(), "--data", (toy_run() / "measurement").string(), "--model", model,
              "--out", out}},
            {"reduce", {"reduce", toy_case().string(), "--size", "0.7", "--out", out}},
            {"evaluate",
             {"evaluate", toy_case().string(), "--data", (toy_run() / "measurement").string(), "--model", model,
              "--length-study", "output_error", "dx@1", "--out", out}},
            {"validate", {"validate", toy_case().string(), "--model", model, "--draws", "20", "--out", out}},
            {"simulate", {"simulate", toy_case().string(), "--load", "mixed", "--size", "0.3", "--out", out}},
            {"export", {"export", toy_case().string(), "--matrices", "--size", "0.16", "--out", out}}};
  }
  const core::TemporaryFolder folder_;
};

TEST_P(InterruptAnywhere, EndsWithinTwoSeconds) {
  const auto [which, signal] = GetParam();
  const Busy busy = all()[which];
  Program program(busy.arguments);
  ASSERT_FALSE(program.ends_within(0.7)) << busy.name << " needs more to do";
  program.send(signal);
  EXPECT_TRUE(program.ends_within(2.0)) << busy.name;
  program.send(SIGKILL);
  const Result result = program.wait();
  EXPECT_EQ(result.status, 130) << busy.name << ": " << result.err;
  EXPECT_SAYS(result.err, "interrupted");
  for (const auto& [file, bytes] : files_in(folder_ / "out")) EXPECT_EQ(file.find("part-"), std::string::npos) << file;
}

INSTANTIATE_TEST_SUITE_P(Verbs, InterruptAnywhere,
                         testing::Combine(testing::Range(0, 8), testing::Values(SIGINT, SIGTERM)));

// A killed program cannot tidy up; the next one does, and leaves alone what another writes meanwhile.
TEST(Interrupt, PartsOfKilledProgramsGo) {
  const Toy toy;
  toy.take_results();
  std::array<char, 256> host{};
  ASSERT_EQ(::gethostname(host.data(), host.size() - 1), 0);
  const std::string here = std::string("part-") + host.data() + "-";
  const pid_t ended = ::fork();
  if (ended == 0) ::_exit(0);
  ::waitpid(ended, nullptr, 0);
  const std::string dead = here + std::to_string(ended), alive = here + std::to_string(::getpid());
  for (const std::string& name :
       {"cache/bed." + dead + ".mesh", "campaign/ambient/" + dead + "/tcp.csv", "cache/bed." + alive + ".mesh"}) {
    fs::create_directories(toy.result(name).parent_path());
    std::ofstream(toy.result(name)) << "half";
  }
  ASSERT_EQ(toy.run({"campaign", toy.path(), "--load", "ambient"}).status, 0);
  EXPECT_FALSE(fs::exists(toy.result("cache/bed." + dead + ".mesh")));
  EXPECT_FALSE(fs::exists(toy.result("campaign/ambient/" + dead)));
  EXPECT_TRUE(fs::exists(toy.result("cache/bed." + alive + ".mesh"))) << "another program writes it";
}

// A campaign of other loads does not know whether the checkpoint will be asked for; the next run of its load does.
TEST(Interrupt, ACheckpointOfAKilledLoadStaysUntilThisLoadRuns) {
  const Toy toy;
  toy.edit("loads/mixed.toml", "time_step_s = 120", "time_step_s = 15");
  const fs::path checkpoint = toy.result("campaign/checkpoint_mixed.bin");
  Program killed({"campaign", toy.path(), "--load", "mixed", "--checkpoint-every", "0", "--out", toy.out()});
  while (!fs::exists(checkpoint) && killed.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  killed.send(SIGKILL);
  EXPECT_EQ(killed.wait().status, -SIGKILL);
  const std::string kept = read(checkpoint);
  ASSERT_FALSE(kept.empty());

  ASSERT_EQ(toy.run({"campaign", toy.path(), "--load", "ambient"}).status, 0);
  EXPECT_TRUE(fs::exists(toy.result("campaign/ambient/done")));
  EXPECT_EQ(read(checkpoint), kept);
  ASSERT_EQ(toy.run({"campaign", toy.path(), "--load", "mixed"}).status, 0);
  EXPECT_FALSE(fs::exists(checkpoint));
  for (const auto& [file, bytes] : files_in(toy.result("campaign"))) EXPECT_FALSE(is_checkpoint(file)) << file;
}

// OpenBLAS waits for memory without end, at exit too.
TEST(OutOfMemory, EndsWithAMessage) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer's shadow needs the address space";
#endif
  int failed = 0;
  for (const std::uint64_t megabytes : {300, 350, 400, 600, 700, 800}) {
    const core::TemporaryFolder folder;
    Surroundings surroundings;
    surroundings.memory = megabytes << 20;
    for (const char* solver : {"direct", "iterative"}) {
      Program program({"reduce", toy_case().string(), "--solver", solver, "--out", (folder / "out").string()},
                      surroundings);
      EXPECT_TRUE(program.ends_within(30.0)) << megabytes << " MB, " << solver;
      program.send(SIGKILL);
      const Result result = program.wait();
      if (result.status == 0) continue;
      ++failed;
      EXPECT_EQ(result.status, 4) << megabytes << " MB, " << solver << ": " << result.err;
      EXPECT_SAYS(result.err, "memory");
      for (const auto& [file, bytes] : files_in(folder / "out"))
        EXPECT_EQ(file.find("part-"), std::string::npos) << file;
    }
  }
  EXPECT_GT(failed, 0) << "none of the limits was one";
}

// A program that reads long, and one that stands long: no file appears, and the helper ends as well.
TEST(Interrupt, AnNcProgram) {
  if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
  const Toy toy;
  toy.write("reads.ngc", "G21 G90\no1 while [1]\nG0 X1\nG0 X2\no1 endwhile\nM2\n");
  toy.write("stands.ngc", "G21 G90\no1 repeat [1000000]\nG4 P80000\no1 endrepeat\nM2\n");
  for (const char* name : {"reads.ngc", "stands.ngc"}) {
    Program program({"nc", toy.file("machine.toml"), toy.file(name), "--out", toy.out()});
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    ASSERT_TRUE(program.is_running()) << name;
    program.send(SIGINT);
    expect_interrupted(program.wait());
    EXPECT_TRUE(files_in(toy.out()).empty()) << name;
  }
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
