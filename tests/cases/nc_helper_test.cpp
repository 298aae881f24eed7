// SPDX-License-Identifier: GPL-3.0-or-later
// Helper processes that crash or hang: a copy of the program finds a script beside it in place of the interpreter.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <sys/wait.h>

#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;

class NcHelper : public testing::Test {
protected:
  void SetUp() override {
    fs::create_directories(toy.path() + "/program");
    fs::copy_file(THERMOTWIN_PROGRAM, toy.file("program/thermotwin"));
    toy.write("part.ngc", "G21 G90\nG0 Z60\nG1 X20 F500\nM2\n");
    toy.write("control.toml", "schema = 1\n[limits]\nseconds = 1\n");
  }
  /// `nc` with a helper of these lines. @return its exit status
  int run_with(const std::string& lines) const {
    toy.write("program/thermotwin_rs274", "#!/bin/sh\n" + lines);
    fs::permissions(toy.file("program/thermotwin_rs274"), fs::perms::owner_all);
    const std::string command = fmt::format(
        "'{}' nc '{}' '{}' --control '{}' --out '{}' > '{}' 2> '{}'", toy.file("program/thermotwin"), toy.path(),
        toy.file("part.ngc"), toy.file("control.toml"), toy.out(), toy.file("out.txt"), toy.file("err.txt"));
    return WEXITSTATUS(std::system(command.c_str()));
  }
  std::string said() const { return read(toy.file("err.txt")); }
  Toy toy;
};

TEST_F(NcHelper, ACrashIsNamedAndLeavesNothing) {
  EXPECT_EQ(run_with("kill -SEGV $$\n"), 3);
  EXPECT_SAYS(said(), "part.ngc:1: the interpreter was ended by signal 11; allowed: ");
  EXPECT_TRUE(files_in(toy.out()).empty());
  // Behind the begin of line 3: kind, index, mask and line of a record.
  EXPECT_EQ(run_with("printf '\\001\\000\\000\\000\\003\\000\\000\\000'\nkill -ABRT $$\n"), 3);
  EXPECT_SAYS(said(), "part.ngc:3: the interpreter was ended by signal 6; allowed: ");
  EXPECT_TRUE(files_in(toy.out()).empty());
  EXPECT_EQ(run_with("exit 0\n"), 3);
  EXPECT_SAYS(said(), "part.ngc:1: the interpreter ended before the program; allowed: ");
  EXPECT_TRUE(files_in(toy.out()).empty());
}

// It takes no processor time, so its own limit does not end it: the program waits for 30 s longer.
TEST_F(NcHelper, AHangIsEndedAndLeavesNothing) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(run_with("echo $$ > pid\nexec sleep 600\n"), 3);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  EXPECT_GT(seconds.count(), 31.0);
  EXPECT_LT(seconds.count(), 60.0);
  EXPECT_SAYS(said(), "part.ngc:1: the interpreter hangs; allowed: ");
  EXPECT_TRUE(files_in(toy.out()).empty());
  const int helper = std::stoi(read(toy.file("pid")));
  EXPECT_NE(kill(helper, 0), 0) << "the helper runs on";
}

}  // namespace
}  // namespace thermotwin::cases
