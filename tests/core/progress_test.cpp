// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/progress.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <unistd.h>

#include "core/error.h"
#include "core/muted_warnings.h"
#include "core/thread_pool.h"

namespace thermotwin::core {
namespace {

TEST(Progress, QuietSilencesLogLinesButNotWarnings) {
  testing::internal::CaptureStderr();
  log_line("thermal: 12 steps");
  set_quiet(true);
  EXPECT_TRUE(is_quiet());
  log_line("hidden");
  warn("film bed.skin is not used");
  set_quiet(false);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "thermal: 12 steps\nwarning: film bed.skin is not used\n");
}

TEST(Progress, MutedWarningsAreNotWritten) {
  testing::internal::CaptureStderr();
  {
    const MutedWarnings outer;
    warn("of no concern");
    { const MutedWarnings inner; }
    warn("of no concern either");
  }
  warn("of concern");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: of concern\n");
}

TEST(Progress, ShortWorkSaysNothing) {
  testing::internal::CaptureStderr();
  {
    Progress progress("short", 100);
    parallel_for(0, 100, [&](std::size_t) { progress.advance(); });
  }
  if (::isatty(STDERR_FILENO) != 0) GTEST_SKIP() << "stderr is a terminal";
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(ProgressDeathTest, FirstSignalIsSeenByTheLoop) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        install_interrupt_handler();
        check_interrupt();
        ::kill(::getpid(), SIGINT);
        try {
          Progress progress("loop", 3);
          for (;;) progress.advance();
        } catch (const Interrupted& interrupted) {
          std::fputs("stopped in the loop", stderr);
          std::_Exit(interrupted.exit_status());
        }
      },
      testing::ExitedWithCode(130), "stopped in the loop");
}

TEST(ProgressDeathTest, SecondSignalEndsAtOnce) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "ThreadSanitizer waits for a second as a process ends";
#endif
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        install_interrupt_handler();
        ::kill(::getpid(), SIGTERM);
        ::kill(::getpid(), SIGINT);
        std::this_thread::sleep_for(std::chrono::seconds(1));  // less than a first signal alone is given
        std::_Exit(1);
      },
      testing::ExitedWithCode(130), "");
}

TEST(Errors, ExitStatus) {
  EXPECT_EQ(UsageError("x").exit_status(), 2);
  EXPECT_EQ(InputError("x").exit_status(), 3);
  EXPECT_EQ(MeshError("x").exit_status(), 3);
  EXPECT_EQ(SolverError("x").exit_status(), 4);
  EXPECT_EQ(Interrupted().exit_status(), 130);
  EXPECT_STREQ(InputError("m.toml:3 a", "7", "0 to 5").what(), "m.toml:3 a: 7; allowed: 0 to 5");
}

}  // namespace
}  // namespace thermotwin::core
