// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <new>
#include <string>
#include <thread>

#include "core/error.h"

namespace thermotwin::core {
namespace {

constexpr int max_thread_count = 1024;

/// Call in a catch block. A handler of exhausted memory that ends the process is asked before others
/// are waited for, which may want memory too; Eigen throws without asking it.
void heed_memory_handler() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    if (const auto handler = std::get_new_handler()) handler();
  } catch (...) {}
}

/// One parallel_for. It lives on its caller's stack, which the caller leaves only once the pool has
/// forgotten the job and no worker is in it any more.
struct Job {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t grain = 1;
  std::size_t block_count = 0;
  const std::function<void(std::size_t)>* body = nullptr;

  std::atomic<std::size_t> next_block{0};
  int workers_inside = 0;  // guarded by the pool's mutex
  std::condition_variable all_left;

  std::mutex error_mutex;
  std::size_t error_block = 0;
  std::exception_ptr error;

  bool has_work() const { return next_block.load(std::memory_order_relaxed) < block_count; }

  void work() {
    while (has_work()) {
      const std::size_t block = next_block.fetch_add(1, std::memory_order_relaxed);
      if (block >= block_count) return;
      const std::size_t first = begin + block * grain;
      const std::size_t last = end - first > grain ? first + grain : end;
      try {
        for (std::size_t i = first; i < last; ++i) (*body)(i);
      } catch (...) {
        heed_memory_handler();
        // Blocks are handed out in rising order, so every smaller block has begun already and the
        // smallest that fails is the same for any number of threads; larger ones may be dropped.
        next_block.store(block_count, std::memory_order_relaxed);
        const std::lock_guard lock(error_mutex);
        if (!error || block < error_block) {
          error = std::current_exception();
          error_block = block;
        }
      }
    }
  }
};

int all_cores() { return std::clamp<int>(std::thread::hardware_concurrency(), 1, max_thread_count); }

class Pool {
public:
  Pool() { start(all_cores()); }
  ~Pool() { stop(); }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  int thread_count() const { return thread_count_.load(std::memory_order_relaxed); }

  void restart(int count) {
    if (count == thread_count()) return;
    stop();
    start(count);
  }

  void run(Job& job) {
    {
      const std::lock_guard lock(mutex_);
      jobs_.push_back(&job);
    }
    const std::size_t helpers = std::min(job.block_count - 1, workers_.size());
    for (std::size_t i = 0; i < helpers; ++i) work_or_stop_.notify_one();
    job.work();
    std::unique_lock lock(mutex_);
    jobs_.erase(std::find(jobs_.begin(), jobs_.end(), &job));
    job.all_left.wait(lock, [&] { return job.workers_inside == 0; });
  }

private:
  void start(int count) {
    stopping_ = false;
    for (int i = 1; i < count; ++i) workers_.emplace_back([this] { worker(); });
    thread_count_.store(count, std::memory_order_relaxed);
  }

  void stop() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    work_or_stop_.notify_all();
    for (std::thread& thread : workers_) thread.join();
    workers_.clear();
  }

  /// The youngest job first: it is the innermost, and others wait for it.
  Job* job_with_work() const {
    for (auto job = jobs_.rbegin(); job != jobs_.rend(); ++job) {
      if ((*job)->has_work()) return *job;
    }
    return nullptr;
  }

  void worker() {
    std::unique_lock lock(mutex_);
    for (;;) {
      Job* job = nullptr;
      work_or_stop_.wait(lock, [&] { return (job = job_with_work()) != nullptr || stopping_; });
      if (job == nullptr) return;
      ++job->workers_inside;
      lock.unlock();
      job->work();
      lock.lock();
      // Under the lock: once it is released the caller may destroy the job.
      if (--job->workers_inside == 0) job->all_left.notify_one();
    }
  }

  std::mutex mutex_;
  std::condition_variable work_or_stop_;
  std::vector<Job*> jobs_;
  bool stopping_ = false;
  std::vector<std::thread> workers_;
  std::atomic<int> thread_count_{1};
};

Pool& pool() {
  static Pool instance;
  return instance;
}

}  // namespace

void set_thread_count(int count) {
  if (count < 0 || count > max_thread_count) {
    throw UsageError("--threads " + std::to_string(count) + ": allowed: 0 (all cores) to " +
                     std::to_string(max_thread_count));
  }
  pool().restart(count == 0 ? all_cores() : count);
}

int thread_count() { return pool().thread_count(); }

void parallel_for(std::size_t begin, std::size_t end, const std::function<void(std::size_t)>& body, std::size_t grain) {
  if (end <= begin) return;
  grain = std::max<std::size_t>(grain, 1);
  if (end - begin <= grain || pool().thread_count() == 1) {
    for (std::size_t i = begin; i < end; ++i) body(i);
    return;
  }
  Job job;
  job.begin = begin;
  job.end = end;
  job.grain = grain;
  job.block_count = (end - begin - 1) / grain + 1;
  job.body = &body;
  pool().run(job);
  if (job.error) std::rethrow_exception(job.error);
}

}  // namespace thermotwin::core
