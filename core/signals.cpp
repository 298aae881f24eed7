// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/signals.h"

#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <pthread.h>
#include <string>
#include <sys/syscall.h>
#include <system_error>
#include <thread>
#include <ucontext.h>
#include <unistd.h>

namespace thermotwin::core {
namespace {

namespace fs = std::filesystem;

constexpr std::array<int, 2> ending_signals{SIGINT, SIGTERM};

sigset_t ending_set() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : ending_signals) sigaddset(&set, signal);
  return set;
}

extern "C" void open_in_child() {
  const sigset_t set = ending_set();
  ::pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

std::atomic<int> answers{0};

/// The mask in the context is the one that the thread goes on with.
extern "C" void block_in_this_thread(int, siginfo_t*, void* context) {
  for (const int signal : ending_signals) sigaddset(&static_cast<ucontext_t*>(context)->uc_sigmask, signal);
  answers.fetch_add(1);
}

/// Threads that libraries began before main (OpenBLAS does) kept the mask of that moment. Waits for their answer.
void block_in_older_threads() {
  const int ask = SIGRTMIN + 3;  // used by nobody else; stays handled, since a thread may be slow to take it
  struct sigaction action {};
  action.sa_sigaction = block_in_this_thread;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  sigemptyset(&action.sa_mask);
  if (::sigaction(ask, &action, nullptr) != 0) return;
  std::error_code error;
  int asked = 0;
  for (const fs::directory_entry& task : fs::directory_iterator("/proc/self/task", error)) {
    const std::string digits = task.path().filename().string();
    pid_t thread = 0;
    std::from_chars(digits.data(), digits.data() + digits.size(), thread);
    if (thread > 0 && thread != ::gettid() && ::syscall(SYS_tgkill, ::getpid(), thread, ask) == 0) ++asked;
  }
  // A thread that ends meanwhile does not answer.
  for (int patience = 0; answers < asked && patience < 200; ++patience)
    std::this_thread::sleep_for(std::chrono::microseconds(500));
}

}  // namespace

void take_ending_signals(void (*take)(int)) {
  struct sigaction action {};
  action.sa_handler = take;
  // Without this, files that a library reads or writes would fail half-way.
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : ending_signals) ::sigaction(signal, &action, nullptr);
  const sigset_t set = ending_set();
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
  ::pthread_atfork(nullptr, nullptr, open_in_child);
  std::thread([set, take] {
    for (int signal = 0;;)
      if (::sigwait(&set, &signal) == 0) take(signal);
  }).detach();
  block_in_older_threads();
}

void open_ending_signals(posix_spawnattr_t& attributes) {
  sigset_t none;
  sigemptyset(&none);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  ::posix_spawnattr_setsigmask(&attributes, &none);
}

}  // namespace thermotwin::core
