// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/recorder.h"

#include "core/error.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/full_model.h"
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

Recorder::Recorder(const FullModel& model, const LoadProgram& load, const std::vector<mesh::Pose>& poses,
                   const Channels& channels, const HeatBalance& balance, const CampaignOptions& options,
                   std::filesystem::path spool)
    : machine_(model.mesh.machine),
      poses_(poses),
      size_(model.thermal.size),
      snapshots_(options.keep_snapshots),
      spool_path_(options.keep_snapshots ? std::move(spool) : std::filesystem::path()) {
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
  if (snapshots_ && spool_path_.empty()) result_.snapshots.resize(size_, outputs);
}

void Recorder::discard_spool() const {
  std::error_code ignored;
  if (!spool_path_.empty()) std::filesystem::remove(spool_path_, ignored);
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
  filled_ = index + 1;
  if (!snapshots_) return;
  if (spool_path_.empty()) {
    result_.snapshots.col(index) = output.state;
    return;
  }
  if (!spool_.is_open()) {
    std::filesystem::create_directories(spool_path_.parent_path());
    if (index == 0) std::ofstream(spool_path_, std::ios::binary | std::ios::trunc).close();
    spool_.open(spool_path_, std::ios::binary | std::ios::in | std::ios::out);
  }
  const Eigen::VectorXd state = output.state;
  spool_.seekp(index * size_ * sizeof(double));
  spool_.write(reinterpret_cast<const char*>(state.data()), size_ * sizeof(double));
  if (!spool_)
    throw core::InputError(spool_path_.string(), "cannot be written", "a folder with free space and permission");
}

LoadResult Recorder::take() {
  if (snapshots_ && !spool_path_.empty()) {
    spool_.flush();
    result_.snapshots.resize(size_, filled_);
    spool_.seekg(0);
    spool_.read(reinterpret_cast<char*>(result_.snapshots.data()), result_.snapshots.size() * sizeof(double));
    if (!spool_) throw core::InputError(spool_path_.string(), "cannot be read back", "the file as it was written");
    spool_.close();
  }
  return std::move(result_);
}

void Recorder::save(core::BinaryWriter& out) {
  if (spool_.is_open() && !spool_.flush())
    throw core::InputError(spool_path_.string(), "cannot be written", "a folder with free space and permission");
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
  if (!snapshots_ || spool_path_.empty()) return;
  const std::uintmax_t needed = filled_ * size_ * sizeof(double);
  std::error_code error;
  if (const auto there = std::filesystem::file_size(spool_path_, error); error || there < needed) {
    throw core::InputError(spool_path_.string(), "missing or too short for its checkpoint",
                           "both files as the run left them");
  }
  spool_.open(spool_path_, std::ios::binary | std::ios::in | std::ios::out);
}

}  // namespace thermotwin::solver
