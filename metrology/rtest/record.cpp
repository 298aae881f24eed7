// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/config.h"
#include "core/error.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/rtest/record_keys.h"

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

bool has_deviations(const Table& table) { return table.find("dx_um") || table.find("dy_um") || table.find("dz_um"); }

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

void take_displacements(RTestRecord& record, const ProbeSetup& setup, const std::vector<Vector3d>& displacements) {
  const auto& branch = setup.on_table ? record.chain.table : record.chain.tool;
  std::size_t at = 0;
  for (RTestCycle& cycle : record.cycles) {
    for (RTestPoint& point : cycle.points) {
      const Eigen::Matrix3d carrier =
          mesh::KinematicChain::frame(branch, static_cast<int>(std::ssize(branch)) - 1, point.positions).linear();
      point.deviation = (setup.on_table ? 1.0 : -1.0) * (carrier * displacements[at++]);
    }
  }
}

RTestRecord RTestRecord::parse(const std::string& toml, const Table& points, const std::string& source,
                               const RawSignals* signals) {
  const core::Config config = core::Config::parse(toml, source, &record_keys());
  const Node root = config.root();
  root.schema(1);
  RTestRecord record;
  record.source = source;
  record.chain = mesh::KinematicChain::parse(root.text("chain"), root.place("chain"));
  read_axes(root, record.chain);
  record.table_radius = root.number("table_radius_mm") * units::mm;
  record.std = root.number("std_um") * units::um;
  record.against_first = root.choice("reference") == "first";
  record.drift = root.choice("drift") == "repeated";
  record.harmonics = root.integer("harmonics");
  record.errors_stated = root.has("errors");
  record.errors = root.texts_or_empty("errors");
  const std::string place = record.errors_stated ? root.place("errors") : source;
  const std::optional<Node> probes = root.table_if("probes");
  const ProbeSetup setup = probes ? read_probes(*probes) : ProbeSetup();
  root.finish();
  record.cycles = read_cycles(points, record.chain, signals != nullptr);
  if (signals != nullptr) take_displacements(record, setup, sphere_displacements(*signals, setup, points.rows()));
  if (!record.errors_stated) record.errors = usual_errors(record.chain, record.moved_axes());
  if (record.errors.empty()) {
    throw InputError(place, record.errors_stated ? "no error" : "no rotary axis that moves",
                     "location errors, or points at several positions of a rotary axis");
  }
  std::vector<std::string> seen;
  for (const std::string& error : record.errors) {
    if (std::find(seen.begin(), seen.end(), error) != seen.end())
      throw InputError(place, "'" + error + "' a second time", "each error once");
    seen.push_back(error);
  }
  return record;
}

RTestRecord RTestRecord::load(const std::filesystem::path& folder) {
  for (const char* name : {"rtest.toml", "points.csv"}) {
    if (!std::filesystem::is_regular_file(folder / name))
      throw InputError(folder.string(), std::string("no file ") + name, "a folder with rtest.toml and points.csv");
  }
  const core::Config config = core::Config::load(folder / "rtest.toml");
  const Table points = core::read_csv(folder / "points.csv");
  if (has_deviations(points)) return parse(config.text(), points, config.source());
  const RawSignals signals = RawSignals::load(folder);
  return parse(config.text(), points, config.source(), &signals);
}

std::vector<std::string> RTestRecord::moved_axes() const {
  std::vector<std::string> moved;
  for (const auto* branch : {&chain.table, &chain.tool}) {
    for (const mesh::ChainAxis& axis : *branch) {
      if (!axis.rotary) continue;
      double low = 1e300, high = -1e300;
      for (const RTestCycle& cycle : cycles) {
        for (const RTestPoint& point : cycle.points) {
          const auto at = point.positions.find(axis.id);
          const double position = at == point.positions.end() ? 0.0 : at->second;
          low = std::min(low, position);
          high = std::max(high, position);
        }
      }
      if (high - low > 1e-6) moved.push_back(axis.id);
    }
  }
  return moved;
}

std::vector<std::string> usual_errors(const mesh::KinematicChain& chain, const std::vector<std::string>& moved) {
  std::string outermost, table;  // of the axes that move; of all
  for (const mesh::ChainAxis& axis : chain.table) {
    if (!axis.rotary) continue;
    table = axis.id;
    if (std::find(moved.begin(), moved.end(), axis.id) != moved.end()) outermost = axis.id;
  }
  if (outermost.empty() && !moved.empty()) outermost = moved.back();
  std::vector<std::string> errors;
  for (const std::string& id : moved) {
    const mesh::ChainAxis& axis = *chain.find(id);
    Index along = 0;
    axis.direction.cwiseAbs().maxCoeff(&along);
    for (int i = 0; i < 3; ++i) {
      if (i == along && id != outermost) continue;
      errors.push_back(std::string(1, "XYZ"[i]) + "0" + (i == along && axis.table_side ? "T" : id));
    }
    for (int i = 0; i < 3; ++i)
      if (i != along || id == outermost) errors.push_back(std::string(1, "ABC"[i]) + "0" + id);
    if (id == table) errors.emplace_back("R0T");
  }
  return errors;
}

}  // namespace thermotwin::metrology
