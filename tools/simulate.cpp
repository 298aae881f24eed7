// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/file.h"
#include "core/folder_lock.h"
#include "core/progress.h"
#include "core/text.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/case.h"
#include "solver/campaign/files.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "solver/campaign/start_field.h"
#include "solver/campaign/start_field_vtu.h"
#include "solver/elastic/model.h"
#include "solver/elastic/stress.h"
#include "solver/elastic/tcp.h"
#include "solver/export/vtk_output.h"
#include "tools/chain.h"
#include "tools/options.h"

namespace thermotwin::tools {

namespace {

/// Which outputs become fields: all that were chosen, else one every so often, and the last.
std::vector<std::size_t> field_outputs(const std::vector<double>& times, const SimulateOptions& options) {
  std::vector<std::size_t> chosen;
  double next = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (options.output_times.empty() && times[i] < next - 1e-6 && i + 1 < times.size()) continue;
    next = times[i] + options.fields_every_s;
    chosen.push_back(i);
  }
  return chosen;
}

Eigen::VectorXd start_field(const SimulateOptions& options, const solver::FullModel& full,
                            const solver::LoadProgram& program) {
  if (!options.start_from.empty()) {
    const solver::StartField start = solver::field_from_vtu(options.start_from, full.mesh, full.thermal);
    core::log_line(fmt::format("initial field from {}: nodes lie at most {:.2g} mm outside its mesh",
                               options.start_from.string(), 1e3 * start.farthest));
    return start.temperature;
  }
  if (options.start_from_sensors.empty()) return {};
  const core::Table table = core::read_csv(options.start_from_sensors);
  core::require_time_column(table);
  const double time = options.start_time_s >= 0 || table.rows() == 0 ? options.start_time_s : table.values(0, 0);
  return solver::field_from_sensors(table, time, solver::OperatingModel(full.mesh.machine, full.thermal.layout),
                                    program, full.thermal);
}

/// @param mean, power  W that a chiller takes: the mean, and one value for each row
std::string cooling_line(const std::string& coolant, double mean, const Eigen::VectorXd& power) {
  const auto rounded = [](double W) { return std::round(10.0 * W) / 10.0 + 0.0; };  // no -0.0
  const double low = rounded(power.minCoeff()), high = rounded(power.maxCoeff()),
               end = rounded(power(power.size() - 1));
  if (low >= 0.0)
    return fmt::format("coolant {} removes {:.1f} W on average, {:.1f} W at most, {:.1f} W at the end (heat.csv)\n",
                       coolant, rounded(mean), high, end);
  if (high <= 0.0)
    return fmt::format("coolant {} heats by {:.1f} W on average, {:.1f} W at most, {:.1f} W at the end (heat.csv)\n",
                       coolant, rounded(-mean), -low, rounded(-end));
  return fmt::format(
      "coolant {} removes {:.1f} W on average, {:.1f} W at the end, from {:.1f} to {:.1f} W; below 0 it heats "
      "(heat.csv)\n",
      coolant, rounded(mean), end, low, high);
}

/// What each coolant's chiller takes; the first row of heat.csv is the start and has no flows.
std::string cooling_lines(const mesh::Machine& machine, const core::Table& flows, nlohmann::json& json) {
  std::string lines;
  for (const mesh::CoolantSpec& coolant : machine.coolants) {
    const std::string column = "coolant." + coolant.id + ".cooling_power_W";
    const Eigen::Index last = flows.rows() - 1;
    if (last < 1) continue;
    const Eigen::VectorXd time = flows.column("time_s"), power = flows.column(column).tail(last);
    const double mean = power.dot(time.tail(last) - time.head(last)) / (time[last] - time[0]);
    json["cooling_power_W"][coolant.id] = {{"mean", mean}, {"largest", power.maxCoeff()}, {"end", power[last - 1]}};
    lines += cooling_line(coolant.id, mean, power);
  }
  return lines;
}

std::string tcp_table(const core::Table& tcp, nlohmann::json& json) {
  std::vector<std::vector<std::string>> table{{"TCP error", "at the end", "largest"}};
  for (const char* column : {"dx_um", "dy_um", "dz_um", "ra_um_per_m", "rb_um_per_m", "rc_um_per_m"}) {
    const Eigen::VectorXd values = tcp.column(column);
    const double end = values(values.size() - 1), largest = values.cwiseAbs().maxCoeff();
    table.push_back({column, fmt::format("{:.2f}", end), fmt::format("{:.2f}", largest)});
    json["tcp"][column] = {{"end", end}, {"largest", largest}};
  }
  return core::format_table(table);
}

/// What there is to see of a machine without [tcp].
std::string sensor_table(const mesh::Machine& machine, const core::Table& sensors) {
  const std::string no_tcp = "no [tcp] in " + machine.path.filename().string() + ": no TCP error\n";
  if (machine.sensors.empty()) return no_tcp;
  std::vector<std::vector<std::string>> table{{"sensor degC", "at the end", "lowest", "highest"}};
  for (const mesh::SensorSpec& sensor : machine.sensors) {
    const Eigen::VectorXd values = sensors.column(sensor.id + "_C");
    table.push_back({sensor.id, fmt::format("{:.2f}", values(values.size() - 1)),
                     fmt::format("{:.2f}", values.minCoeff()), fmt::format("{:.2f}", values.maxCoeff())});
  }
  return no_tcp + core::format_table(table);
}

/// @param slack  screws that were warned of
void warn_of_slack(const solver::FullModel& full, const Eigen::VectorXd& state, const mesh::Pose& pose, double time,
                   std::set<int>& slack) {
  for (const auto& [screw, tension] : full.elastic.screw_tensions(state, pose)) {
    if (tension < 0.0 && slack.insert(screw).second) {
      core::warn(
          fmt::format("at {:.0f} s the screw '{}' has lost its pretension ({:.0f} N). From then on the TCP error is "
                      "computed as if the screw could push, which it cannot",
                      time, full.mesh.machine.screws[screw].body, tension));
    }
  }
}

nlohmann::json json_of(const solver::LoadResult& result, const mesh::Machine& machine) {
  nlohmann::json json = {{"steps", result.run.steps},
                         {"rejected", result.run.rejected},
                         {"factorisations", result.run.factorisations},
                         {"iterations", result.run.iterations},
                         {"resumed_at_s", result.run.resumed_at}};
  for (const auto& at : result.run.switches) {
    json["switches"].push_back(
        {{"time_s", at.time}, {"coolant", machine.coolants[at.coolant].id}, {"running", at.running}});
  }
  if (result.heat) {
    json["heat"] = {
        {"stored_J", result.heat->stored()}, {"throughput_J", result.heat->throughput()}, {"gap", result.heat->gap()}};
    for (const auto& item : result.heat->items()) json["heat"]["in_J"][item.id] = item.heat;
  }
  return json;
}

}  // namespace

