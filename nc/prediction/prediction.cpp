// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/prediction/prediction.h"

#include <algorithm>

#include "compensation/online/compensator.h"
#include "core/range.h"

namespace thermotwin::nc {

namespace {

std::unique_ptr<compensation::OnlineModel> cold_model(const reduction::ReducedModel& model,
                                                      const PredictionOptions& options) {
  compensation::CompensatorOptions settings;
  settings.use_sensors = false;
  settings.start_C = options.start_C;
  settings.step_s = options.interval;
  return std::make_unique<compensation::Compensator>(model, settings);
}

Row standing_at(const Positions& start) {
  Row standing;
  standing.to = 1.0;
  standing.travel = Positions::Zero(start.size());
  standing.low = standing.high = standing.end = start;
  return standing;
}

}  // namespace

void PredictionOptions::validate() const {
  core::require_within("nc: --start-C", start_C, {-50.0, 100.0});
  core::require_within("nc: --row-s", interval, {0.1, 3600.0});
}

solver::TcpError ErrorField::error(const Positions& positions, double share) const {
  solver::TcpError error = map_.tcp(base_, change_, share, positions);
  if (shares_.isZero(0.0)) return error;
  for (int i = 0; i < 3; ++i) {
    error.tool[i] *= 1.0 + shares_[i];
    error.table[i] *= 1.0 + shares_[3 + i];
    error.error[i] = error.tool[i] - error.table[i] + shares_[6 + i];
  }
  return error;
}

Eigen::VectorXd ErrorField::offsets(const Positions& positions, double share) const {
  return map_.offsets(error(positions, share));
}

Eigen::Vector3d ErrorField::error_std(const Eigen::VectorXd& of_offsets) const {
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < of_offsets.size(); ++i)
    variance += map_.motion(of_offsets[i] * Eigen::VectorXd::Unit(of_offsets.size(), i)).cwiseAbs2();
  return variance.cwiseSqrt();
}

void ErrorField::advance(const Eigen::VectorXd& state, const Eigen::Vector<double, 9>& shares) {
  if (state_.size() == 0) state_ = state;
  map_.project(state_, base_);
  map_.project(state - state_, change_);
  state_ = state;
  shares_ = shares;
}

Predictor::Predictor(const reduction::ReducedModel& model, std::unique_ptr<PresentMachine> present,
                     const Positions& start, const PredictionOptions& options,
                     std::function<void(const PredictedMove&)> take)
    : model_(model),
      present_(std::move(present)),
      cold_(present_ ? nullptr : cold_model(model, options)),
      online_(present_ ? present_->online() : *cold_),
      zero_(present_ ? present_->start_s() : 0.0),
      field_(model),
      take_(std::move(take)) {
  const Row standing = standing_at(start);
  const Eigen::VectorXd row = row_channels(model.machine, online_.channels().names(), standing);
  if (present_)
    present_->stand_until_start(row);
  else
    online_.step(0.0, row, {});
  advance_field();
}

void Predictor::advance_field() {
  field_.advance(online_.state(), present_ ? present_->twin().output_shares() : Eigen::Vector<double, 9>::Zero());
}

void Predictor::add(const Timed& timed) {
  if (timed.element.last) pending_.push_back(timed);
}

void Predictor::row(const Row& row) {
  const Eigen::VectorXd channels = row_channels(model_.machine, online_.channels().names(), row);
  if (present_)
    present_->step(row.to, channels);
  else
    online_.step(row.to, channels, {});
  advance_field();
  auto first_left = pending_.begin();
  for (; first_left != pending_.end(); ++first_left) {
    const Timed& timed = *first_left;
    const double end = timed.start + timed.duration();
    if (end > row.to * (1.0 + 1e-12)) break;
    PredictedMove move;
    move.timed = &timed;
    move.end = timed.element.end();
    move.time = end;
    move.share = std::clamp((end - row.from) / (row.to - row.from), 0.0, 1.0);
    move.field = &field_;
    const solver::TcpError error = field_.error(move.end, move.share);
    move.error_um = error.error.head<3>() * 1e6;
    move.offset_um = field_.offsets(error) * 1e6;
    move.std_um = online_.std_um(move.end);
    move.outside = field_.outside(move.end);
    take_(move);
  }
  pending_.erase(pending_.begin(), first_left);
}

}  // namespace thermotwin::nc
