// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/variants/variant_unit.h"

#include <fmt/format.h>

#include <map>

#include "core/file.h"
#include "study/plan/items.h"

namespace thermotwin::study {
namespace {

std::string words_of_values(const StudyPlan& plan, const Eigen::VectorXd& values, bool only_matrices) {
  std::string words;
  for (std::size_t p = 0; p < plan.parameters.size(); ++p) {
    const StudyParameter& parameter = plan.parameters[p];
    if (only_matrices && shares_matrices(parameter.parameter.kind)) continue;
    words += fmt::format(" {}={:.17g}", parameter.name, values[p]);
  }
  return words;
}

/// With the values of its variant where it has one only.
std::string words_of(const VariantUnit& unit, const StudyPlan& plan, const Design& design) {
  std::string words = fmt::format("variants {} to {} of '{}', size {}", unit.variants.front() + 1,
                                  unit.variants.back() + 1, unit.load, unit.size);
  if (unit.variants.size() > 1) return words;
  for (std::size_t p = 0; p < plan.parameters.size(); ++p)
    words += fmt::format(", {} = {:.6g}", plan.parameters[p].name, design.variants[unit.variants.front()].values[p]);
  return words;
}

std::string file_name(const char* table, std::size_t variant) {
  return fmt::format("{}_{:05}.csv", table, variant + 1);
}

}  // namespace

std::vector<VariantUnit> make_units(const StudyPlan& plan, const Design& design, const UnitOrigin& origin) {
  const std::string of_case = hash_of_case(plan.machine_case, "variants 2 " + origin.version + " " + origin.model);
  // Variants that share matrices, in the order of their first.
  std::vector<std::string> keys;
  std::map<std::string, std::vector<std::size_t>> members;
  std::map<std::string, std::string> sizes;
  for (std::size_t v = 0; v < design.variants.size(); ++v) {
    const Variant& variant = design.variants[v];
    const std::string& size = design.groups[variant.group].size;
    const std::string key = size + words_of_values(plan, variant.values, true);
    if (!members.contains(key)) keys.push_back(key);
    members[key].push_back(v);
    sizes[key] = size;
  }
  std::map<std::string, std::string> of_loads;
  for (const std::string& load : plan.loads) of_loads[load] = words_of_load(plan.machine_case, load);
  std::vector<VariantUnit> units;
  for (const std::string& key : keys) {
    for (const std::string& load : plan.loads) {
      const std::vector<std::size_t>& all = members.at(key);
      for (std::size_t first = 0; first < all.size(); first += plan.block) {
        VariantUnit unit{{}, load, sizes.at(key), key, {}};
        for (std::size_t v = first; v < std::min(all.size(), first + plan.block); ++v) unit.variants.push_back(all[v]);
        std::string inputs = of_case + " " + of_loads.at(load) + " " + unit.size;
        for (const std::size_t v : unit.variants)
          inputs += fmt::format(" {}:{}", v, words_of_values(plan, design.variants[v].values, false));
        unit.id = core::content_hash(inputs);
        unit.words = words_of(unit, plan, design);
        units.push_back(std::move(unit));
      }
    }
  }
  return units;
}

std::filesystem::path tcp_file(std::size_t variant) { return file_name("tcp", variant); }

UnitFiles write_tables(const std::filesystem::path& folder, const VariantUnit& unit,
                       const std::vector<VariantTables>& tables) {
  UnitFiles files;
  for (std::size_t i = 0; i < tables.size(); ++i) {
    files.emplace_back(file_name("tcp", unit.variants[i]));
    core::write_csv(folder / files.back(), tables[i].tcp, table_digits);
    files.emplace_back(file_name("sensors", unit.variants[i]));
    core::write_csv(folder / files.back(), tables[i].sensors, table_digits);
  }
  return files;
}

}  // namespace thermotwin::study
