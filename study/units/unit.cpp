// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/units/unit.h"

#include <fmt/format.h>

#include <map>

#include "core/file.h"

namespace thermotwin::study {

std::string hash_of_case(const solver::Case& machine_case, const std::string& origin) {
  const mesh::Machine& machine = machine_case.machine;
  std::string words = fmt::format("{} {} order {}", origin, machine.hash, machine.order);
  std::map<std::string, std::string> files;
  for (const mesh::BodySpec& body : machine.bodies)
    if (!files.contains(body.cad.string())) files[body.cad.string()] = core::content_hash(core::read_file(body.cad));
  for (const auto& [name, hash] : files) words += " " + hash;
  if (machine_case.time) {
    const solver::TimeOptions& time = *machine_case.time;
    words +=
        fmt::format(" {} {} {} {}", solver::word(time.scheme), time.tolerance_K, time.shortest_step, time.longest_step);
  }
  return core::content_hash(words);
}

std::string words_of_load(const solver::Case& machine_case, const std::string& load) {
  return load + " " + core::content_hash(core::read_file(machine_case.folder / "loads" / (load + ".toml")));
}

}  // namespace thermotwin::study
