// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/variants/variant_recorder.h"

#include <algorithm>
#include <utility>

#include "core/thread_pool.h"
#include "solver/campaign/recorder.h"
#include "solver/elastic/tcp.h"

namespace thermotwin::study {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr Index error_columns = 6;
constexpr Index columns_at_once = 16;  // of a product: fixed, so that bits do not depend on the threads

}  // namespace

MatrixXd error_rows(const mesh::Machine& machine, const std::vector<mesh::Pose>& poses, const MatrixXd& rows) {
  MatrixXd made(error_columns * std::ssize(poses), rows.cols());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Index first = solver::rows_per_pose * i;
    Eigen::Matrix<double, error_columns, solver::rows_per_pose> parts;
    for (Index k = 0; k < solver::rows_per_pose; ++k) {
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(solver::rows_per_pose, k);
      parts.col(k) = solver::tcp_values(solver::tcp_error(machine, poses[i], unit.segment<6>(0), unit.segment<6>(6),
                                                          unit.segment<7>(12)))
                         .head<error_columns>();
    }
    made.middleRows(error_columns * i, error_columns) = parts * rows.middleRows(first, solver::rows_per_pose);
  }
  return made;
}

VariantRecorder::VariantRecorder(const mesh::Machine& machine, const std::vector<mesh::Pose>& poses,
                                 const MatrixXd& rows, std::size_t variants, std::size_t outputs)
    : machine_(machine),
      poses_(poses),
      rows_(rows),
      states_(rows.cols(), variants) {
  VariantTables empty;
  empty.tcp.columns = {"time_s"};
  for (const std::string& name : mesh::pose_columns(machine)) empty.tcp.columns.push_back(name);
  const std::vector<std::string> values = solver::tcp_columns();
  empty.tcp.columns.insert(empty.tcp.columns.end(), values.begin(), values.begin() + error_columns);
  empty.tcp.values.setZero(outputs * poses.size(), std::ssize(empty.tcp.columns));
  empty.sensors.columns = {"time_s"};
  for (const mesh::SensorSpec& sensor : machine.sensors) empty.sensors.columns.push_back(sensor.id + "_C");
  empty.sensors.values.setZero(outputs, std::ssize(empty.sensors.columns));
  tables_.assign(variants, empty);
}

void VariantRecorder::add(const solver::OutputState& output) {
  const Index index = output.index, load = output.load;
  states_.col(load) = output.state;
  auto sensors = tables_[output.load].sensors.values.row(index);
  sensors[0] = output.time;
  for (Index s = 0; s < output.sensors_K.size(); ++s) sensors[1 + s] = machine_.reference_C + output.sensors_K[s];
  if (output.load + 1 < tables_.size()) return;
  MatrixXd values(rows_.rows(), states_.cols());
  core::parallel_for(0, (states_.cols() + columns_at_once - 1) / columns_at_once, [&](std::size_t part) {
    const Index first = part * columns_at_once;
    const Index width = std::min(columns_at_once, states_.cols() - first);
    values.middleCols(first, width).noalias() = rows_ * states_.middleCols(first, width);
  });
  for (Index i = 0; i < std::ssize(poses_); ++i) {
    const Eigen::VectorXd position = mesh::pose_values(machine_, poses_[i]);
    for (std::size_t v = 0; v < tables_.size(); ++v) {
      auto row = tables_[v].tcp.values.row(index * std::ssize(poses_) + i);
      row[0] = output.time;
      row.segment(1, position.size()) = position.transpose();
      row.tail(error_columns) = values.col(v).segment(error_columns * i, error_columns).transpose();
    }
  }
  filled_ = index + 1;
}

std::vector<VariantTables> VariantRecorder::take() { return std::move(tables_); }

void VariantRecorder::save(core::BinaryWriter& out) const {
  out.count(filled_);
  for (const VariantTables& of : tables_) {
    out.matrix(of.tcp.values.topRows(filled_ * std::ssize(poses_)));
    out.matrix(of.sensors.values.topRows(filled_));
  }
}

void VariantRecorder::load(core::BinaryReader& in) {
  filled_ = in.count();
  for (VariantTables& of : tables_) {
    const MatrixXd tcp = in.matrix(), sensors = in.matrix();
    of.tcp.values.topRows(tcp.rows()) = tcp;
    of.sensors.values.topRows(sensors.rows()) = sensors;
  }
}

}  // namespace thermotwin::study
