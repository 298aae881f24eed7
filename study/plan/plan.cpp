// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "core/config.h"
#include "core/error.h"
#include "core/text.h"
#include "diagnosis/causes/kinds.h"
#include "mesh/machine_mesh.h"
#include "study/plan/items.h"
#include "study/plan/plan_keys.h"

namespace thermotwin::study {
namespace {

namespace fs = std::filesystem;
using diagnosis::KindRow;

const KindRow& kind_of(const core::Node& node) {
  const std::string word = node.text("kind");
  const std::vector<std::string> allowed = kinds_of_plans();
  if (std::find(allowed.begin(), allowed.end(), word) == allowed.end()) {
    throw core::InputError(node.place("kind"), "'" + word + "'",
                           "one of: " + core::join(allowed) + " (nearest: " + core::nearest(word, allowed) + ")");
  }
  return diagnosis::row_of(diagnosis::kind_named(word));
}

void require_in_range(const KindRow& row, double value, const std::string& place) {
  if (value >= row.low && value <= row.high) return;
  throw core::InputError(place, fmt::format("{}", value),
                         fmt::format("{} of {}: {} to {}", row.amount, row.name, row.low, row.high));
}

/// What the table itself says; nothing: std_percent of machine.toml.
std::optional<Distribution> stated(const core::Node& node, const KindRow& row) {
  const bool ratio = row.sense == diagnosis::Sense::ratio;
  const double nominal = ratio ? 1.0 : 0.0;
  std::vector<std::string> given;
  for (const char* key : {"values", "range", "std_percent", "std"})
    if (node.has(key)) given.emplace_back(key);
  if (given.size() > 1) {
    throw core::InputError(node.place(given[1]), core::join(given, " and ") + " together",
                           "one of values, range, std_percent, std");
  }
  if (given.empty()) return std::nullopt;
  if (given.front() == "values") {
    const std::vector<double> values = node.numbers("values");
    if (values.empty()) throw core::InputError(node.place("values"), "no value", "one value or more");
    std::set<double> seen;
    for (const double value : values) {
      require_in_range(row, value, node.place("values"));
      if (!seen.insert(value).second)
        throw core::InputError(node.place("values"), fmt::format("{} twice", value), "each value once");
    }
    return Distribution::fixed(values);
  }
  if (given.front() == "range") {
    const std::vector<double> range = node.numbers("range");
    if (range.size() != 2 || !(range[0] < range[1]))
      throw core::InputError(node.place("range"), fmt::format("[{}]", fmt::join(range, ", ")),
                             "[low, high], low < high");
    for (const double value : range) require_in_range(row, value, node.place("range"));
    return Distribution::uniform(range[0], range[1]);
  }
  const bool percent = given.front() == "std_percent";
  if (percent != ratio) {
    throw core::InputError(
        node.place(given.front()), "of " + row.name,
        ratio ? "std_percent: its value is a factor" : fmt::format("std, in {}: its value is added", row.unit));
  }
  const double std = percent ? node.number("std_percent") / 100.0 : node.number("std");
  require_in_range(row, nominal - most_deviations * std, node.place(given.front()) + " (lowest draw)");
  require_in_range(row, nominal + most_deviations * std, node.place(given.front()) + " (highest draw)");
  return Distribution::normal(nominal, std);
}

const Item& find_item(const std::vector<Item>& items, const std::string& id, const core::Node& node,
                      const KindRow& row) {
  std::vector<std::string> known;
  for (const Item& item : items) {
    if (item.id == id) return item;
    known.push_back(item.id);
  }
  throw core::InputError(node.place("where"), "'" + id + "'",
                         known.empty()
                             ? "the machine has nothing that " + row.name + " may change"
                             : row.where + ": " + core::join(known) + " (nearest: " + core::nearest(id, known) + ")");
}

/// Bounds of an item may be closer than those of its kind: an emissivity is at most 1.
void require_possible(const Item& item, const Distribution& own, const KindRow& row, const core::Node& node) {
  const std::vector<double> all = own.spread == Spread::values ? own.values : std::vector<double>{own.low, own.high};
  for (const double value : all) {
    if (value >= item.low && value <= item.high) continue;
    const char* key = own.spread == Spread::values ? "values" : own.spread == Spread::uniform ? "range" : "where";
    throw core::InputError(node.place(key), fmt::format("{:.6g} of '{}'", value, item.id),
                           fmt::format("{} of {}: {:.6g} to {:.6g}", row.amount, row.name, item.low, item.high));
  }
}

void add_parameters(const core::Node& node, const mesh::Machine& machine, std::vector<StudyParameter>& parameters) {
  const KindRow& row = kind_of(node);
  const std::vector<Item> items = items_of(machine, row.kind);
  const std::optional<Distribution> own = stated(node, row);
  std::vector<Item> meant;
  for (const std::string& id : node.texts("where")) {
    if (id != "*") {
      meant.push_back(find_item(items, id, node, row));
      continue;
    }
    const std::size_t before = meant.size();
    for (const Item& item : items)
      if (item.std() > 0.0) meant.push_back(item);
    if (meant.size() == before) {
      throw core::InputError(node.place("where"), "'*'",
                             "ids: no item of " + row.name + " has a std_percent in " + machine.path.string());
    }
  }
  if (meant.empty()) throw core::InputError(node.place("where"), "no id", "one id or more, or *");
  for (const Item& item : meant) {
    const std::string& id = item.id;
    StudyParameter made;
    made.parameter = diagnosis::make_parameter(row.kind, id);
    made.name = row.name + ":" + id;
    if (!own && !(item.std() > 0.0)) {
      const std::string has =
          item.std_percent > 0.0 ? "' has a std_percent of the value 0 in " : "' has no std_percent in ";
      throw core::InputError(node.place("where"), "'" + id + has + machine.path.string(),
                             "values, range, std_percent or std beside it");
    }
    made.parameter.low = item.low;
    made.parameter.high = item.high;
    if (own) {
      require_possible(item, *own, row, node);
      made.distribution = *own;
    } else {
      made.distribution = Distribution::normal(made.parameter.ratio ? 1.0 : 0.0, item.std());
    }
    if (made.distribution.is_drawn()) {
      made.distribution.low = std::max(made.distribution.low, item.low);
      made.distribution.high = std::min(made.distribution.high, item.high);
    }
    for (const StudyParameter& other : parameters) {
      if (other.name == made.name)
        throw core::InputError(node.place("where"), "'" + id + "' of " + row.name + " twice", "each parameter once");
    }
    parameters.push_back(std::move(made));
  }
  node.finish();
}

solver::Case case_of(const core::Node& root, const fs::path& folder) {
  const fs::path path = folder / root.text("case");
  if (!fs::exists(fs::is_directory(path) ? path / "case.toml" : path)) {
    throw core::InputError(root.place("case"), "no case '" + root.text("case") + "'",
                           "a folder with case.toml, or a case.toml; absolute, or from the plan's folder");
  }
  return solver::read_case(path);
}

void require_size(const core::Node& root, const mesh::Machine& machine, const std::string& size) {
  try {
    mesh::size_factor(machine, size);
  } catch (const core::InputError&) {
    throw core::InputError(root.place("size"), "'" + size + "'",
                           "coarse, standard, fine, or a factor from 0.01 to 100");
  }
}

void require_loads(const core::Node& root, const StudyPlan& plan) {
  std::set<std::string> seen;
  const std::string place = root.has("loads") ? root.place("loads") : root.place();
  for (const std::string& load : plan.loads) {
    if (!seen.insert(load).second) throw core::InputError(place, "'" + load + "' twice", "each load program once");
    plan.machine_case.load(load);
  }
  if (plan.loads.empty())
    throw core::InputError(place, "no load program, and the case holds none out", "loads = [...]");
}

}  // namespace

StudyPlan read_variant_plan(const fs::path& path) {
  const core::Config config = core::Config::load(path, &variant_plan_keys());
  const core::Node root = config.root();
  root.schema(1);
  StudyPlan plan;
  plan.path = path;
  plan.title = root.text("title");
  const fs::path folder = path.parent_path();
  plan.machine_case = case_of(root, folder);
  if (!plan.machine_case.machine.has_tcp()) {
    throw core::InputError(root.place("case"), plan.machine_case.machine.path.string() + " without [tcp]",
                           "a machine with a TCP error");
  }
  plan.loads = root.has("loads") ? root.texts("loads") : plan.machine_case.holdout;
  require_loads(root, plan);
  plan.sizes = root.has("size") ? root.texts("size") : std::vector<std::string>{plan.machine_case.size};
  std::set<std::string> sizes;
  for (const std::string& size : plan.sizes) {
    if (root.has("size")) require_size(root, plan.machine_case.machine, size);
    if (!sizes.insert(size).second) throw core::InputError(root.place("size"), "'" + size + "' twice", "each once");
  }
  if (plan.sizes.empty()) throw core::InputError(root.place("size"), "no size", "one size or more");
  plan.samples = root.integer("samples");
  const std::string word = root.choice("sampling");
  plan.sampling = word == "random" ? Sampling::random : word == "pick_freeze" ? Sampling::pick_freeze : Sampling::latin;
  plan.seed = root.integer("seed");
  plan.block = root.integer("block");
  for (const core::Node& node : root.tables("parameter"))
    add_parameters(node, plan.machine_case.machine, plan.parameters);
  root.finish();
  const auto drawn = std::count_if(plan.parameters.begin(), plan.parameters.end(),
                                   [](const StudyParameter& p) { return p.distribution.is_drawn(); });
  if (drawn > 0 && plan.samples < 1) {
    throw core::InputError(root.place(),
                           fmt::format("{} to draw, samples = {}",
                                       drawn == 1 ? "1 parameter" : fmt::format("{} parameters", drawn), plan.samples),
                           "samples = 1 or more");
  }
  if (drawn == 0 && plan.samples > 0) {
    throw core::InputError(root.place("samples"), fmt::format("{}, and no parameter to draw", plan.samples),
                           "0, or a parameter with range or a standard deviation");
  }
  return plan;
}

}  // namespace thermotwin::study
