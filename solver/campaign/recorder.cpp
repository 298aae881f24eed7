// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/recorder.h"

#include <algorithm>

#include "core/progress.h"
#include "core/thread_pool.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_fields.h"
#include "solver/campaign/load_result.h"
#include "solver/elastic/tcp.h"

namespace thermotwin::solver {

core::Table input_table(const LoadProgram& load, const Channels& channels, double refine) {
  const std::vector<double> outputs = load.output_times(), ends = load.step_ends(refine);
  core::Table table;
  table.columns = {"time_s"};
  table.columns.insert(table.columns.end(), channels.names().begin(), channels.names().end());
  table.values.resize(std::ssize(outputs), 1 + channels.size());
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
    table.values(i, 0) = outputs[i];
    table.values.row(i).tail(channels.size()) = mean.transpose();
  }
  return table;
}

Eigen::MatrixXd stacked_rows(const FullModel& model, const std::vector<mesh::Pose>& poses) {
  if (!model.mesh.machine.has_tcp()) return Eigen::MatrixXd(0, model.thermal.size);
  Eigen::MatrixXd rows(rows_per_pose * std::ssize(poses), model.thermal.size);
  core::Progress progress("output rows", poses.size());
  core::parallel_for(0, poses.size(), [&](std::size_t i) {
    const OutputRows of_pose = model.elastic.output_rows(poses[i]);
    const Eigen::Index first = rows_per_pose * i;
    rows.middleRows<6>(first) = of_pose.tool;
    rows.middleRows<6>(first + 6) = of_pose.table_axis;
    rows.middleRows<7>(first + 12) = of_pose.table_own;
    progress.advance();
  });
  return rows;
}

Recorder::Recorder(const FullModel& model, const LoadProgram& load, const std::vector<mesh::Pose>& poses,
                   const Channels& channels, const HeatBalance& balance, const CampaignOptions& options,
                   const std::filesystem::path& spool)
    : machine_(model.mesh.machine),
      poses_(poses),
      most_modes_(options.field_modes) {
  const auto outputs = std::ssize(load.output_times());
  result_.load = load.name();
  if (machine_.has_tcp()) {
    result_.tcp.columns = {"time_s"};
    for (const std::string& name : mesh::pose_columns(machine_)) result_.tcp.columns.push_back(name);
    for (const std::string& name : tcp_columns()) result_.tcp.columns.push_back(name);
  }
  result_.tcp.values.resize(outputs * std::ssize(poses), std::ssize(result_.tcp.columns));
  result_.sensors.columns = {"time_s"};
  for (const mesh::SensorSpec& sensor : machine_.sensors) result_.sensors.columns.push_back(sensor.id + "_C");
  result_.sensors.values.resize(outputs, std::ssize(result_.sensors.columns));
  result_.inputs = input_table(load, channels, options.refine);
  result_.heat_flows.columns = {"time_s"};
  for (const std::string& name : balance.columns()) result_.heat_flows.columns.push_back(name);
  result_.heat_flows.values.resize(outputs, std::ssize(result_.heat_flows.columns));
  heat_ = balance.amounts();
  const auto spool_of = [&](const std::string& what) {
    return spool.empty() ? spool : spool / (what + "_" + load.name() + ".bin");
  };
  if (options.keep_snapshots) snapshots_.emplace(spool_of("snapshots"), model.thermal.size, outputs);
  if (options.field_modes > 0) {
    kept_ = thinned(outputs, LoadFields::most_times);
    fields_.emplace(spool_of("fields"), model.thermal.size, std::ssize(kept_));
  }
}

void Recorder::discard_spool() const {
  if (snapshots_) snapshots_->discard();
  if (fields_) fields_->discard();
}

Eigen::Index Recorder::kept_filled() const {
  return std::lower_bound(kept_.begin(), kept_.end(), filled_) - kept_.begin();
}

void Recorder::add(const OutputState& output, const Eigen::MatrixXd& rows, const HeatBalance& balance) {
  const Eigen::Index index = output.index;
  const Eigen::VectorXd values = rows * output.state;
  for (std::size_t i = 0; machine_.has_tcp() && i < poses_.size(); ++i) {
    const Eigen::Index first = rows_per_pose * i;
    const TcpError error = tcp_error(machine_, poses_[i], values.segment<6>(first), values.segment<6>(first + 6),
                                     values.segment<7>(first + 12));
    const Eigen::VectorXd position = mesh::pose_values(machine_, poses_[i]);
    auto row = result_.tcp.values.row(index * std::ssize(poses_) + i);
    row[0] = output.time;
    row.segment(1, position.size()) = position.transpose();
    row.tail(18) = tcp_values(error).transpose();
  }
  result_.sensors.values(index, 0) = output.time;
  for (Eigen::Index s = 0; s < output.sensors_K.size(); ++s)
    result_.sensors.values(index, 1 + s) = machine_.reference_C + output.sensors_K[s];
  // Means since the output before; at the start nothing has flowed yet.
  const Eigen::VectorXd heat = balance.amounts();
  const double span = output.time - heat_until_;
  auto flows = result_.heat_flows.values.row(index);
  flows[0] = output.time;
  flows.tail(heat.size()).setConstant(not_given);
  if (span > 0.0) flows.tail(heat.size()) = ((heat - heat_) / span).transpose();
  heat_ = heat;
  heat_until_ = output.time;
  if (snapshots_) snapshots_->put(index, output.state);
  if (std::binary_search(kept_.begin(), kept_.end(), index)) fields_->put(kept_filled(), output.state);
  filled_ = index + 1;
}

LoadResult Recorder::take() {
  if (snapshots_) result_.snapshots = snapshots_->take(filled_);
  if (fields_) result_.fields = compressed(fields_->take(kept_filled()), most_modes_);
  return std::move(result_);
}

void Recorder::save(core::BinaryWriter& out) {
  if (snapshots_) snapshots_->flush();
  if (fields_) fields_->flush();
  out.count(filled_);
  out.matrix(result_.tcp.values.topRows(filled_ * std::ssize(poses_)));
  out.matrix(result_.sensors.values.topRows(filled_));
  out.matrix(result_.heat_flows.values.topRows(filled_));
  out.matrix(heat_);
  out.number(heat_until_);
}

void Recorder::load(core::BinaryReader& in) {
  filled_ = in.count();
  const Eigen::MatrixXd tcp = in.matrix(), sensors = in.matrix(), heat_flows = in.matrix();
  heat_ = in.matrix();
  heat_until_ = in.number();
  result_.tcp.values.topRows(tcp.rows()) = tcp;
  result_.sensors.values.topRows(sensors.rows()) = sensors;
  result_.heat_flows.values.topRows(heat_flows.rows()) = heat_flows;
  if (snapshots_) snapshots_->reopen(filled_);
  if (fields_) fields_->reopen(kept_filled());
}

}  // namespace thermotwin::solver
