// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/tests/stated_parameters.h"

#include <algorithm>

#include "compensation/online/uncertain_quantities.h"
#include "core/error.h"
#include "core/text.h"
#include "diagnosis/causes/kinds.h"
#include "study/plan/items.h"

namespace thermotwin::study {

using diagnosis::Kind;

std::vector<UncertainParameter> stated_parameters(const mesh::Machine& machine, bool with_parts) {
  std::vector<UncertainParameter> found;
  for (const diagnosis::KindRow& row : diagnosis::known_kinds()) {
    // process_heat is another name of a source's power; a step is none of a machine as it is stated.
    const bool is_stated = row.kind != Kind::process_heat && !diagnosis::is_step(row.kind);
    if (!is_stated || (diagnosis::needs_parts(row.kind) && !with_parts)) continue;
    for (const Item& item : items_of(machine, row.kind)) {
      const auto named = [&](const UncertainParameter& one) {
        return one.parameter.kind == row.kind && one.parameter.where == item.id;
      };
      // Of two exchanges of a volume with the same ambient the name means the first.
      if (!(item.std() > 0.0) || std::any_of(found.begin(), found.end(), named)) continue;
      found.push_back({diagnosis::make_parameter(row.kind, item.id), item.std(), compensation::machine_memory_s});
    }
  }
  return found;
}

std::string key_of(const UncertainParameter& parameter) {
  return diagnosis::name_of(parameter.parameter.kind) + ":" + parameter.parameter.where;
}

std::vector<UncertainParameter> chosen_parameters(std::vector<UncertainParameter> all,
                                                  const std::vector<std::string>& names, const mesh::Machine& machine) {
  if (all.empty()) {
    throw core::InputError(machine.path.string(), "no value has a std_percent",
                           "{value = ..., std_percent = ...} at the values that a test shall tell");
  }
  if (names.empty()) return all;
  std::vector<std::string> known;
  for (const UncertainParameter& one : all) known.push_back(key_of(one));
  std::vector<UncertainParameter> chosen;
  for (const std::string& name : names) {
    const auto at = std::find(known.begin(), known.end(), name);
    if (at == known.end()) {
      throw core::InputError("--parameter", "'" + name + "'",
                             "KIND:WHERE of a value of " + machine.path.string() +
                                 " with a std_percent (nearest: " + core::nearest(name, known) + ")");
    }
    const auto twice = [&](const UncertainParameter& one) { return key_of(one) == name; };
    if (std::any_of(chosen.begin(), chosen.end(), twice))
      throw core::InputError("--parameter", "'" + name + "' a second time", "each value once");
    chosen.push_back(all[at - known.begin()]);
  }
  return chosen;
}

}  // namespace thermotwin::study
