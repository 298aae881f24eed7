// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/thread_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <ctime>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/error.h"

namespace thermotwin::core {
namespace {

class ThreadPool : public testing::TestWithParam<int> {
protected:
  void SetUp() override { set_thread_count(GetParam()); }
  void TearDown() override { set_thread_count(0); }
};

TEST_P(ThreadPool, CountIsAsSet) { EXPECT_EQ(thread_count(), GetParam()); }

TEST_P(ThreadPool, VisitsEachIndexOnce) {
  for (const std::size_t grain : {1, 3, 7, 1000, 5000}) {
    std::vector<std::atomic<int>> visits(1003);
    parallel_for(
        3, visits.size(), [&](std::size_t i) { ++visits[i]; }, grain);
    for (std::size_t i = 0; i < visits.size(); ++i) ASSERT_EQ(visits[i], i < 3 ? 0 : 1) << i;
  }
}

TEST_P(ThreadPool, EmptyAndReversedRangesDoNothing) {
  parallel_for(5, 5, [](std::size_t) { FAIL(); });
  parallel_for(6, 5, [](std::size_t) { FAIL(); });
}

TEST_P(ThreadPool, NestedCallsFinish) {
  std::atomic<int> leaves{0};
  parallel_for(0, 8, [&](std::size_t) {
    parallel_for(0, 8, [&](std::size_t) { parallel_for(0, 8, [&](std::size_t) { ++leaves; }); });
  });
  EXPECT_EQ(leaves, 512);
}

TEST_P(ThreadPool, RethrowsTheSmallestFailure) {
  for (int repeat = 0; repeat < 50; ++repeat) {
    std::atomic<int> running{0};
    std::string message;
    try {
      parallel_for(0, 200, [&](std::size_t i) {
        ++running;
        // The smaller failure comes later in time.
        if (i == 17) std::this_thread::sleep_for(std::chrono::microseconds(200));
        --running;
        if (i == 17 || i == 18 || i == 60) throw std::runtime_error(std::to_string(i));
      });
    } catch (const std::runtime_error& error) {
      message = error.what();
    }
    EXPECT_EQ(message, "17");
    EXPECT_EQ(running, 0);
  }
  // The pool is as good as before.
  std::atomic<int> count{0};
  parallel_for(0, 100, [&](std::size_t) { ++count; });
  EXPECT_EQ(count, 100);
}

TEST_P(ThreadPool, ExceptionOfANestedCallReachesTheOuterCaller) {
  EXPECT_THROW(parallel_for(0, 4,
                            [](std::size_t i) {
                              parallel_for(0, 4, [i](std::size_t j) {
                                if (i == 2 && j == 3) throw SolverError("inner");
                              });
                            }),
               SolverError);
}

TEST_P(ThreadPool, ReduceGivesTheSameBitsAsOneThread) {
  const auto sum = [] {
    return parallel_reduce(
        1, 100000, 64, 0.0,
        [](std::size_t first, std::size_t last) {
          double part = 0.0;
          for (std::size_t i = first; i < last; ++i) part += std::sin(1e3 * i) / 3.0;
          return part;
        },
        [](double left, double right) { return left + right; });
  };
  const double result = sum();
  set_thread_count(1);
  EXPECT_EQ(result, sum());
}

TEST_P(ThreadPool, ReduceFoldsInOrder) {
  const std::string text = parallel_reduce(
      0, 26, 4, std::string(),
      [](std::size_t first, std::size_t last) {
        std::string part;
        for (std::size_t i = first; i < last; ++i) part += static_cast<char>('a' + static_cast<int>(i));
        return part;
      },
      [](std::string left, const std::string& right) { return left + right; });
  EXPECT_EQ(text, "abcdefghijklmnopqrstuvwxyz");
}

TEST_P(ThreadPool, CallersOfSeveralThreadsDoNotDisturbEachOther) {
  std::vector<std::thread> callers;
  std::atomic<int> total{0};
  for (int c = 0; c < 3; ++c) {
    callers.emplace_back([&] {
      for (int repeat = 0; repeat < 200; ++repeat) {
        int own[16] = {};
        parallel_for(0, 16, [&](std::size_t i) { own[i] = 1; });
        for (const int one : own) total += one;
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(total, 3 * 200 * 16);
}

INSTANTIATE_TEST_SUITE_P(Counts, ThreadPool, testing::Values(1, 2, 3, 8));

TEST(ThreadPoolThreads, WorkIsShared) {
  set_thread_count(4);
  std::mutex mutex;
  std::set<std::thread::id> seen;
  std::atomic<int> waiting{0};
  // Each body waits for a second one to be there: only two threads at once can end this early.
  parallel_for(0, 4, [&](std::size_t) {
    ++waiting;
    for (int i = 0; i < 2000 && waiting < 2; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::lock_guard lock(mutex);
    seen.insert(std::this_thread::get_id());
  });
  EXPECT_GE(seen.size(), 2U);
  set_thread_count(0);
}

TEST(ThreadPoolThreads, IdleThreadsDoNotBurnTime) {
  set_thread_count(4);
  parallel_for(0, 100, [](std::size_t) {});
  const std::clock_t before = std::clock();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const double used = 1.0 * (std::clock() - before) / CLOCKS_PER_SEC;
  EXPECT_LT(used, 0.1);
  set_thread_count(0);
}

TEST(ThreadPoolThreads, ZeroIsAllCoresAndNonsenseIsRefused) {
  set_thread_count(0);
  EXPECT_EQ(thread_count(), static_cast<int>(std::thread::hardware_concurrency()));
  EXPECT_THROW(set_thread_count(-1), UsageError);
  EXPECT_THROW(set_thread_count(100000), UsageError);
}

}  // namespace
}  // namespace thermotwin::core
