// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/model/parts_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd above_each_other(const std::vector<MatrixXd>& blocks) {
  const Index rows = blocks.front().rows();
  MatrixXd all(rows * std::ssize(blocks), blocks.front().cols());
  for (Index i = 0; i < std::ssize(blocks); ++i) all.middleRows(rows * i, rows) = blocks[i];
  return all;
}

std::vector<MatrixXd> taken_apart(const MatrixXd& all, Index rows) {
  std::vector<MatrixXd> blocks;
  for (Index first = 0; first < all.rows(); first += rows) blocks.push_back(all.middleRows(first, rows));
  return blocks;
}

/// Lists in the order of their numbers in the file.
template <class Any>
auto lists_of(Any& parts) {
  return std::array{&parts.bodies, &parts.scales, &parts.screws, &parts.stiffness};
}

}  // namespace

void write_parts(StoreWriter& writer, const Parts& parts, const ReducedModel& model) {
  const Index r = model.system.order(), tools = std::ssize(model.outputs.tool),
              tables = std::ssize(model.outputs.table_axis);
  std::vector<MatrixXd> tool, table_axis, table_own;
  std::vector<std::pair<int, int>> named;
  const auto lists = lists_of(parts);
  for (std::size_t kind = 0; kind < lists.size(); ++kind) {
    for (std::size_t i = 0; i < lists[kind]->size(); ++i) {
      const ReducedOutputs& outputs = (*lists[kind])[i];
      if (outputs.tool.empty()) continue;
      named.emplace_back(static_cast<int>(kind), i);
      tool.push_back(above_each_other(outputs.tool));
      table_axis.push_back(above_each_other(outputs.table_axis));
      table_own.push_back(above_each_other(outputs.table_own));
    }
  }
  IntRows items(std::ssize(named), 2);
  for (Index i = 0; i < items.rows(); ++i) items.row(i) << named[i].first, named[i].second;
  writer.group("/parts");
  const auto split = parts.capacity.begin() + std::min(std::ssize(parts.bodies), std::ssize(parts.capacity));
  writer.stack("/parts/capacity", {parts.capacity.begin(), split}, r, r);
  writer.describe("/parts/capacity", "(body, state, state)", "J/K");
  if (split != parts.capacity.end()) {
    writer.stack("/parts/volume_capacity", {split, parts.capacity.end()}, r, r);
    writer.describe("/parts/volume_capacity", "(volume, state, state)", "J/K");
  }
  writer.vector("/parts/stiffness_exponent", parts.stiffness_exponent);
  writer.describe("/parts/stiffness_exponent", "joint", "1");
  writer.integers("/parts/items", items);
  writer.describe("/parts/items", "kind item",
                  "kind: 0 expansion of a body, 1 of a scale, 2 of a screw, 3 stiffness of a joint; index");
  writer.stack("/parts/tool", tool, 6 * tools, r);
  writer.describe("/parts/tool", "(part, rows of /outputs/tool pose after pose, state)",
                  "m, rad; of kind 3 the derivative by ln k");
  writer.stack("/parts/table_axis", table_axis, 6 * tables, r);
  writer.describe("/parts/table_axis", "(part, rows of /outputs/table_axis pose after pose, state)",
                  "m, rad; of kind 3 the derivative by ln k");
  writer.stack("/parts/table_own", table_own, 7 * tables, r);
  writer.describe("/parts/table_own", "(part, rows of /outputs/table_own pose after pose, state)",
                  "m, rad; of kind 3 the derivative by ln k");
}

