// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/plan/plan_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/config.h"
#include "core/error.h"
#include "core/file.h"
#include "core/table.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/plan/sphere.h"
#include "solver/operation/channels.h"
#include "solver/operation/load_program.h"

namespace thermotwin::metrology {

namespace fs = std::filesystem;
namespace units = core::units;
namespace key = core::key;
using core::Absent;
using core::InputError;
using core::Table;
using Eigen::Index;
using mesh::Axis;
using mesh::AxisKind;
using mesh::Machine;

namespace {

constexpr double row_interval = 60;  ///< s, of rows.csv

const core::KeyTable plan_file{
    "plan.toml",
    "A thermal test, written by `measure plan` and read by `measure simulate`, beside points.csv and load.toml.",
    {
        key::schema(),
        key::word("kind", test_kinds(), core::required, "The test."),
        key::text("machine", core::required, "Name of the machine that it is for."),
        key::text("tested", Absent{"none"}, "Axis that is tested."),
        key::text("load", "load.toml", "Its load program, a file of the folder."),
        key::point("tool_offset_mm", "mm", Absent{"0, 0, 0"},
                   "Vector from tcp.tool_point of the machine to the measured point, all axes at 0."),
        key::table("probes", probe_keys(), core::required, "The probes."),
    }};

Table points_table(const Machine& machine, const TestPlan& plan) {
  Table table;
  table.source = "points.csv";
  table.columns = {"time_s", "cycle"};
  for (const std::string& column : mesh::pose_columns(machine)) table.columns.push_back(column);
  for (const char* column : {"x_mm", "y_mm", "z_mm"}) table.columns.emplace_back(column);
  const Index axes = std::ssize(machine.axes);
  table.values.resize(std::ssize(plan.points), std::ssize(table.columns));
  for (Index i = 0; i < table.rows(); ++i) {
    const PlannedPoint& point = plan.points[i];
    table.values(i, 0) = point.time;
    table.values(i, 1) = point.cycle;
    table.values.row(i).segment(2, axes) = mesh::pose_values(machine, point.pose).transpose();
    table.values.row(i).tail<3>() = (point.sphere / units::mm).transpose();
  }
  // A sine of pi is no position.
  table.values = (table.values.array().abs() < 1e-9).select(0.0, table.values);
  return table;
}

/// The channels of a load program as rows of a control.
Table control_rows(const Machine& machine, const solver::LoadProgram& load) {
  const solver::Channels channels(machine);
  const std::vector<double> stops = load.stops();
  std::vector<double> starts;
  double before = 0.0;
  for (const double stop : stops) {
    const int parts = std::max(1, static_cast<int>(std::ceil((stop - before) / row_interval - 1e-9)));
    for (int k = 0; k < parts; ++k) starts.push_back(before + (stop - before) * k / parts);
    before = stop;
  }
  starts.push_back(before);
  Table table;
  table.source = "rows.csv";
  table.columns = {"time_s"};
  const std::vector<std::string>& names = channels.names();
  std::vector<Index> kept;
  Eigen::MatrixXd rows(std::ssize(starts), channels.size());
  for (Index i = 0; i < rows.rows(); ++i) {
    const double from = starts[i], to = i + 1 < rows.rows() ? starts[i + 1] : from;
    rows.row(i) = (to > from ? load.row(from, to) : load.row_at(from, from - 1e-6)).transpose();
  }
  for (Index c = 0; c < channels.size(); ++c) {
    if (!rows.col(c).array().isFinite().any()) continue;
    kept.push_back(c);
    table.columns.push_back(names[c]);
  }
  table.values.resize(rows.rows(), 1 + std::ssize(kept));
  for (Index i = 0; i < rows.rows(); ++i) table.values(i, 0) = starts[i];
  for (std::size_t k = 0; k < kept.size(); ++k) table.values.col(1 + k) = rows.col(kept[k]);
  return table;
}

}  // namespace

const core::KeyTable& plan_keys() { return plan_file; }

void move_tool_point(Machine& machine, const Eigen::Vector3d& offset) { machine.tcp.tool_point += offset; }

std::string rtest_text(const Machine& machine, double std, const std::string& more) {
  std::string text = "# SPDX-License-Identifier: GPL-3.0-or-later\nschema = 1\n";
  text += fmt::format("chain = \"{}\"\ntable_radius_mm = {:.12g}\nstd_um = {:.6g}\n", machine.kinematic_chain,
                      machine.tcp.table_radius > 0 ? machine.tcp.table_radius / units::mm : 300.0, std / units::um);
  text += more;
  const mesh::KinematicChain chain = chain_of(machine);
  for (const Axis& axis : machine.axes) {
    if (axis.kind != AxisKind::rotary) continue;
    const Eigen::Vector3d origin = axis.origin / units::mm;
    text += fmt::format("[[axis]]\nid = \"{}\"\nx_mm = {:.12g}\ny_mm = {:.12g}\nz_mm = {:.12g}\n", axis.id, origin.x(),
                        origin.y(), origin.z());
    const mesh::ChainAxis& linked = *chain.find(axis.id);
    if (linked.table_side && linked.direction.sum() > 0) text += "with_letter = true\n";
  }
  return text;
}

void write_plan(const fs::path& folder, const Machine& machine, const TestPlan& plan, const ProbeSetup& probes,
                const Eigen::Vector3d& tool_offset) {
  const std::string kind = test_kinds()[static_cast<std::size_t>(plan.options.kind)];
  const std::string title = kind + (plan.tested.empty() ? "" : " of " + plan.tested);
  const bool continuous = plan.options.kind == TestKind::rtest_continuous;
  core::write_files_by(folder, [&](const fs::path& staged) {
    const std::string load = load_text(machine, plan.timeline, title, plan.options.air_C, machine.reference_C);
    core::write_file(staged / "load.toml", load);
    core::write_csv(staged / "rows.csv",
                    control_rows(machine, solver::LoadProgram::parse(load, folder / "load.toml", machine)));
    core::write_file(staged / "program.nc", nc_text(machine, plan.timeline, title));
    core::write_csv(staged / "points.csv", points_table(machine, plan), 12);
    const Eigen::Vector3d offset = tool_offset / units::mm;
    const std::string text = fmt::format(
        "# SPDX-License-Identifier: GPL-3.0-or-later\nschema = 1\nkind = \"{}\"\nmachine = \"{}\"\n{}load = "
        "\"load.toml\"\ntool_offset_mm = [{:.12g}, {:.12g}, {:.12g}]\n",
        kind, machine.name, plan.tested.empty() ? "" : "tested = \"" + plan.tested + "\"\n", offset.x(), offset.y(),
        offset.z());
    core::write_file(staged / "plan.toml", text + probes_text(probes));
    std::vector<fs::path> files{"load.toml", "rows.csv", "program.nc", "points.csv"};
    if (plan.is_rtest()) {
      const double std = probes.std_of_point(continuous ? 1.0 : probes.averaged());
      core::write_file(staged / "rtest.toml", rtest_text(machine, std, "") + probes_text(probes));
      files.emplace_back("rtest.toml");
    }
    files.emplace_back("plan.toml");
    return files;
  });
}

PlanFolder read_plan(const fs::path& folder, const Machine& machine) {
  for (const char* name : {"plan.toml", "points.csv"}) {
    if (!fs::is_regular_file(folder / name))
      throw InputError(folder.string(), std::string("no file ") + name, "a folder that `measure plan` has written");
  }
  const core::Config config = core::Config::load(folder / "plan.toml", &plan_file);
  const core::Node root = config.root();
  root.schema(1);
  PlanFolder plan;
  plan.kind = root.choice("kind");
  if (const std::string name = root.text("machine"); name != machine.name)
    throw InputError(root.place("machine"), "'" + name + "'", "the machine of the case, '" + machine.name + "'");
  plan.tested = root.text_or("tested", "");
  plan.load = folder / root.text("load");
  if (root.has("tool_offset_mm")) plan.tool_offset = root.vector3("tool_offset_mm") * units::mm;
  plan.probes = read_probes(root.table("probes"));
  root.finish();
  TestPlan same{{}, "", Timeline(machine, mesh::home_pose(machine), "plan"), {}};
  same.options.kind = test_kind(plan.kind);
  plan.is_rtest = same.is_rtest();
  const Table table = core::read_csv(folder / "points.csv");
  core::require_time_column(table);
  const std::vector<std::string> poses = mesh::pose_columns(machine);
  for (const std::string& column : poses) table.require_complete(column);
  std::map<int, int> places;
  for (Index i = 0; i < table.rows(); ++i) {
    PlannedPoint point;
    point.time = table.values(i, 0);
    point.cycle = static_cast<int>(std::lround(table.column("cycle")[i]));
    point.place = ++places[point.cycle];
    point.pose.resize(std::ssize(machine.axes));
    plan.points.push_back(std::move(point));
  }
  const Eigen::VectorXd x = table.column("x_mm"), y = table.column("y_mm"), z = table.column("z_mm");
  for (Index i = 0; i < table.rows(); ++i) plan.points[i].sphere = units::mm * Eigen::Vector3d(x[i], y[i], z[i]);
  for (std::size_t a = 0; a < poses.size(); ++a) {
    const Axis& axis = machine.axes[a];
    const double unit = axis.kind == AxisKind::linear ? units::mm : units::deg;
    const Eigen::VectorXd values = table.column(poses[a]) * unit;
    for (Index i = 0; i < table.rows(); ++i) {
      plan.points[i].pose[a] = values[i];
      if (axis.endless || (values[i] >= axis.low - 1e-8 && values[i] <= axis.high + 1e-8)) continue;
      throw InputError(fmt::format("{}:{} {}", table.source, Table::line_of_row(i), poses[a]),
                       fmt::format("{:.6g}", values[i] / unit),
                       fmt::format("the travel {:.6g} to {:.6g}", axis.low / unit, axis.high / unit));
    }
  }
  return plan;
}

}  // namespace thermotwin::metrology
