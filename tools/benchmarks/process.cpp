// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/benchmarks/process.h"

#include <fmt/format.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <sched.h>
#include <sstream>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.h"

namespace thermotwin::bench {
namespace {

void keep_to_cores(int cores) {
  cpu_set_t mine, few;
  CPU_ZERO(&few);
  if (sched_getaffinity(0, sizeof mine, &mine) != 0) return;
  for (int cpu = 0, taken = 0; cpu < CPU_SETSIZE && taken < cores; ++cpu) {
    if (CPU_ISSET(cpu, &mine)) {
      CPU_SET(cpu, &few);
      ++taken;
    }
  }
  sched_setaffinity(0, sizeof few, &few);
}

void redirect(const std::filesystem::path& file, int flags, int to) {
  const int descriptor = open(file.c_str(), flags, 0644);
  if (descriptor < 0) _exit(126);
  dup2(descriptor, to);
  close(descriptor);
}

[[noreturn]] void become(const Command& command, std::vector<char*>& words, int pipe_end) {
  if (command.cores > 0) keep_to_cores(command.cores);
  if (!command.folder.empty() && chdir(command.folder.c_str()) != 0) _exit(126);
  redirect(command.input.empty() ? std::filesystem::path("/dev/null") : command.input, O_RDONLY, STDIN_FILENO);
  if (command.output.empty()) {
    dup2(pipe_end, STDOUT_FILENO);
  } else {
    redirect(command.output, O_WRONLY | O_CREAT | O_TRUNC, STDOUT_FILENO);
  }
  dup2(pipe_end, STDERR_FILENO);
  for (const std::string& setting : command.environment) putenv(const_cast<char*>(setting.c_str()));
  execvp(words[0], words.data());
  _exit(127);
}

}  // namespace

double Outcome::operator[](const std::string& name) const {
  const auto found = values.find(name);
  if (found == values.end()) throw core::SolverError("a benchmark program did not print '" + name + "'");
  return found->second;
}

Outcome run(const Command& command) {
  std::vector<char*> words;
  for (const std::string& word : command.words) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  int ends[2];
  if (pipe(ends) != 0) throw core::SolverError("a benchmark program cannot be started: no pipe");
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child < 0) throw core::SolverError("a benchmark program cannot be started: no process");
  if (child == 0) become(command, words, ends[1]);
  close(ends[1]);
  std::string said;
  char buffer[4096];
  for (ssize_t got; (got = read(ends[0], buffer, sizeof buffer)) > 0;) said.append(buffer, got);
  close(ends[0]);
  int status = 0;
  rusage usage{};
  while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {}
  Outcome outcome;
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto seconds = [](const timeval& time) { return time.tv_sec + 1e-6 * time.tv_usec; };
  outcome.processor_seconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  outcome.peak_MiB = usage.ru_maxrss / 1024.0;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw core::SolverError(fmt::format("{} failed (status {}): {}", command.words[0], status,
                                        said.substr(said.size() > 600 ? said.size() - 600 : 0)));
  }
  std::istringstream lines(said);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t blank = line.find(' ');
    if (blank == std::string::npos) continue;
    char* end = nullptr;
    const double value = std::strtod(line.c_str() + blank, &end);
    if (end != line.c_str() + blank) outcome.values[line.substr(0, blank)] = value;
  }
  return outcome;
}

bool have_program(const std::string& name) {
  std::istringstream folders(std::getenv("PATH") != nullptr ? std::getenv("PATH") : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (access((folder + "/" + name).c_str(), X_OK) == 0) return true;
  return false;
}

}  // namespace thermotwin::bench
