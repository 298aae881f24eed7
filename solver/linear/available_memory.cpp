// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/linear/available_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>
#include <sys/resource.h>
#include <unistd.h>

namespace thermotwin::solver {
namespace {

std::optional<double> number_in(const std::string& path) {
  std::ifstream file(path);
  double value = 0;
  return file >> value ? std::optional(value) : std::nullopt;  // "max" is no number: no limit
}

std::optional<double> value_of(const std::string& path, const std::string& key) {
  std::ifstream file(path);
  for (std::string word; file >> word;)
    if (double value = 0; word == key && file >> value) return value;
  return std::nullopt;
}

/// What a cgroup leaves, itself and all that it is in.
double cgroup_left(const std::string& own_cgroup, const std::string& root) {
  double left = 1e300;
  const auto look = [&](const std::string& base, std::string path, const char* limit, const char* used,
                        const char* cache) {
    for (;;) {
      const std::string folder = base + (path == "/" ? "" : path) + "/";
      const auto most = number_in(folder + limit), now = number_in(folder + used);
      // Files that are only cached give way.
      if (most && now && *most < 1e18)
        left = std::min(left, *most - *now + value_of(folder + "memory.stat", cache).value_or(0.0));
      if (path.empty() || path == "/") return;
      path.erase(path.find_last_of('/'));
    }
  };
  std::istringstream lines(own_cgroup);
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string kinds = line.substr(first + 1, second - first - 1), path = line.substr(second + 1);
    if (kinds.empty()) look(root, path, "memory.max", "memory.current", "inactive_file");
    if (kinds == "memory")
      look(root + "/memory", path, "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file");
  }
  return left;
}

}  // namespace

double available_memory(const std::string& meminfo, const std::string& own_cgroup, const std::string& cgroup_root) {
  double available = 1e300;
  if (const auto kilobytes = value_of(meminfo, "MemAvailable:")) available = 1024.0 * *kilobytes;
  return std::max(0.0, std::min(available, cgroup_left(own_cgroup, cgroup_root)));
}

double available_memory() {
  std::ifstream own("/proc/self/cgroup");
  std::stringstream text;
  text << own.rdbuf();
  double available = available_memory("/proc/meminfo", text.str(), "/sys/fs/cgroup");
  // ulimit -v
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    if (const auto pages = number_in("/proc/self/statm"))
      available = std::min(available, limit.rlim_cur - *pages * sysconf(_SC_PAGESIZE));
  }
  return std::max(0.0, available);
}

}  // namespace thermotwin::solver
