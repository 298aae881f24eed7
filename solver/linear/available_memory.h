// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What memory the machine, its cgroup and the shell leave to this process.

#include <string>

namespace thermotwin::solver {

/// Bytes this process may still take: MemAvailable of /proc/meminfo, or less where a cgroup
/// or ulimit -v limits it.
double available_memory();
/// The same from other roots, for tests. @param own_cgroup  text of /proc/self/cgroup
double available_memory(const std::string& meminfo, const std::string& own_cgroup, const std::string& cgroup_root);

}  // namespace thermotwin::solver
