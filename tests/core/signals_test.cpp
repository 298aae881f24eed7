// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/signals.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "core/error.h"
#include "core/progress.h"

namespace thermotwin::core {
namespace {

void be_a_library(int) { std::_Exit(9); }

[[noreturn]] void work_until_interrupted() {
  try {
    for (;;) check_interrupt();
  } catch (const Interrupted& interrupted) {
    std::_Exit(interrupted.exit_status());
  }
}

// METIS installs a handler of its own and jumps out of it: a signal was lost with it, and an ordering was damaged.
TEST(SignalsDeathTest, ALibraryWithItsOwnHandlerDoesNotGetThem) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  for (const int signal : {SIGINT, SIGTERM}) {
    EXPECT_EXIT(
        {
          install_interrupt_handler();
          std::signal(signal, be_a_library);
          ::kill(::getpid(), signal);
          work_until_interrupted();
        },
        testing::ExitedWithCode(130), "");
  }
}

TEST(SignalsDeathTest, AThreadFromBeforeDoesNotGetThem) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        std::thread([] {
          for (;;) ::pause();
        }).detach();
        install_interrupt_handler();
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        std::signal(SIGTERM, be_a_library);
        ::kill(::getpid(), SIGTERM);
        work_until_interrupted();
      },
      testing::ExitedWithCode(130), "");
}

int ending_of(pid_t child) {
  ::kill(child, SIGTERM);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

[[noreturn]] void end_children() {
  install_interrupt_handler();
  const pid_t forked = ::fork();
  if (forked == 0) {
    std::signal(SIGTERM, SIG_DFL);
    std::this_thread::sleep_for(std::chrono::seconds(5));
    ::_exit(0);
  }
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  open_ending_signals(attributes);
  char sleep[] = "sleep", seconds[] = "5";
  char* words[] = {sleep, seconds, nullptr};
  pid_t spawned = 0;
  if (::posix_spawnp(&spawned, sleep, nullptr, &attributes, words, environ) != 0) std::_Exit(2);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  std::_Exit(ending_of(forked) == SIGTERM && ending_of(spawned) == SIGTERM ? 0 : 1);
}

// A child that kept them blocked would live on when its terminal or its job is ended.
TEST(SignalsDeathTest, ChildrenReceiveThem) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(end_children(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace thermotwin::core
