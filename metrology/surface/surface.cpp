// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/surface/surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/config.h"
#include "core/error.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/rtest/result_folder.h"

namespace thermotwin::metrology {

using core::InputError;
using core::Table;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
namespace key = core::key;
namespace units = core::units;

namespace {

constexpr double largest_height_um = 1e5, largest_place_mm = 1e5;
constexpr Index modes_of_order[] = {0, 3, 6, 10};

const std::vector<std::string>& mode_names() {
  static const std::vector<std::string> names{"Z0T",   "A0T",    "B0T",    "dome",      "saddle",
                                              "twist", "coma_x", "coma_y", "trefoil_x", "trefoil_y"};
  return names;
}

const core::KeyTable surface_file{
    "surface.toml",
    "Heights of a table's surface for `measure analyse`, beside points.csv.",
    {
        key::schema(),
        key::number("radius_mm", "mm", core::positive, core::required,
                    "Radius of the disc on which the modes are stated; no point lies beyond it."),
        key::whole("order", 1, 3, 2.0, "1: plane; 2: dome, saddle and twist as well; 3: coma and trefoil as well."),
        key::number("std_um", "um", core::positive, core::required, "Standard uncertainty of a height."),
        key::word("reference", {"first", "absolute"}, "first",
                  "first: modes against the first cycle; absolute: modes of the heights as measured. A single cycle is "
                  "always absolute."),
        key::text("pose", "", "Positions of the machine's axes, such as B=0,C=0, for diagnose."),
    }};

constexpr std::array<const char*, 5> surface_columns{"time_s", "cycle", "x_mm", "y_mm", "height_um"};

void check_surface_columns(const Table& table) {
  std::vector<std::string> known(surface_columns.begin(), surface_columns.end());
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    if (std::find(known.begin(), known.end(), table.columns[c]) != known.end()) continue;
    throw InputError(fmt::format("{}:1 column {}", table.source, c + 1), "'" + table.columns[c] + "'",
                     "one of: " + core::join(known) + " (nearest: " + core::nearest(table.columns[c], known) + ")");
  }
  for (const char* name : surface_columns)
    if (!table.find(name)) throw InputError(table.source + ":1", std::string("no column ") + name, core::join(known));
}

double checked_cell(const Table& table, Index row, const std::string& name, double most) {
  const double value = table.values(row, *table.find(name));
  if (std::abs(value) <= most) return value;
  throw InputError(fmt::format("{}:{} {}", table.source, Table::line_of_row(row), name),
                   std::isnan(value) ? std::string("a missing point") : fmt::format("{}", value),
                   fmt::format("a number of at most {:.0e}; leave out the row of a point that was not measured", most));
}

std::vector<SurfaceCycle> read_surface(const Table& table, double radius) {
  if (table.rows() == 0) throw InputError(table.source, "no rows", "at least one point below the column names");
  core::require_time_column(table);
  check_surface_columns(table);
  struct Point {
    Vector2d at;
    double time, height;
  };
  std::vector<SurfaceCycle> cycles;
  std::vector<Point> points;
  const auto close = [&] {
    if (points.empty()) return;
    SurfaceCycle& cycle = cycles.back();
    cycle.time = 0.5 * (points.front().time + points.back().time);
    cycle.at.resize(std::ssize(points), 2);
    cycle.height.resize(std::ssize(points));
    for (Index i = 0; i < std::ssize(points); ++i) {
      cycle.at.row(i) = points[i].at.transpose();
      cycle.height[i] = points[i].height;
    }
    points.clear();
  };
  double last = 0.0;
  for (Index i = 0; i < table.rows(); ++i) {
    const double cycle = checked_cell(table, i, "cycle", 1e9);
    const std::string line = fmt::format("{}:{}", table.source, Table::line_of_row(i));
    if (cycle != std::round(cycle)) throw InputError(line + " cycle", fmt::format("{}", cycle), "a whole number");
    if (!cycles.empty() && cycle < last)
      throw InputError(line + " cycle", fmt::format("{} after {}", cycle, last), "cycles in rising order");
    if (cycles.empty() || cycle > last) {
      close();
      cycles.push_back({fmt::format("{} cycle {}", table.source, cycle), 0.0, {}, {}});
    }
    last = cycle;
    const Vector2d at = units::mm * Vector2d(checked_cell(table, i, "x_mm", largest_place_mm),
                                             checked_cell(table, i, "y_mm", largest_place_mm));
    if (at.norm() > radius * (1.0 + 1e-9)) {
      throw InputError(line, fmt::format("a point at {:.6g} mm from the centre", at.norm() / units::mm),
                       fmt::format("at most radius_mm = {:.6g}", radius / units::mm));
    }
    points.push_back({at, checked_cell(table, i, "time_s", 1e11),
                      units::um * checked_cell(table, i, "height_um", largest_height_um)});
  }
  close();
  return cycles;
}

}  // namespace

const core::KeyTable& surface_keys() { return surface_file; }

SurfaceRecord SurfaceRecord::parse(const std::string& toml, const Table& points, const std::string& source) {
  const core::Config config = core::Config::parse(toml, source, &surface_keys());
  const core::Node root = config.root();
  root.schema(1);
  SurfaceRecord record;
  record.source = source;
  record.radius = root.number("radius_mm") * units::mm;
  record.order = root.integer("order");
  record.std = root.number("std_um") * units::um;
  record.against_first = root.choice("reference") == "first";
  record.pose = root.text("pose");
  require_pose_text(record.pose, root.place("pose"));
  root.finish();
  record.cycles = read_surface(points, record.radius);
  record.alone = record.against_first && record.cycles.size() == 1;
  if (record.alone) record.against_first = false;
  return record;
}

