// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/point_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"
#include "core/text.h"
#include "core/unique_id.h"
#include "core/units.h"

namespace thermotwin::metrology {

using core::InputError;
using core::Node;
using core::Table;
using Eigen::Index;
using Eigen::Vector3d;
namespace units = core::units;

namespace {

constexpr double largest_um = 1e5, largest_mm = 1e5;

struct Column {
  enum class Kind { time, cycle, position, nominal, deviation } kind;
  std::string axis;
  int component = 0;
  double factor = 1.0;
};

std::map<std::string, Column> known_columns(const mesh::KinematicChain& chain) {
  std::map<std::string, Column> known{{"time_s", {Column::Kind::time, ""}}, {"cycle", {Column::Kind::cycle, ""}}};
  for (const std::string& id : chain.ids()) {
    const bool rotary = chain.find(id)->rotary;
    known[id + (rotary ? "_deg" : "_mm")] = {Column::Kind::position, id, 0, rotary ? units::deg : units::mm};
  }
  for (int i = 0; i < 3; ++i) {
    known[fmt::format("{}_mm", "xyz"[i])] = {Column::Kind::nominal, "", i, units::mm};
    known[fmt::format("d{}_um", "xyz"[i])] = {Column::Kind::deviation, "", i, units::um};
  }
  return known;
}

std::vector<Column> columns_of(const Table& table, const mesh::KinematicChain& chain, bool raw) {
  const std::map<std::string, Column> known = known_columns(chain);
  std::vector<std::string> names;
  for (const auto& [name, column] : known) names.push_back(name);
  std::vector<Column> columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const auto found = known.find(table.columns[i]);
    if (found == known.end()) {
      throw InputError(fmt::format("{}:1 column {}", table.source, i + 1), "'" + table.columns[i] + "'",
                       "one of: " + core::join(names) + " (nearest: " + core::nearest(table.columns[i], names) + ")");
    }
    columns.push_back(found->second);
  }
  for (const char* needed : {"cycle", "x_mm", "y_mm", "z_mm", "dx_um", "dy_um", "dz_um"}) {
    if (!table.find(needed) && !(raw && std::string(needed).ends_with("_um"))) {
      throw InputError(table.source + ":1", std::string("no column ") + needed,
                       "time_s, cycle, positions of axes, x_mm, y_mm, z_mm, dx_um, dy_um, dz_um");
    }
  }
  return columns;
}

/// A missing value or one that no measurement has.
void check_cell(const Table& table, Index row, Index column) {
  const double value = table.values(row, column);
  const std::string& name = table.columns[column];
  const double most = name.ends_with("_um") ? largest_um : name == "time_s" ? 1e11 : largest_mm;
  if (std::abs(value) <= most) return;
  throw InputError(fmt::format("{}:{} {}", table.source, Table::line_of_row(row), name),
                   std::isnan(value) ? std::string("a missing point") : fmt::format("{}", value),
                   fmt::format("a number of at most {:.0e}; leave out the row of a point that was not measured", most));
}

/// Points on the rotary axes, and axes that move the workpiece with their letter.
void read_axes(const Node& root, mesh::KinematicChain& chain) {
  std::vector<std::string> rotary, seen;
  for (const std::string& id : chain.ids())
    if (chain.find(id)->rotary) rotary.push_back(id);
  for (const Node& node : root.tables("axis")) {
    const std::string id = node.text("id");
    if (std::find(rotary.begin(), rotary.end(), id) == rotary.end()) {
      throw InputError(
          node.place("id"), "'" + id + "'",
          "rotary axes of the chain: " + core::join(rotary) + " (nearest: " + core::nearest(id, rotary) + ")");
    }
    core::require_unique_id(id, node.place("id"), seen);
    mesh::ChainAxis& axis = *chain.find(id);
    axis.origin = units::mm * Vector3d(node.number("x_mm"), node.number("y_mm"), node.number("z_mm"));
    if (node.boolean("with_letter")) {
      if (!axis.table_side) {
        throw InputError(node.place("with_letter"), "true of an axis that carries the tool",
                         "axes that carry the workpiece: others move with their letter anyway");
      }
      axis.direction = -axis.direction;
    }
    node.finish();
  }
}

}  // namespace

std::vector<RTestCycle> read_cycles(const Table& table, const mesh::KinematicChain& chain, bool raw) {
  if (table.rows() == 0) throw InputError(table.source, "no rows", "at least one point below the column names");
  core::require_time_column(table);
  const std::vector<Column> columns = columns_of(table, chain, raw);
  const Index cycle_column = *table.find("cycle");
  std::vector<RTestCycle> cycles;
  double last = 0.0;
  for (Index i = 0; i < table.rows(); ++i) {
    RTestPoint point;
    for (Index c = 0; c < table.values.cols(); ++c) {
      check_cell(table, i, c);
      const Column& column = columns[c];
      const double value = table.values(i, c) * column.factor;
      if (column.kind == Column::Kind::time) point.time = value;
      if (column.kind == Column::Kind::position) point.positions[column.axis] = value;
      if (column.kind == Column::Kind::nominal) point.nominal[column.component] = value;
      if (column.kind == Column::Kind::deviation) point.deviation[column.component] = value;
    }
    const double cycle = table.values(i, cycle_column);
    const std::string place = fmt::format("{}:{} cycle", table.source, Table::line_of_row(i));
    if (cycle != std::round(cycle)) throw InputError(place, fmt::format("{}", cycle), "a whole number");
    if (!cycles.empty() && cycle < last)
      throw InputError(place, fmt::format("{} after {}", cycle, last), "cycles in rising order");
    if (cycles.empty() || cycle > last) cycles.push_back({fmt::format("{} cycle {}", table.source, cycle), {}});
    last = cycle;
    cycles.back().points.push_back(std::move(point));
  }
  return cycles;
}

bool has_deviations(const Table& table) { return table.find("dx_um") || table.find("dy_um") || table.find("dz_um"); }

void compare_nothing(RTestRecord& record) {
  record.alone = record.against_first && record.cycles.size() == 1;
  if (record.alone) record.against_first = false;
}

void read_common(const Node& root, RTestRecord& record) {
  record.chain = mesh::KinematicChain::parse(root.text("chain"), root.place("chain"));
  read_axes(root, record.chain);
  record.table_radius = root.number("table_radius_mm") * units::mm;
  record.std = root.number("std_um") * units::um;
  record.against_first = root.choice("reference") == "first";
  record.drift = root.choice("drift") == "repeated";
  record.errors_stated = root.has("errors");
  record.errors = root.texts_or_empty("errors");
}

}  // namespace thermotwin::metrology
