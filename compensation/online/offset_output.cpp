// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/offset_output.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What the observer does not estimate, as a share of the offset: expansions, stiffness, the mesh.
constexpr double offset_error_share = 0.03;
/// The same once probing has estimated expansions: stiffness, the mesh.
constexpr double probed_error_share = 0.01;

OffsetLimits chosen_limits(const reduction::ReducedModel& model, const OutputMap& map,
                           const CompensatorOptions& options) {
  OffsetLimits chosen = offset_limits(model, map);
  if (options.largest_um > 0.0) chosen.largest_um = options.largest_um;
  if (options.rate_um_s > 0.0) {
    chosen.rate_um_s = options.rate_um_s;
    chosen.slope_um.setZero();
  }
  chosen.largest_um = std::min(chosen.largest_um, largest_offset_um);
  chosen.rate_um_s = std::clamp(chosen.rate_um_s, least_rate_um_s, largest_rate_um_s);
  return chosen;
}

GuardOptions guard_options(const OffsetLimits& limits) {
  GuardOptions options;
  options.largest_um = limits.largest_um;
  options.rate_um_s = limits.rate_um_s;
  return options;
}

}  // namespace

OffsetOutput::OffsetOutput(const reduction::ReducedModel& model, const CompensatorOptions& options)
    : map_(model),
      limits_(chosen_limits(model, map_, options)),
      guard_(std::ssize(map_.axes()), guard_options(limits_)) {
  for (const reduction::ReductionErrors& error : model.errors)
    model_error_ = std::max(model_error_, error.rms_um * core::units::um);
  offsets_.offset_um = offsets_.std_um = offsets_.before_um = VectorXd::Zero(std::ssize(map_.axes()));
  set_change(VectorXd::Zero(model.system.order()));
}

void OffsetOutput::set_covariance(const ErrorModel& errors) {
  if (!errors.learns()) {
    map_.set_covariance(errors.directions(), errors.covariance());
    return;
  }
  const MatrixXd& all = errors.all_covariance();
  const Index quantities = errors.directions().cols(), outputs = errors.first_output(), count = all.rows() - outputs;
  MatrixXd covariance(quantities + count, quantities + count);
  covariance.topLeftCorner(quantities, quantities) = all.topLeftCorner(quantities, quantities);
  covariance.topRightCorner(quantities, count) = all.block(0, outputs, quantities, count);
  covariance.bottomLeftCorner(count, quantities) = all.block(outputs, 0, count, quantities);
  covariance.bottomRightCorner(count, count) = all.bottomRightCorner(count, count);
  map_.set_covariance(errors.directions(), covariance, base_);
}

solver::TcpError OffsetOutput::tcp(const ErrorModel& errors, double ahead, const mesh::Pose& pose) const {
  if (base_.tool.size() == 0) return {solver::Vector6::Zero(), solver::Vector6::Zero(), solver::Vector6::Zero()};
  solver::TcpError error = map_.tcp(base_, slope_, ahead, pose);
  if (!errors.learns()) return error;
  const ErrorModel::OutputShares shares = errors.output_shares();
  for (int i = 0; i < 3; ++i) {
    error.tool[i] *= 1.0 + shares.tool[i];
    error.table[i] *= 1.0 + shares.table[i];
    error.error[i] = error.tool[i] - error.table[i] + shares.rest[i];
  }
  return error;
}

/// @param offset  (axes) m
VectorXd OffsetOutput::deviation_um(const ErrorModel& errors, const VectorXd& offset, const mesh::Pose& pose) const {
  const double share = errors.learns() ? probed_error_share : offset_error_share;
  const VectorXd variance = map_.variance(pose);
  return (variance.array() + (share * offset.array()).square() + model_error_ * model_error_).sqrt() / core::units::um;
}

const Offsets& OffsetOutput::write(double time, const mesh::Pose& pose, const ErrorModel& errors, double ahead,
                                   const RowCondition& condition) {
  const VectorXd offset = map_.offsets(tcp(errors, ahead, pose));
  const VectorXd own_um = deviation_um(errors, offset, pose);
  const VectorXd wanted_um = offset / core::units::um;
  const double motion_um = started_ ? limits_.motion_um(last_pose_, pose, time - offsets_.time) : 0.0;
  offsets_.before_um = offsets_.offset_um;
  offsets_.offset_um = guard_.step(time, wanted_um, motion_um);
  started_ = true;
  last_pose_ = pose;
  offsets_.time = time;
  bool held_back = false, has_failed = false;
  for (Index a = 0; a < offset.size(); ++a) {
    const double back_um = wanted_um[a] - offsets_.offset_um[a];
    has_failed = has_failed || !std::isfinite(own_um[a]) || !std::isfinite(back_um);
    held_back = held_back || std::abs(back_um) > own_um[a];
    offsets_.std_um[a] = std::hypot(own_um[a], back_um);
  }
  if (has_failed) offsets_.std_um.setConstant(limits_.largest_um);
  offsets_.failed_sensors = condition.failed_sensors;
  offsets_.failed_inputs = condition.failed_inputs;
  offsets_.status = has_failed                         ? Status::failed
                    : condition.input_missing          ? Status::input_missing
                    : map_.outside(pose)               ? Status::outside_workspace
                    : condition.no_sensors             ? Status::no_sensors
                    : !offsets_.failed_sensors.empty() ? Status::sensor_failed
                    : held_back                        ? Status::limited
                                                       : Status::ok;
  return offsets_;
}

}  // namespace thermotwin::compensation