void simulate(const SimulateOptions& options) {
  if (options.steady) return simulate_steady(options);
  const Stopwatch time;
  const solver::Case machine_case = open_case(options.case_path, options.size, options.mesh_order, Asked::heat);
  const mesh::Machine& machine = machine_case.machine;
  solver::LoadProgram program = machine_case.load(options.load);
  if (!options.output_times.empty()) program.choose_outputs(options.output_times, "--output-times");
  const mesh::Pose pose =
      options.pose.empty() ? mesh::home_pose(machine) : mesh::parse_pose(machine, options.pose, "--pose");
  const solver::FullModel full = build(machine_case, options.out, options.solver);

  const auto folder = options.out / "simulate" / program.name();
  const core::FolderLock lock(folder);
  solver::CampaignOptions campaign;
  campaign.poses = {pose};
  campaign.start = start_field(options, full, program);
  campaign.checkpoints = folder;
  campaign.checkpoint_s = options.checkpoint_every_s;
  campaign.resume = options.resume;
  const std::vector<double> times = program.output_times();
  const std::vector<std::size_t> fields = field_outputs(times, options);
  std::vector<std::pair<double, std::string>> files;
  for (std::size_t field : fields) files.emplace_back(times[field], fmt::format("fields/{:06d}.vtu", files.size()));
  const solver::MachineStress stress(full.mesh);
  std::set<int> slack;
  campaign.on_output = [&](const solver::LoadProgram&, const solver::OutputState& output) {
    const auto at = std::find(fields.begin(), fields.end(), output.index);
    if (at == fields.end()) return;
    const auto number = at - fields.begin();
    const Eigen::VectorXd state = output.state;
    const Eigen::Matrix3Xd displacement = full.elastic.displacement(state, pose);
    warn_of_slack(full, state, pose, output.time, slack);
    solver::write_fields(folder / files[number].second, full.mesh, pose,
                         (state.head(full.mesh.nodes()).array() + machine.reference_C).matrix(), displacement,
                         output.time, displacement.cols() > 0 ? stress.nodal(displacement, state) : Eigen::MatrixXd());
    // What there is so far can be looked at while the run goes on.
    solver::write_pvd(folder / "fields.pvd", {files.begin(), files.begin() + number + 1});
  };
  const solver::LoadResult result = solver::run_campaign(full, {program}, campaign).front();
  if (machine.has_tcp())
    core::write_csv(folder / "tcp.csv", result.tcp, solver::table_digits);
  else
    std::filesystem::remove(folder / "tcp.csv");  // of an earlier machine.toml
  core::write_csv(folder / "sensors.csv", result.sensors, solver::table_digits);
  core::write_csv(folder / "heat.csv", result.heat_flows, solver::table_digits);

  nlohmann::json json = json_of(result, machine);
  json["load"] = program.name();
  json["pose"] = mesh::format_pose(machine, pose);
  json["nodes"] = full.mesh.nodes();
  json["folder"] = folder.string();
  std::string heat;
  if (result.heat) heat = result.heat->brief() + "\n" + cooling_lines(machine, result.heat_flows, json);
  const std::string at_pose = machine.axes.empty() ? "" : ", pose " + mesh::format_pose(machine, pose);
  print_summary(options,
                fmt::format("{} ({}){}\n{}\n{}{}: {}\n{} nodes, {} fields, {:.0f} s, {:.2f} GiB; open {} in ParaView\n",
                            program.name(), program.title(), at_pose,
                            machine.has_tcp() ? tcp_table(result.tcp, json) : sensor_table(machine, result.sensors),
                            heat, word(program.time().scheme), result.run.brief(), full.mesh.nodes(), files.size(),
                            time.seconds(), peak_memory_GiB(), (folder / "fields.pvd").string()),
                json.dump());
}

}  // namespace thermotwin::tools
