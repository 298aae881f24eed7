// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign.h"

#include <map>

#include "core/error.h"
#include "core/progress.h"
#include "core/thread_pool.h"
#include "core/units.h"
#include "solver/campaign_files.h"
#include "solver/tcp.h"

namespace thermotwin::solver {
namespace {

constexpr Eigen::Index rows_per_pose = 19;  // tool 6, table axis 6, table own 7

/// Output rows of all poses in one matrix: a time costs one product for the whole workspace.
Eigen::MatrixXd stack_rows(const FullModel& model, const std::vector<mesh::Pose>& poses) {
  Eigen::MatrixXd rows(rows_per_pose * static_cast<Eigen::Index>(poses.size()), model.thermal.size);
  core::Progress progress("output rows", poses.size());
  core::parallel_for(0, poses.size(), [&](std::size_t i) {
    const OutputRows of_pose = model.elastic.output_rows(poses[i]);
    const Eigen::Index first = rows_per_pose * static_cast<Eigen::Index>(i);
    rows.middleRows<6>(first) = of_pose.tool;
    rows.middleRows<6>(first + 6) = of_pose.table_axis;
    rows.middleRows<7>(first + 12) = of_pose.table_own;
    progress.advance();
  });
  return rows;
}

/// Means of the channels between outputs; the first row is that of the first step.
core::Table input_table(const LoadProgram& load, const Channels& channels, double refine) {
  const std::vector<double> outputs = load.output_times(), ends = load.step_ends(refine);
  core::Table table;
  table.columns = {"time_s"};
  table.columns.insert(table.columns.end(), channels.names().begin(), channels.names().end());
  table.values.resize(static_cast<Eigen::Index>(outputs.size()), 1 + channels.size());
  std::size_t step = 0;
  double from = 0.0;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(channels.size());
    const double begin = from;
    while (step < ends.size() && from < outputs[i] - 1e-9) {
      mean += (ends[step] - from) * load.row(from, ends[step]);
      from = ends[step++];
    }
    mean = from > begin ? Eigen::VectorXd(mean / (from - begin)) : load.row(0.0, ends.front());
    table.values(static_cast<Eigen::Index>(i), 0) = outputs[i];
    table.values.row(static_cast<Eigen::Index>(i)).tail(channels.size()) = mean.transpose();
  }
  return table;
}

class Recorder {
 public:
  Recorder(const FullModel& model, const LoadProgram& load, const std::vector<mesh::Pose>& poses,
           const Channels& channels, const CampaignOptions& options)
      : machine_(model.mesh.machine), poses_(poses) {
    const auto outputs = static_cast<Eigen::Index>(load.output_times().size());
    result_.load = load.name();
    result_.tcp.columns = {"time_s"};
    for (const std::string& name : mesh::pose_columns(machine_)) result_.tcp.columns.push_back(name);
    for (const std::string& name : tcp_columns()) result_.tcp.columns.push_back(name);
    result_.tcp.values.resize(outputs * static_cast<Eigen::Index>(poses.size()),
                              static_cast<Eigen::Index>(result_.tcp.columns.size()));
    result_.sensors.columns = {"time_s"};
    for (const mesh::SensorSpec& sensor : machine_.sensors) result_.sensors.columns.push_back(sensor.id + "_C");
    result_.sensors.values.resize(outputs, static_cast<Eigen::Index>(result_.sensors.columns.size()));
    result_.inputs = input_table(load, channels, options.refine);
    if (options.keep_snapshots) result_.snapshots.resize(model.thermal.size, outputs);
  }