SurfaceRecord SurfaceRecord::load(const std::filesystem::path& folder) {
  for (const char* name : {"surface.toml", "points.csv"}) {
    if (!std::filesystem::is_regular_file(folder / name))
      throw InputError(folder.string(), std::string("no file ") + name, "a folder with surface.toml and points.csv");
  }
  const core::Config config = core::Config::load(folder / "surface.toml");
  return parse(config.text(), core::read_csv(folder / "points.csv"), config.source());
}

VectorXd surface_modes(const Vector2d& at, double radius, int order) {
  VectorXd modes(modes_of_order[order]);
  const double x = at.x() / radius, y = at.y() / radius, square = x * x + y * y;
  modes.head<3>() << 1.0, at.y(), -at.x();
  if (order >= 2) modes.segment<3>(3) << square - 0.5, x * x - y * y, 2.0 * x * y;
  if (order >= 3) {
    const double coma = 3.0 * square - 2.0;
    modes.segment<4>(6) << coma * x, coma * y, x * x * x - 3.0 * x * y * y, 3.0 * x * x * y - y * y * y;
  }
  return modes;
}

Estimates analyse(const SurfaceRecord& record) {
  Estimates result;
  const Index modes = modes_of_order[record.order];
  result.errors.assign(mode_names().begin(), mode_names().begin() + modes);
  for (const std::string& name : result.errors)
    result.units.emplace_back(name[0] == 'A' || name[0] == 'B' ? "um/m" : "um");
  std::vector<bool> named(result.errors.size(), false);
  for (const SurfaceCycle& cycle : record.cycles) {
    if (cycle.height.size() < modes) {
      throw InputError(cycle.place, fmt::format("{} points for {} modes", cycle.height.size(), modes),
                       fmt::format("at least {} points, or a lower order", modes));
    }
    MatrixXd rows(cycle.height.size(), modes);
    for (Index i = 0; i < rows.rows(); ++i)
      rows.row(i) = surface_modes(cycle.at.row(i).transpose(), record.radius, record.order).transpose();
    if (const LinearFit plane = fit_linear(rows.leftCols(3), cycle.height); plane.unobserved.cols() > 0) {
      throw InputError(cycle.place, "points on a line or at one place",
                       "points that span the surface in both directions");
    }
    const LinearFit fit = fit_linear(rows, cycle.height);
    for (std::size_t m = 0; m < result.errors.size(); ++m) {
      if (named[m] || !fit.hides(m)) continue;
      named[m] = true;
      result.not_observable.push_back(result.errors[m] + ": not observable: " + fit.same_effect(result.errors, m, ""));
    }
    result.cycles.push_back(cycle_result(fit, modes, record.std * record.std));
    result.cycles.back().time = cycle.time;
  }
  if (result.observed().empty()) {
    throw InputError(record.source, "no observable mode: " + core::join(result.not_observable, "; "),
                     "points that distinguish at least one mode, or a lower order");
  }
  complete(result.cycles, record.against_first);
  return result;
}

Table surface_map(const SurfaceRecord& record, const Estimates& estimates, int steps) {
  std::vector<Vector2d> grid;
  for (int i = -steps; i <= steps; ++i) {
    for (int k = -steps; k <= steps; ++k) {
      const Vector2d at = record.radius / steps * Vector2d(i, k);
      if (at.norm() <= record.radius * (1.0 + 1e-9)) grid.push_back(at);
    }
  }
  Table table;
  table.source = "map.csv";
  table.columns = {"time_s", "cycle", "x_mm", "y_mm", "height_um", "bending_um"};
  table.values.resize(std::ssize(grid) * std::ssize(estimates.cycles), 6);
  Index row = 0;
  for (std::size_t c = 0; c < estimates.cycles.size(); ++c) {
    const VectorXd value = estimates.cycles[c].value.unaryExpr([](double v) { return std::isnan(v) ? 0.0 : v; });
    for (const Vector2d& at : grid) {
      const VectorXd share = surface_modes(at, record.radius, record.order).cwiseProduct(value);
      table.values.row(row++) << estimates.cycles[c].time, c + 1, at.x() / units::mm, at.y() / units::mm,
          share.sum() / units::um, share.tail(share.size() - 3).sum() / units::um;
    }
  }
  return table;
}

Table surface_points(const SurfaceRecord& record, const Estimates& estimates) {
  Table table;
  table.source = "residuals.csv";
  table.columns = {"time_s", "cycle", "x_mm", "y_mm", "height_um", "residual_um"};
  Index rows = 0, row = 0;
  for (const SurfaceCycle& cycle : record.cycles) rows += cycle.height.size();
  table.values.resize(rows, 6);
  for (std::size_t c = 0; c < record.cycles.size(); ++c) {
    const SurfaceCycle& cycle = record.cycles[c];
    for (Index i = 0; i < cycle.height.size(); ++i) {
      table.values.row(row++) << cycle.time, c + 1, cycle.at(i, 0) / units::mm, cycle.at(i, 1) / units::mm,
          cycle.height[i] / units::um, estimates.cycles[c].residual[i] / units::um;
    }
  }
  return table;
}

}  // namespace thermotwin::metrology
