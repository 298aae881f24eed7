// SPDX-License-Identifier: GPL-3.0-or-later
// `simulate --steady`: what each phase of a load program tends to, by one solution a phase.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

#include "core/file.h"
#include "core/folder_lock.h"
#include "core/progress.h"
#include "core/text.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/steady_state.h"
#include "solver/elastic/model.h"
#include "solver/elastic/stress.h"
#include "solver/elastic/tcp.h"
#include "solver/export/vtk_output.h"
#include "solver/thermal/heat_balance.h"
#include "tools/chain.h"
#include "tools/options.h"

namespace thermotwin::tools {

namespace {

/// The tables of `simulate`, with a row for each phase.
struct SteadyTables {
  core::Table tcp, sensors, heat;
  double largest_gap = 0;  ///< of the heat balances, share of what flows
};

SteadyTables tables_of(const solver::FullModel& full, const mesh::Pose& pose,
                       const std::vector<solver::SteadyPhase>& phases, const std::vector<solver::SteadyState>& states) {
  const mesh::Machine& machine = full.mesh.machine;
  SteadyTables tables;
  tables.tcp.columns = tables.sensors.columns = tables.heat.columns = {"time_s"};
  const auto append = [](core::Table& table, const std::vector<std::string>& names) {
    table.columns.insert(table.columns.end(), names.begin(), names.end());
  };
  if (machine.has_tcp()) {
    append(tables.tcp, mesh::pose_columns(machine));
    append(tables.tcp, solver::tcp_columns());
  }
  for (const mesh::SensorSpec& sensor : machine.sensors) append(tables.sensors, {sensor.id + "_C"});
  append(tables.heat, solver::HeatBalance(machine, full.thermal).columns());
  const auto count = std::ssize(phases);
  for (core::Table* table : {&tables.tcp, &tables.sensors, &tables.heat})
    table->values.resize(count, std::ssize(table->columns));
  const solver::OutputRows rows = machine.has_tcp() ? full.elastic.output_rows(pose) : solver::OutputRows{};
  for (Eigen::Index i = 0; i < count; ++i) {
    const solver::SteadyState& state = states[i];
    for (core::Table* table : {&tables.tcp, &tables.sensors, &tables.heat}) table->values(i, 0) = phases[i].end;
    if (machine.has_tcp()) {
      const solver::TcpError error =
          solver::tcp_error(machine, pose, rows.tool * state.temperature, rows.table_axis * state.temperature,
                            rows.table_own * state.temperature);
      const Eigen::VectorXd position = mesh::pose_values(machine, pose);
      tables.tcp.values.row(i).segment(1, position.size()) = position.transpose();
      tables.tcp.values.row(i).tail(18) = solver::tcp_values(error).transpose();
    }
    tables.sensors.values.row(i).tail(state.sensors_K.size()) =
        (state.sensors_K.array() + machine.reference_C).transpose();
    solver::HeatBalance balance(machine, full.thermal);  // over one second: what flows in W
    balance.add(state.temperature, state.temperature, state.temperature, state.coefficients.p, state.coefficients.q,
                1.0, state.local.empty() ? nullptr : &state.local);
    const Eigen::VectorXd flows = balance.amounts();
    tables.heat.values.row(i).tail(flows.size()) = flows.transpose();
    tables.largest_gap = std::max(tables.largest_gap, balance.gap());
  }
  return tables;
}

/// Fields of all phases, and fields.pvd that names them.
void write_all_fields(const std::filesystem::path& folder, const solver::FullModel& full, const mesh::Pose& pose,
                      const std::vector<solver::SteadyPhase>& phases, const std::vector<solver::SteadyState>& states) {
  const solver::MachineStress stress(full.mesh);
  std::vector<std::pair<double, std::string>> files;
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const Eigen::VectorXd& state = states[i].temperature;
    const Eigen::Matrix3Xd displacement = full.elastic.displacement(state, pose);
    files.emplace_back(phases[i].end, fmt::format("fields/{:06d}.vtu", i));
    solver::write_fields(folder / files.back().second, full.mesh, pose,
                         (state.head(full.mesh.nodes()).array() + full.mesh.machine.reference_C).matrix(), displacement,
                         phases[i].end,
                         displacement.cols() > 0 ? stress.nodal(displacement, state) : Eigen::MatrixXd());
  }
  solver::write_pvd(folder / "fields.pvd", files);
}

void warn_of_chillers(const mesh::Machine& machine, const solver::SteadyPhase& phase,
                      const solver::SteadyState& state) {
  for (const int coolant : state.switching)
    core::warn(fmt::format("{}: the compressor of coolant '{}' switches; its set point stands for the mean", phase.name,
                           machine.coolants[coolant].id));
  for (const int coolant : state.at_limit)
    core::warn(fmt::format("{}: the chiller of coolant '{}' is at the limit of its cooling power", phase.name,
                           machine.coolants[coolant].id));
}

/// One line a phase: the TCP error, or the sensors of a machine without [tcp].
std::string phase_table(const mesh::Machine& machine, const std::vector<solver::SteadyPhase>& phases,
                        const SteadyTables& tables, nlohmann::json& json) {
  const core::Table& table = machine.has_tcp() ? tables.tcp : tables.sensors;
  std::vector<std::string> columns;
  if (machine.has_tcp())
    columns = {"dx_um", "dy_um", "dz_um", "ra_um_per_m", "rb_um_per_m", "rc_um_per_m"};
  else
    columns.assign(table.columns.begin() + 1, table.columns.end());
  std::vector<std::vector<std::string>> lines{{"steady state of"}};
  lines.front().insert(lines.front().end(), columns.begin(), columns.end());
  for (std::size_t i = 0; i < phases.size(); ++i) {
    lines.push_back({phases[i].name});
    nlohmann::json entry = {{"phase", phases[i].name}, {"end_s", phases[i].end}};
    for (const std::string& column : columns) {
      const double value = table.column(column)[i];
      lines.back().push_back(fmt::format("{:.2f}", value));
      entry[column] = value;
    }
    json["phases"].push_back(entry);
  }
  return core::format_table(lines);
}

}  // namespace

