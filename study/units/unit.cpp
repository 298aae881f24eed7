// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/units/unit.h"

#include <fmt/format.h>

#include <map>

#include "core/file.h"
#include "study/plan/items.h"

namespace thermotwin::study {
namespace {

namespace fs = std::filesystem;

std::string words_of(const StudyPlan& plan, const Eigen::VectorXd& values, bool only_matrices) {
  std::string words;
  for (std::size_t p = 0; p < plan.parameters.size(); ++p) {
    const StudyParameter& parameter = plan.parameters[p];
    if (only_matrices && shares_matrices(parameter.parameter.kind)) continue;
    words += fmt::format(" {}={:.17g}", parameter.name, values[p]);
  }
  return words;
}

/// Machine, its CAD files, poses: what is the same for all units.
std::string hash_of_case(const StudyPlan& plan, const UnitOrigin& origin) {
  const mesh::Machine& machine = plan.machine_case.machine;
  std::string words = "study 1 " + origin.version + " " + origin.model + " " + machine.hash;
  words += fmt::format(" order {}", machine.order);
  std::map<std::string, std::string> files;
  for (const mesh::BodySpec& body : machine.bodies)
    if (!files.contains(body.cad.string())) files[body.cad.string()] = core::content_hash(core::read_file(body.cad));
  for (const auto& [name, hash] : files) words += " " + hash;
  return core::content_hash(words);
}

}  // namespace

std::vector<Unit> make_units(const StudyPlan& plan, const Design& design, const UnitOrigin& origin) {
  const std::string of_case = hash_of_case(plan, origin);
  // Variants that share matrices, in the order of their first.
  std::vector<std::string> keys;
  std::map<std::string, std::vector<std::size_t>> members;
  std::map<std::string, std::string> sizes;
  for (std::size_t v = 0; v < design.variants.size(); ++v) {
    const Variant& variant = design.variants[v];
    const std::string& size = design.groups[variant.group].size;
    const std::string key = size + words_of(plan, variant.values, true);
    if (!members.contains(key)) keys.push_back(key);
    members[key].push_back(v);
    sizes[key] = size;
  }
  std::map<std::string, std::string> load_hashes;
  for (const std::string& load : plan.loads)
    load_hashes[load] = core::content_hash(core::read_file(plan.machine_case.folder / "loads" / (load + ".toml")));
  std::vector<Unit> units;
  for (const std::string& key : keys) {
    for (const std::string& load : plan.loads) {
      const std::vector<std::size_t>& all = members.at(key);
      for (std::size_t first = 0; first < all.size(); first += plan.block) {
        Unit unit{"", load, sizes.at(key), key, {}};
        for (std::size_t v = first; v < std::min(all.size(), first + plan.block); ++v) unit.variants.push_back(all[v]);
        std::string words = of_case + " " + load + " " + load_hashes.at(load) + " " + unit.size;
        for (const std::size_t v : unit.variants)
          words += fmt::format(" {}:{}", v, words_of(plan, design.variants[v].values, false));
        if (plan.machine_case.time) {
          const solver::TimeOptions& time = *plan.machine_case.time;
          words += fmt::format(" {} {} {} {}", solver::word(time.scheme), time.tolerance_K, time.shortest_step,
                               time.longest_step);
        }
        unit.id = core::content_hash(words);
        units.push_back(std::move(unit));
      }
    }
  }
  return units;
}

}  // namespace thermotwin::study
