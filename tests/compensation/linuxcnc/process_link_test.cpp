// SPDX-License-Identifier: GPL-3.0-or-later
// The process that answers rows, with /bin/cat as the model. Times are those that the caller states.
#include "compensation/linuxcnc/exported/process_link.h"

#include <gtest/gtest.h>

#include <csignal>
#include <string>
#include <unistd.h>

namespace thermotwin::compensation {
namespace {

class ProcessLink : public ::testing::Test {
protected:
  ProcessLink() { process_link_begin(&link_, "test", arguments_); }
  ~ProcessLink() override { process_link_end(&link_, 0.5); }

  /// Sends a row at a time and waits for the answer.
  std::string row(const std::string& text, double now) {
    process_link_tend(&link_, now);
    if (process_link_send(&link_, text.data(), text.size(), now) == 0) return "not sent";
    process_link_tend(&link_, now);
    std::string got;
    char bytes[256];
    while (got.size() < text.size()) {
      const std::size_t count = process_link_read(&link_, bytes, sizeof bytes, 2000);
      if (count == 0) return got;
      got.append(bytes, count);
    }
    process_link_answered(&link_, now);
    return got;
  }
  /// Tends at a time until the process has been replaced; at most the wait before a start passes.
  bool is_replaced(double now) {
    const unsigned starts = link_.starts;
    for (int i = 0; i < 100; ++i) {
      process_link_tend(&link_, now + 0.01 * i);
      if (link_.starts > starts) return true;
      ::usleep(5000);
    }
    return false;
  }

  const char* arguments_[2] = {"/bin/cat", nullptr};
  process_link link_{};
};

// Rows may stop for hours: a healthy model is not ended by the first row that comes after it.
TEST_F(ProcessLink, APauseWithoutRowsIsNoSilence) {
  EXPECT_EQ(row("one\n", 100.0), "one\n");
  const pid_t before = link_.process;
  process_link_tend(&link_, 5000.0);
  EXPECT_EQ(row("two\n", 9000.0), "two\n");
  EXPECT_EQ(link_.process, before);
  EXPECT_EQ(link_.starts, 1U);
}

TEST_F(ProcessLink, OneThatHangsIsEndedAndStartedAgain) {
  EXPECT_EQ(row("one\n", 100.0), "one\n");
  EXPECT_EQ(row("two\n", 100.5), "two\n") << "a start has more patience";
  ::kill(link_.process, SIGSTOP);
  EXPECT_EQ(process_link_send(&link_, "dead\n", 5, 101.0), 1);
  EXPECT_FALSE(is_replaced(102.0 - 0.5)) << "less than two seconds";
  testing::internal::CaptureStderr();
  for (int i = 0; i < 5; ++i) process_link_tend(&link_, 103.4);
  EXPECT_TRUE(is_replaced(103.5));
  const std::string said = testing::internal::GetCapturedStderr();
  const std::size_t first = said.find("no longer answers");
  ASSERT_NE(first, std::string::npos) << said;
  EXPECT_EQ(said.find("no longer answers", first + 1), std::string::npos) << "once: " << said;
  EXPECT_EQ(row("three\n", 106.0), "three\n");
}

// A row is always under way, each answered a second after it: that is no silence.
TEST_F(ProcessLink, OneThatAnswersASecondLateIsHealthy) {
  EXPECT_EQ(row("one\n", 100.0), "one\n");
  ASSERT_EQ(process_link_send(&link_, "row\n", 4, 101.0), 1);
  char bytes[16];
  for (double now = 102.0; now < 112.0; now += 1.0) {
    ASSERT_EQ(process_link_send(&link_, "row\n", 4, now), 1);
    ASSERT_GT(process_link_read(&link_, bytes, 4, 2000), 0U);
    process_link_answered(&link_, now);
    ::usleep(2000);
    process_link_tend(&link_, now);
  }
  EXPECT_FALSE(is_replaced(112.0));
}

TEST_F(ProcessLink, AStartMayTakeHalfAMinute) {
  process_link_tend(&link_, 1.0);
  ::kill(link_.process, SIGSTOP);
  EXPECT_EQ(process_link_send(&link_, "one\n", 4, 1.5), 1);
  EXPECT_FALSE(is_replaced(30.0));
  EXPECT_TRUE(is_replaced(32.0));
}

TEST_F(ProcessLink, OneThatIsKilledIsStartedAgain) {
  EXPECT_EQ(row("one\n", 1.0), "one\n");
  ::kill(link_.process, SIGKILL);
  EXPECT_TRUE(is_replaced(1.1));
  EXPECT_EQ(link_.last_status, -1);
  EXPECT_EQ(row("two\n", 4.0), "two\n");
}

TEST_F(ProcessLink, SendsNoMoreThanTheProcessKeepsUpWith) {
  process_link_tend(&link_, 1.0);
  ::kill(link_.process, SIGSTOP);
  int sent = 0;
  while (sent < 100 && process_link_send(&link_, "x\n", 2, 1.0) != 0) ++sent;
  EXPECT_EQ(sent, 16);
}

}  // namespace
}  // namespace thermotwin::compensation