std::optional<Parts> read_parts(const StoreReader& reader, const ReducedModel& model) {
  if (!reader.has("/parts")) return std::nullopt;
  const mesh::Machine& machine = model.machine;
  const Index r = model.system.order(), tools = std::ssize(model.outputs.tool),
              tables = std::ssize(model.outputs.table_axis);
  Parts parts;
  parts.capacity = reader.stack("/parts/capacity", std::ssize(machine.bodies), r, r);
  if (reader.has("/parts/volume_capacity")) {
    for (MatrixXd& capacity : reader.stack("/parts/volume_capacity", std::ssize(machine.volumes), r, r))
      parts.capacity.push_back(std::move(capacity));
  }
  parts.bodies.resize(machine.bodies.size());
  parts.scales.resize(machine.scales.size());
  parts.screws.resize(machine.screws.size());
  parts.stiffness.resize(machine.joints.size());
  parts.stiffness_exponent = reader.vector("/parts/stiffness_exponent", std::ssize(machine.joints));
  const IntRows items = reader.integers("/parts/items", 2);
  const std::vector<MatrixXd> tool = reader.stack("/parts/tool", items.rows(), 6 * tools, r),
                              table_axis = reader.stack("/parts/table_axis", items.rows(), 6 * tables, r),
                              table_own = reader.stack("/parts/table_own", items.rows(), 7 * tables, r);
  const auto lists = lists_of(parts);
  for (Index i = 0; i < items.rows(); ++i) {
    const int kind = items(i, 0), item = items(i, 1);
    if (kind < 0 || kind >= std::ssize(lists) || item < 0 || item >= std::ssize(*lists[kind])) {
      reader.fail(fmt::format("/parts/items row {} with kind {} and item {}", i, kind, item),
                  "kinds 0 to 3 and items that its machine.toml has");
    }
    const std::size_t at = i;
    (*lists[kind])[item] = {
        {}, taken_apart(tool[at], 6), {}, taken_apart(table_axis[at], 6), taken_apart(table_own[at], 7)};
  }
  return parts;
}

void write_patches(StoreWriter& writer, const Patches& patches, const mesh::Machine& machine) {
  const auto count = std::ssize(patches.items);
  IntRows names(count, 2);
  MatrixXd geometry(count, 10);
  for (Index k = 0; k < count; ++k) {
    const Patch& patch = patches.items[k];
    const mesh::Rule& rule = patch.surface.any_of.front();
    names.row(k) << machine.body_index(patch.surface.body),
        std::stoi(patch.surface.id.substr(patch.surface.id.rfind('_') + 1));
    geometry.row(k) << patch.centre.transpose(), rule.box_min->transpose(), rule.box_max->transpose(), patch.area;
  }
  writer.group("/patches");
  writer.integers("/patches/names", names);
  writer.describe("/patches/names", "body number", "index of the body; the surface is called <body>.patch_<number>");
  writer.matrix("/patches/geometry", geometry);
  writer.describe("/patches/geometry", "centre box_min box_max area", "m, m, m, m2; home frame");
  writer.matrix("/patches/inputs", patches.inputs);
  writer.describe("/patches/inputs", "patch", "W for 1 W on it");
}

Patches read_patches(const StoreReader& reader, const ReducedModel& model) {
  Patches patches;
  if (!reader.has("/patches")) return patches;
  const IntRows names = reader.integers("/patches/names", 2);
  const MatrixXd geometry = reader.matrix("/patches/geometry", names.rows(), 10);
  patches.inputs = reader.matrix("/patches/inputs", model.system.order(), names.rows());
  for (Index k = 0; k < names.rows(); ++k) {
    if (names(k, 0) < 0 || names(k, 0) >= std::ssize(model.machine.bodies) || names(k, 1) < 0) {
      reader.fail(fmt::format("/patches/names row {} with body {} and number {}", k, names(k, 0), names(k, 1)),
                  "bodies that its machine.toml has");
    }
    const Eigen::Matrix<double, 10, 1> g = geometry.row(k).transpose();
    patches.items.push_back(
        {patch_surface(model.machine.bodies[names(k, 0)].id, names(k, 1), g.segment<3>(3), g.segment<3>(6)),
         g.head<3>(), g[9]});
  }
  return patches;
}

}  // namespace thermotwin::reduction
