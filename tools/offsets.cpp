// SPDX-License-Identifier: GPL-3.0-or-later
// The verb offsets: location errors in, axis offsets out.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <iostream>

#include "compensation/chain/location_offsets.h"
#include "core/error.h"
#include "core/file.h"
#include "core/table.h"
#include "core/text.h"
#include "core/units.h"
#include "diagnosis/causes/kinds.h"
#include "tools/options.h"

namespace thermotwin::tools {
namespace {

/// What a column of the table is, with the factor to SI.
struct Column {
  enum class Kind { time, position, point, error } kind;
  std::string name;
  Eigen::Index component = 0;
  double factor = 1.0;
};

std::vector<Column> columns_of(const core::Table& table, const compensation::LocationOffsets& map,
                               const std::vector<std::string>& axes, const mesh::KinematicChain& chain) {
  std::map<std::string, Column> known{{"time_s", {Column::Kind::time, "time_s"}}};
  for (int i = 0; i < 3; ++i)
    known[fmt::format("point_{}_mm", "xyz"[i])] = {Column::Kind::point, "", i, core::units::mm};
  for (const std::string& axis : axes) {
    const bool rotary = chain.find(axis)->rotary;
    known[axis + (rotary ? "_deg" : "_mm")] = {Column::Kind::position, axis, 0,
                                               rotary ? core::units::deg : core::units::mm};
  }
  for (const std::string& error : map.known_errors()) {
    const bool turns = error[0] >= 'A' && error[0] <= 'C';
    known[error + (turns ? "_um_per_m" : "_um")] = {Column::Kind::error, error, 0,
                                                    turns ? core::units::um_per_m : core::units::um};
  }
  std::vector<std::string> names;
  for (const auto& [name, column] : known) names.push_back(name);
  std::vector<Column> columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const auto found = known.find(table.columns[i]);
    if (found == known.end()) {
      throw core::InputError(fmt::format("{}:1 column {}", table.source, i + 1), "'" + table.columns[i] + "'",
                             "time_s, a position, point_x_mm or a location error of the chain (nearest: " +
                                 core::nearest(table.columns[i], names) + ")");
    }
    columns.push_back(found->second);
  }
  return columns;
}

}  // namespace

void offsets(const OffsetsOptions& options) {
  if (options.out == "-" && options.json)
    throw core::UsageError("--json and the offsets would both go to standard output; allowed: --json with --out FILE");
  mesh::KinematicChain chain = mesh::KinematicChain::parse(options.chain, "--chain");
  const std::vector<std::string> axes = chain.ids();
  for (const std::string& id : options.along_letter) {
    mesh::ChainAxis* axis = chain.find(id);
    if (axis == nullptr || !axis->table_side) {
      throw core::InputError("--with-letter", "'" + id + "'", "axes between w and b of --chain");
    }
    axis->direction = -axis->direction;
  }
  const compensation::LocationOffsets map(
      chain, {options.orientation, options.axes, options.table_radius_mm * core::units::mm});
  const core::Table table = core::read_csv(options.in);
  core::require_time_column(table);
  const std::vector<Column> columns = columns_of(table, map, axes, chain);

  std::string text = "time_s";
  for (const std::string& axis : map.axes())
    text += fmt::format(",offset_{}_{}", axis, chain.find(axis)->rotary ? "um_per_m" : "um");
  text += ",left_x_um,left_y_um,left_z_um,left_a_um_per_m,left_b_um_per_m,left_c_um_per_m\n";
  double largest_left = 0.0, largest_turn_left = 0.0;
  for (Eigen::Index i = 0; i < table.rows(); ++i) {
    std::map<std::string, double> errors, positions;
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const double value = table.values(i, c) * columns[c].factor;
      if (std::isnan(value)) {
        throw core::InputError(fmt::format("{}:{} {}", table.source, core::Table::line_of_row(i), table.columns[c]),
                               "a missing value", "a number");
      }
      if (columns[c].kind == Column::Kind::position) positions[columns[c].name] = value;
      if (columns[c].kind == Column::Kind::point) point[columns[c].component] = value;
      if (columns[c].kind == Column::Kind::error) errors[columns[c].name] = value;
    }
    const compensation::AxisOffsets found = map.offsets(errors, positions, point);
    text += fmt::format("{:.10g}", table.values(i, 0));
    for (const double value : found.offset) text += fmt::format(",{:.4f}", value / core::units::um);
    for (const double value : found.point_left) text += fmt::format(",{:.4f}", value / core::units::um);
    for (const double value : found.orientation_left) text += fmt::format(",{:.4f}", value / core::units::um_per_m);
    text += '\n';
    largest_left = std::max(largest_left, found.point_left.norm());
    largest_turn_left = std::max(largest_turn_left, found.orientation_left.norm());
  }
  if (options.out == "-") {
    std::cout << text;
    return;
  }
  core::write_file(options.out, text);
  const nlohmann::json json = {{"rows", table.rows()},
                               {"offsets", options.out.string()},
                               {"axes", map.axes()},
                               {"largest_point_left_um", largest_left / core::units::um},
                               {"largest_orientation_left_um_per_m", largest_turn_left / core::units::um_per_m}};
  print_summary(options,
                fmt::format("{} rows; uncompensated are at most {:.3g} um at the functional point and {:.3g} um/m of "
                            "orientation; offsets in {}\n",
                            table.rows(), largest_left / core::units::um, largest_turn_left / core::units::um_per_m,
                            options.out.string()),
                json.dump());
}

}  // namespace thermotwin::tools
