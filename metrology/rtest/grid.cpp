// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/grid.h"

#include <algorithm>
#include <utility>

#include "core/config.h"
#include "core/error.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/rtest/point_table.h"
#include "metrology/rtest/record_keys.h"

namespace thermotwin::metrology {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
namespace units = core::units;

namespace {

bool moves(const RTestRecord& record, const std::string& axis) {
  double low = 1e300, high = -1e300;
  for (const RTestPoint& point : record.cycles.front().points) {
    const auto at = point.positions.find(axis);
    const double position = at == point.positions.end() ? 0.0 : at->second;
    low = std::min(low, position);
    high = std::max(high, position);
  }
  return high - low > 1e-6;
}

std::vector<std::string> moved_linear_axes(const RTestRecord& record) {
  std::vector<std::string> moved;
  for (const std::string& id : record.chain.ids())
    if (!record.chain.find(id)->rotary && moves(record, id)) moved.push_back(id);
  return moved;
}

std::vector<std::string> candidates(const RTestRecord& record, int order) {
  const std::vector<std::string> moved = moved_linear_axes(record);
  std::vector<std::string> names = usual_errors(record.chain, record.moved_axes());
  for (const char* name : {"X0T", "Y0T", "Z0T", "A0T", "B0T", "C0T"})
    if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
  for (const std::string& id : moved) {
    Index along = 0;
    record.chain.find(id)->direction.cwiseAbs().maxCoeff(&along);
    names.push_back("E" + std::string(1, "XYZ"[along]) + id + "1");
  }
  for (const std::string& id : moved)
    for (const char letter : std::string("ABC")) names.push_back(std::string(1, letter) + "0" + id);
  for (int n = 1; n <= order; ++n) {
    for (const std::string& id : moved) {
      for (const char letter : std::string("XYZABC")) {
        const std::string name = "E" + std::string(1, letter) + id + std::to_string(n);
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
      }
    }
  }
  return names;
}

}  // namespace

ErrorChoice distinguished_errors(const RTestRecord& record, int order) {
  return distinguished(record, candidates(record, order));
}

RTestRecord parse_grid(const std::string& toml, const core::Table& points, const std::string& source) {
  const core::Config config = core::Config::parse(toml, source, &grid_keys());
  const core::Node root = config.root();
  root.schema(1);
  RTestRecord record;
  record.source = source;
  record.table_shift = false;
  read_common(root, record);
  const int order = root.integer("order");
  const std::string place = record.errors_stated ? root.place("errors") : source;
  root.finish();
  record.cycles = read_cycles(points, record.chain, false);
  compare_nothing(record);
  if (moved_linear_axes(record).empty()) {
    throw InputError(points.source, "no linear axis that moves",
                     "columns such as X_mm, with points at several positions of a linear axis");
  }
  if (!record.errors_stated) {
    ErrorChoice choice = distinguished_errors(record, order);
    record.errors = std::move(choice.chosen);
    record.left_out = std::move(choice.left_out);
  }
  if (record.errors.empty()) throw InputError(place, "no error", "errors of the chain");
  std::vector<std::string> seen;
  for (const std::string& error : record.errors) {
    if (std::find(seen.begin(), seen.end(), error) != seen.end())
      throw InputError(place, "'" + error + "' a second time", "each error once");
    seen.push_back(error);
  }
  return record;
}

RTestRecord load_grid(const std::filesystem::path& folder) {
  for (const char* name : {"grid.toml", "points.csv"}) {
    if (!std::filesystem::is_regular_file(folder / name))
      throw InputError(folder.string(), std::string("no file ") + name, "a folder with grid.toml and points.csv");
  }
  const core::Config config = core::Config::load(folder / "grid.toml");
  return parse_grid(config.text(), core::read_csv(folder / "points.csv"), config.source());
}

core::Table residual_table(const RTestRecord& record, const Estimates& estimates) {
  core::Table table;
  table.source = "residuals.csv";
  table.columns = {"time_s", "cycle"};
  const auto& axes = record.cycles.front().points.front().positions;
  for (const auto& [axis, position] : axes)
    table.columns.push_back(axis + (record.chain.find(axis)->rotary ? "_deg" : "_mm"));
  for (const char* column : {"x_mm", "y_mm", "z_mm", "rx_um", "ry_um", "rz_um"}) table.columns.emplace_back(column);
  Index rows = 0;
  for (const RTestCycle& cycle : record.cycles) rows += std::ssize(cycle.points);
  table.values.resize(rows, std::ssize(table.columns));
  Index row = 0;
  for (std::size_t c = 0; c < record.cycles.size(); ++c) {
    for (std::size_t i = 0; i < record.cycles[c].points.size(); ++i, ++row) {
      const RTestPoint& point = record.cycles[c].points[i];
      table.values(row, 0) = point.time;
      table.values(row, 1) = c + 1;
      Index column = 2;
      for (const auto& [axis, position] : point.positions)
        table.values(row, column++) = position / (record.chain.find(axis)->rotary ? units::deg : units::mm);
      table.values.row(row).segment<3>(column) = (point.nominal / units::mm).transpose();
      table.values.row(row).tail<3>() = (estimates.cycles[c].residual.segment<3>(3 * i) / units::um).transpose();
    }
  }
  return table;
}

}  // namespace thermotwin::metrology