void simulate_steady(const SimulateOptions& options) {
  const Stopwatch time;
  const solver::Case machine_case = open_case(options.case_path, options.size, options.mesh_order, Asked::heat);
  const mesh::Machine& machine = machine_case.machine;
  const solver::LoadProgram program = machine_case.load(options.load);
  const mesh::Pose pose =
      options.pose.empty() ? mesh::home_pose(machine) : mesh::parse_pose(machine, options.pose, "--pose");
  const solver::FullModel full = build(machine_case, options.out, options.solver);
  const auto folder = options.out / "steady" / program.name();
  const core::FolderLock lock(folder);
  const solver::OperatingModel operating(machine, full.thermal.layout);
  const std::vector<solver::SteadyPhase> phases = solver::steady_phases(program);
  std::vector<solver::SteadyState> states;
  {
    core::Progress progress("steady states", phases.size());
    for (const solver::SteadyPhase& phase : phases) {
      states.push_back(solver::steady_state(full.thermal, operating, phase.row));
      warn_of_chillers(machine, phase, states.back());
      progress.advance();
    }
  }
  const SteadyTables tables = tables_of(full, pose, phases, states);
  if (machine.has_tcp())
    core::write_csv(folder / "tcp.csv", tables.tcp);
  else
    std::filesystem::remove(folder / "tcp.csv");  // of an earlier machine.toml
  core::write_csv(folder / "sensors.csv", tables.sensors);
  core::write_csv(folder / "heat.csv", tables.heat);
  write_all_fields(folder, full, pose, phases, states);

  nlohmann::json json = {{"load", program.name()},
                         {"pose", mesh::format_pose(machine, pose)},
                         {"nodes", full.mesh.nodes()},
                         {"folder", folder.string()},
                         {"heat_gap", tables.largest_gap}};
  int passes = 0;
  for (const solver::SteadyState& state : states) passes += state.passes;
  json["solutions"] = passes;
  const std::string lines = phase_table(machine, phases, tables, json);  // before the dump: it fills json
  const std::string at_pose = machine.axes.empty() ? "" : ", pose " + mesh::format_pose(machine, pose);
  print_summary(options,
                fmt::format("{} ({}){}\n{}\nheat balance: imbalance at most {:.1e} of the throughput\n"
                            "{} solutions for {} phases, {} nodes, {:.0f} s; open {} in ParaView\n",
                            program.name(), program.title(), at_pose, lines, tables.largest_gap, passes, phases.size(),
                            full.mesh.nodes(), time.seconds(), (folder / "fields.pvd").string()),
                json.dump());
}

}  // namespace thermotwin::tools
