// SPDX-License-Identifier: GPL-3.0-or-later
// The reduced model of the machine on a measurement, with and without sensors.

#include "compensation/evaluation/reduced_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <sstream>

#include "compensation/evaluation/replay.h"
#include "compensation/evaluation/scoring.h"
#include "compensation/measurement/measurement_check.h"
#include "compensation/measurement/unit_hint.h"
#include "core/error.h"
#include "core/text.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "solver/elastic/outputs.h"

namespace thermotwin::compensation {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double beside = 0.1;  ///< m, from the pose to those beside it

/// Index of the body that an axis moves; -1: none.
int body_of_axis(const mesh::Machine& machine, const std::string& axis) {
  for (Index i = 0; i < std::ssize(machine.bodies); ++i)
    if (machine.bodies[i].axis == axis) return i;
  return -1;
}

/// Whether a body is the other one or carries it.
bool carries(const mesh::Machine& machine, int body, int other) {
  for (; other >= 0; other = machine.body_index(machine.bodies[other].parent))
    if (other == body) return true;
  return false;
}

/// The body's position; of the foundation nothing moves.
Eigen::Isometry3d transform_of(const mesh::Machine& machine, int body, const mesh::Pose& pose) {
  return body < 0 ? Eigen::Isometry3d::Identity() : mesh::body_transform(machine, body, pose);
}

/// Sensors that the compensator left out, by their status ("T1=stuck"), with the share of the rows.
/// @param failed  (rows) Offsets::failed_sensors
std::string left_out_sensors(const std::vector<std::string>& failed) {
  std::map<std::string, std::size_t> rows;
  for (const std::string& row : failed) {
    std::istringstream words(row);
    for (std::string sensor; words >> sensor;) ++rows[sensor];
  }
  std::vector<std::string> parts;
  for (const auto& [sensor, count] : rows)
    parts.push_back(fmt::format("{} in {} of {} rows", sensor, count, failed.size()));
  return core::join(parts);
}

}  // namespace

void score_reduced_model(const Measurement& measurement, const reduction::ReducedModel& model, const std::string& name,
                         bool with_sensors, Scorer& scorer) {
  require_fits(measurement, model.machine);
  const std::vector<MeasuredChannel>& displacements = scorer.data().targets;
  std::vector<ObservedQuantity> quantities;
  std::vector<mesh::Pose> poses;
  for (const MeasuredChannel& channel : displacements) {
    const mesh::Pose pose = mesh::parse_pose(model.machine, channel.pose_text, channel.id);
    quantities.emplace_back(model.machine, channel, pose);
    poses.insert(poses.end(), quantities.back().poses().begin(), quantities.back().poses().end());
  }
  std::vector<std::string> failed;
  const std::vector<std::vector<solver::TcpError>> errors = run_compensator(
      measurement, model, poses, {with_sensors, false, 0}, with_sensors ? &scorer.observer : nullptr, &failed);
  std::size_t first = 0;  // of the channel's poses
  for (std::size_t k = 0; k < displacements.size(); ++k) {
    const std::size_t count = quantities[k].poses().size();
    VectorXd predicted(std::ssize(errors[first]));
    for (Index i = 0; i < predicted.size(); ++i) {
      std::vector<solver::TcpError> at;
      for (std::size_t p = 0; p < count; ++p) at.push_back(errors[first + p][i]);
      predicted[i] = quantities[k](at);
    }
    first += count;
    if (!with_sensors) {
      if (const auto hint = unit_hint(displacements[k], scorer.data().target_values.col(k), predicted))
        scorer.note(name + ": " + in_words(*hint, displacements[k]));
    }
    scorer.add(with_sensors ? name + "_sensors" : name, k, predicted, false);
  }
  if (const std::string sensors = left_out_sensors(failed); !sensors.empty())
    scorer.note(fmt::format("{}_sensors: sensors left out: {}", name, sensors));
  if (!with_sensors) {
    if (solver::Channels(model.machine).index(mesh::time_of_day) >= 0 && !tells_time_of_day(measurement)) {
      scorer.note(name +
                  ": the time of day is not recorded, so that laws of machine.toml over day.time_h contribute "
                  "0; state starts_at under [record] of channels.toml");
    }
    scorer.note(fmt::format("{}: not fitted; initial temperature uniform at {:.2f} degC", name,
                            start_temperature(measurement, model.machine)));
  }
}