  void add(const OutputState& output, const Eigen::MatrixXd& rows) {
    const auto index = static_cast<Eigen::Index>(output.index);
    const Eigen::VectorXd values = rows * output.state;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const Eigen::Index first = rows_per_pose * static_cast<Eigen::Index>(i);
      const TcpError error = tcp_error(machine_, poses_[i], values.segment<6>(first), values.segment<6>(first + 6),
                                       values.segment<7>(first + 12));
      const Eigen::VectorXd position = mesh::pose_values(machine_, poses_[i]);
      auto row = result_.tcp.values.row(index * static_cast<Eigen::Index>(poses_.size()) + static_cast<Eigen::Index>(i));
      row[0] = output.time;
      row.segment(1, position.size()) = position.transpose();
      row.tail(18) = tcp_values(error).transpose();
    }
    result_.sensors.values(index, 0) = output.time;
    for (Eigen::Index s = 0; s < output.sensors_K.size(); ++s)
      result_.sensors.values(index, 1 + s) = machine_.reference_C + output.sensors_K[s];
    if (result_.snapshots.size() > 0) result_.snapshots.col(index) = output.state;
  }

  LoadResult take() { return std::move(result_); }

 private:
  const mesh::Machine& machine_;
  const std::vector<mesh::Pose>& poses_;
  LoadResult result_;
};

}  // namespace

FullModel build_full_model(const mesh::Machine& machine, const mesh::MeshOptions& options) {
  mesh::MachineMesh mesh = mesh::build_machine_mesh(machine, options);
  ThermalSystem thermal = assemble_thermal(mesh);
  ElasticModel elastic(mesh, thermal);
  return {std::move(mesh), std::move(thermal), std::move(elastic)};
}

// One thermal run a load: the machine moves as its program says, and the temperature that this
// leaves is the same for all poses, which are where its error is read.
std::vector<LoadResult> run_campaign(const FullModel& model, const std::vector<LoadProgram>& loads,
                                     const CampaignOptions& options) {
  const std::vector<mesh::Pose> poses =
      options.poses.empty() ? mesh::workspace_poses(model.mesh.machine) : options.poses;
  std::map<std::string, LoadResult> finished;
  std::map<std::string, std::string> hashes;
  std::vector<LoadProgram> open;
  const std::string mesh_hash = options.out.empty() ? std::string() : hash_of_mesh(model.mesh);
  for (const LoadProgram& load : loads) {
    if (!options.out.empty()) {
      hashes[load.name()] = hash_of_load(model, mesh_hash, load, poses, options);
      if (options.resume)
        if (auto result = read_result(options.out / load.name(), load.name(), hashes[load.name()], options.keep_snapshots)) {
          finished.emplace(load.name(), std::move(*result));
          continue;
        }
    }
    open.push_back(load);
  }

  if (!open.empty()) {
    const Eigen::MatrixXd rows = stack_rows(model, poses);
    const OperatingModel operating(model.mesh.machine, model.thermal.layout);
    IntegratorOptions integrator_options;
    integrator_options.backward_euler = options.backward_euler;
    SimulationOptions simulation_options;
    simulation_options.refine = options.refine;
    for (const auto& block : blocks_of_equal_grid(open, options.refine)) {
      ThermalIntegrator integrator(model.thermal, integrator_options);
      std::vector<Recorder> recorders;
      std::vector<std::size_t> outputs_left;
      recorders.reserve(block.size());
      for (const LoadProgram* load : block) {
        recorders.emplace_back(model, *load, poses, operating.channels(), options);
        outputs_left.push_back(load->output_times().size());
      }
      simulate(integrator, operating, block, simulation_options, [&](const OutputState& output) {
        recorders[output.load].add(output, rows);
        if (--outputs_left[output.load] > 0) return;
        // Written as soon as it is complete, so that a stopped campaign keeps it.
        LoadResult result = recorders[output.load].take();
        const std::string name = result.load;
        if (!options.out.empty()) write_result(options.out / name, result, hashes[name]);
        finished.emplace(name, std::move(result));
      });
    }
  }
  std::vector<LoadResult> results;
  for (const LoadProgram& load : loads) results.push_back(std::move(finished.at(load.name())));
  return results;
}

}  // namespace thermotwin::solver
