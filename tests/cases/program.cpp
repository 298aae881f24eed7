// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cases/program.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <stdexcept>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace thermotwin::cases {
namespace {

constexpr std::int64_t patience_ms = 120'000;

std::int64_t now_ms() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

struct Pipe {
  int read = -1, write = -1;
  Pipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
    read = ends[0];
    write = ends[1];
  }
};

/// The environment without what a developer's shell would change results by.
std::vector<std::string> environment(bool display) {
  std::vector<std::string> kept;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (text.starts_with("THERMOTWIN_") || (!display && text.starts_with("DISPLAY="))) continue;
    kept.push_back(text);
  }
  return kept;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

void close_if_open(int& descriptor) {
  if (descriptor >= 0) ::close(descriptor);
  descriptor = -1;
}

}  // namespace

Program::Program(const std::vector<std::string>& arguments, const Surroundings& surroundings) {
  std::signal(SIGPIPE, SIG_IGN);  // a program that ends early is seen by its status
  std::vector<std::string> words{THERMOTWIN_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<std::string> variables = environment(surroundings.display);
  const std::vector<char*> argv = pointers(words), envp = pointers(variables);
  Pipe in, out, err;
  const int redirected =
      surroundings.output.empty() ? out.write : ::open(surroundings.output.c_str(), O_WRONLY | O_CLOEXEC);
  if (redirected < 0) throw std::runtime_error(surroundings.output + " cannot be opened");
  deadline_ms_ = now_ms() + patience_ms;
  child_ = ::fork();
  if (child_ < 0) throw std::runtime_error("fork failed");
  if (child_ == 0) {
    ::dup2(in.read, STDIN_FILENO);
    ::dup2(redirected, STDOUT_FILENO);
    ::dup2(err.write, STDERR_FILENO);
    std::signal(SIGPIPE, SIG_DFL);
    std::signal(SIGINT, SIG_DFL);  // a test runner in the background may ignore it
    if (surroundings.largest_file > 0) {
      // With the signal ignored, a write beyond the limit is an error like any other.
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{surroundings.largest_file, surroundings.largest_file};
      ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    if (surroundings.memory > 0) {
      const rlimit limit{surroundings.memory, surroundings.memory};
      ::setrlimit(RLIMIT_AS, &limit);
    }
    if (!surroundings.folder.empty() && ::chdir(surroundings.folder.c_str()) != 0) ::_exit(126);
    ::execve(argv[0], argv.data(), envp.data());
    ::_exit(127);
  }
  ::close(in.read);
  ::close(out.write);
  ::close(err.write);
  if (redirected != out.write) ::close(redirected);
  in_ = in.write;
  out_ = out.read;
  err_ = err.read;
}

Program::~Program() {
  if (!ended_) {
    ::kill(child_, SIGKILL);
    reap(true);
  }
  for (int* descriptor : {&in_, &out_, &err_}) close_if_open(*descriptor);
}

void Program::write(const std::string& text) {
  std::size_t done = 0;
  while (done < text.size()) {
    // What it says meanwhile must be read, or both would wait for each other.
    pump(0);
    pollfd state{in_, POLLOUT, 0};
    if (::poll(&state, 1, 50) <= 0) {
      if (now_ms() > deadline_ms_) throw std::runtime_error("the program does not read its input");
      continue;
    }
    const ssize_t count = ::write(in_, text.data() + done, std::min<std::size_t>(text.size() - done, 4096));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return;  // it has ended
    done += static_cast<std::size_t>(count);
  }
}

void Program::close_input() { close_if_open(in_); }

void Program::pump(int milliseconds) {
  std::array<pollfd, 2> states{pollfd{out_, POLLIN, 0}, pollfd{err_, POLLIN, 0}};  // -1 is passed over
  if (::poll(states.data(), states.size(), milliseconds) <= 0) return;
  const auto take = [](const pollfd& state, int& descriptor, std::string& text) {
    if ((state.revents & (POLLIN | POLLHUP | POLLERR)) == 0) return;
    std::array<char, 65536> buffer;
    const ssize_t count = ::read(descriptor, buffer.data(), buffer.size());
    if (count > 0)
      text.append(buffer.data(), static_cast<std::size_t>(count));
    else if (count == 0 || errno != EINTR)
      close_if_open(descriptor);
  };
  take(states[0], out_, result_.out);
  take(states[1], err_, result_.err);
}

std::string Program::read_line() {
  for (;;) {
    if (const std::size_t end = result_.out.find('\n', taken_); end != std::string::npos) {
      std::string line = result_.out.substr(taken_, end - taken_);
      taken_ = end + 1;
      return line;
    }
    if (out_ < 0) throw std::runtime_error("the program ended without another line; it said: " + result_.err);
    if (now_ms() > deadline_ms_) throw std::runtime_error("no line in time; it said: " + result_.err);
    pump(50);
  }
}

void Program::send(int signal) { ::kill(child_, signal); }

void Program::reap(bool block) {
  if (ended_) return;
  int status = 0;
  const pid_t found = ::waitpid(child_, &status, block ? 0 : WNOHANG);
  if (found == 0 || (found < 0 && errno == EINTR)) return;
  ended_ = true;
  result_.status = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

bool Program::is_running() {
  pump(0);
  reap(false);
  return !ended_;
}

bool Program::ends_within(double seconds) {
  const std::int64_t end = now_ms() + static_cast<std::int64_t>(1000.0 * seconds);
  while (is_running() && now_ms() < end) pump(5);
  return !is_running();
}

Result Program::wait() {
  close_input();
  while (out_ >= 0 || err_ >= 0) {
    if (now_ms() > deadline_ms_) throw std::runtime_error("the program does not end; it said: " + result_.err);
    pump(50);
  }
  while (!ended_) reap(true);
  return result_;
}

Result thermotwin(const std::vector<std::string>& arguments, const std::string& input,
                  const Surroundings& surroundings) {
  Program program(arguments, surroundings);
  program.write(input);
  return program.wait();
}

}  // namespace thermotwin::cases