ObservedQuantity::ObservedQuantity(const mesh::Machine& machine, const MeasuredChannel& channel, const mesh::Pose& pose)
    : machine_(machine),
      poses_{pose} {
  static const std::vector<std::string> direct = {"dx", "dy", "dz", "ra", "rb", "rc"};
  static const std::string iso = "XYZABCR";
  if (!channel.points.empty()) {
    poses_.clear();
    for (const PointShare& point : channel.points) {
      poses_.push_back(mesh::parse_pose(machine, point.pose_text, "channel '" + channel.id + "'"));
      weights_.push_back(point.weight);
    }
    return;
  }
  const std::string& quantity = channel.quantity;
  const int table = machine.body_index(machine.tcp.table_body);
  if (const auto at = std::find(direct.begin(), direct.end(), quantity); at != direct.end()) {
    component_ = static_cast<int>(at - direct.begin());
    if (channel.frame == "table") to_frame_ = mesh::body_transform(machine, table, pose).linear().transpose();
    return;
  }
  const std::size_t letter = quantity.size() == 3 && quantity[1] == '0' ? iso.find(quantity[0]) : std::string::npos;
  const std::string of = letter == std::string::npos ? "" : quantity.substr(2);
  const int axis = of == "T" ? -1 : machine.axis_index(of);
  if (letter == std::string::npos || (of != "T" && (axis < 0 || letter == 6))) {
    throw core::InputError("channel '" + channel.id + "'", "quantity '" + quantity + "'",
                           "dx dy dz ra rb rc, or a location error of the machine: X0C, A0B, Z0T, R0T");
  }
  component_ = static_cast<int>(letter);
  located_ = true;
  int carrier = solver::table_frames(machine).carrier;
  Eigen::Vector3d point = transform_of(machine, carrier, pose) * machine.tcp.table_point;
  table_side_ = true;
  if (axis >= 0) {
    const int body = body_of_axis(machine, of);
    carrier = body < 0 ? -1 : machine.body_index(machine.bodies[body].parent);
    point = transform_of(machine, carrier, pose) * machine.axes[axis].origin;
    table_side_ = carries(machine, body, table);
  }
  to_frame_ = transform_of(machine, carrier, pose).linear().transpose();
  arm_ = solver::tcp_position(machine, pose) - point;
  if (!table_side_) return;
  const auto [origin, direction] = solver::growth_axis(machine);
  const Eigen::Isometry3d at_table = mesh::body_transform(machine, table, pose);
  table_axis_ = at_table.linear() * direction;
  const Eigen::Vector3d from_axis = solver::tcp_position(machine, pose) - at_table * origin;
  radial_ = from_axis - table_axis_ * table_axis_.dot(from_axis);
  place_beside(pose);
  if (component_ == 6 && poses_.size() < 3) {
    throw core::InputError("channel '" + channel.id + "'", "quantity 'R0T'",
                           "a machine with a linear axis across the table's axis");
  }
}

void ObservedQuantity::place_beside(const mesh::Pose& pose) {
  const int table = machine_.body_index(machine_.tcp.table_body);
  // Of the ways over the table that linear axes can go, the longest across the table's axis.
  const auto over_table = [&](const mesh::Pose& at) {
    return Eigen::Vector3d(mesh::body_transform(machine_, table, at).inverse() * solver::tcp_position(machine_, at));
  };
  const Eigen::Matrix3d from_table = mesh::body_transform(machine_, table, pose).linear();
  double longest = 1e-4;
  for (Index i = 0; i < std::ssize(machine_.axes); ++i) {
    const mesh::Axis& axis = machine_.axes[i];
    if (axis.kind != mesh::AxisKind::linear) continue;
    mesh::Pose low = pose, high = pose;
    low[i] = std::max(std::min(axis.low, pose[i]), pose[i] - beside);
    high[i] = std::min(std::max(axis.high, pose[i]), pose[i] + beside);
    const Eigen::Vector3d way = from_table * (over_table(high) - over_table(low));
    const double across = (way - table_axis_ * table_axis_.dot(way)).norm();
    if (across <= longest) continue;
    longest = across;
    way_ = way;
    poses_ = {pose, low, high};
  }
}

double ObservedQuantity::operator()(const std::vector<solver::TcpError>& errors) const {
  if (!weights_.empty()) {
    double sum = 0.0;
    for (std::size_t i = 0; i < weights_.size(); ++i) sum += weights_[i].dot(errors[i].error.head<3>());
    return sum / core::units::um;
  }
  const auto in_unit = [](double value, int component) {
    return value / (component < 3 || component == 6 ? core::units::um : core::units::um_per_m);
  };
  const auto component_of = [&](const Eigen::Vector3d& shift, const Eigen::Vector3d& turn) {
    const Eigen::Vector3d value = to_frame_ * (component_ < 3 ? shift : turn);
    return in_unit(value[component_ % 3], component_);
  };
  const solver::TcpError& at = errors.front();
  if (!located_) return component_of(at.error.head<3>(), at.error.tail<3>());
  const solver::Vector6& side = table_side_ ? at.table : at.tool;
  const Eigen::Vector3d turn = side.tail<3>();
  double growth = 0.0;  // per length
  if (poses_.size() == 3) {
    const Eigen::Vector3d across = way_ - table_axis_ * table_axis_.dot(way_);
    const Eigen::Vector3d stretch = errors[2].table.head<3>() - errors[1].table.head<3>() - turn.cross(way_);
    growth = stretch.dot(across) / across.squaredNorm();
  }
  if (component_ == 6) return in_unit(growth * machine_.tcp.table_radius, component_);
  return component_of(side.head<3>() - growth * radial_ - turn.cross(arm_), turn);
}

}  // namespace thermotwin::compensation
