// SPDX-License-Identifier: GPL-3.0-or-later
// Two programs on one --out: units of their own are welcome, the same unit is refused.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "core/folder_lock.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;

void wait_for(Program& program, const fs::path& file) {
  while (!fs::exists(file) && program.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ASSERT_TRUE(program.is_running()) << "it ended before " << file;
}

TEST(Lock, ASecondProgramOnAUnitIsRefused) {
  const Toy toy;
  toy.edit("loads/mixed.toml", "time_step_s = 120", "time_step_s = 2");  // keeps the first program busy
  const std::vector<std::string> mixed{"campaign", toy.path(), "--load", "mixed", "--out", toy.out()};
  Program first(mixed);
  wait_for(first, toy.result("campaign/mixed/lock"));
  const Result second = thermotwin(mixed);
  EXPECT_EQ(second.status, 3) << second.err;
  for (const char* words : {"campaign/mixed", "process ", "writes here", "another --out"})
    EXPECT_SAYS(second.err, words);
  EXPECT_EQ(thermotwin({"campaign", toy.path(), "--load", "ambient", "--out", toy.out()}).status, 0)
      << "a unit of its own";
  first.send(SIGKILL);
  EXPECT_EQ(first.wait().status, -SIGKILL);
  toy.edit("loads/mixed.toml", "time_step_s = 2", "time_step_s = 600");
  const Result again = thermotwin(mixed);
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_FALSE(fs::exists(toy.result("campaign/mixed/lock")));
}

TEST(Lock, TwoReductionsDoNotMix) {
  const Toy toy;
  const std::vector<std::string> reduce{"reduce", toy.path(), "--out", toy.out()};
  Program first(reduce);
  wait_for(first, toy.result("lock"));
  const Result second = thermotwin(reduce);
  EXPECT_EQ(second.status, 3) << second.err;
  EXPECT_SAYS(second.err, "writes here");
  EXPECT_EQ(first.wait().status, 0);
}

TEST(Lock, TwoDiagnosesDoNotMix) {
  const Toy toy;
  toy.take_results();
  const std::vector<std::string> diagnose{"diagnose", toy.path(),
                                          "--model",  toy.result("model.rom.h5").string(),
                                          "--data",   (toy_run() / "measurement").string(),
                                          "--out",    toy.out()};
  {
    const core::FolderLock held(toy.result("diagnosis"));
    const Result second = thermotwin(diagnose);
    EXPECT_EQ(second.status, 3) << second.err;
    EXPECT_SAYS(second.err, "writes here");
  }
  EXPECT_EQ(thermotwin(diagnose).status, 0);
  EXPECT_FALSE(fs::exists(toy.result("diagnosis/lock")));
}

}  // namespace
}  // namespace thermotwin::cases
