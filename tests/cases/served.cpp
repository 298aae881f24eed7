// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cases/served.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <sys/types.h>
#include <thread>
#include <unistd.h>

namespace thermotwin::cases {

Served served_of(const std::string& line) {
  Served answer;
  EXPECT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &answer.time, &answer.offset[0], &answer.offset[1],
                        &answer.offset[2]),
            4)
      << line;
  answer.status = line.substr(line.rfind(',') + 1);
  return answer;
}

std::vector<Served> all_served(const std::string& out) {
  std::vector<Served> all;
  std::istringstream lines(out);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) all.push_back(served_of(line));
  return all;
}

std::string last_line_of(const std::string& text) {
  const std::size_t end = text.find_last_not_of('\n');
  const std::size_t begin = text.rfind('\n', end) + 1;
  return text.substr(begin, end + 1 - begin);
}

double slowness() {
  double load = 0;
  return ::getloadavg(&load, 1) == 1 ? std::max(1.0, load / std::max(1U, std::thread::hardware_concurrency())) : 1.0;
}

Serve::Serve() {
  for (const char* name : {"model.rom.h5", "scene.bin"}) std::filesystem::copy(toy_run() / name, toy_.file(name));
}

std::string Serve::row(double time, double speed) {
  return fmt::format("{},{},10,20.5,20.5,20.4,20.3,20.6\n", time, speed);
}

std::string Serve::rows_to(double time) {
  std::string rows = header;
  for (double at = 0; at <= time; at += warm_step_s) rows += row(at);
  return rows;
}

std::vector<std::string> Serve::arguments(const std::vector<std::string>& more) const {
  std::vector<std::string> all = {"serve", model(), "--quiet"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

int Serve::kill_all(const std::string& part) const { return signal_all(part, SIGKILL); }

int Serve::signal_all(const std::string& part, int signal) const {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::error_code none;
    if (std::filesystem::read_symlink(entry.path() / "exe", none).filename() != "thermotwin") continue;
    std::ifstream words(entry.path() / "cmdline", std::ios::binary);
    const std::string line((std::istreambuf_iterator<char>(words)), {});
    const auto has = [&](const std::string& word) { return line.find('\0' + word + '\0') != std::string::npos; };
    if (!has(part) || !has(model())) continue;
    count += ::kill(std::stoi(name), signal) == 0;
  }
  return count;
}

}  // namespace thermotwin::cases
