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
      options_(options),
      drift_(options.parts > 1 ? std::make_unique<CycleDrift>(model) : nullptr),
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
  const Eigen::VectorXd before = drift_ ? online_.state() : Eigen::VectorXd();
  step(row.to, channels);
  if (row.to - row.from < options_.interval * (1.0 - 1e-9)) end_short_step(row, channels);
  advance_field();
  if (drift_) drift_->row(row.to - row.from, channels, before, online_.state());
  auto first_left = pending_.begin();
  for (; first_left != pending_.end(); ++first_left) {
    if (first_left->start + first_left->duration() > row.to * (1.0 + 1e-12)) break;
    take(*first_left, row);
  }
  pending_.erase(pending_.begin(), first_left);
}

void Predictor::take(const Timed& timed, const Row& row) {
  PredictedMove move;
  move.timed = &timed;
  move.end = timed.element.end();
  move.time = timed.start + timed.duration();
  move.share = std::clamp((move.time - row.from) / (row.to - row.from), 0.0, 1.0);
  move.field = &field_;
  const solver::TcpError error = field_.error(move.end, move.share);
  move.error_um = error.error.head<3>() * 1e6;
  move.offset_um = field_.offsets(error) * 1e6;
  move.std_um = online_.std_um(move.end);
  move.outside = field_.outside(move.end);
  if (drift_ && !timed.element.rapid) {
    see_part(move);
    if (ahead_) move.ahead_um = (ahead_->offsets(move.end, 1.0) - ahead_->offsets(move.end, 0.0)) * 1e6;
  }
  take_(move);
}

void Predictor::see_part(const PredictedMove& move) {
  const int part = move.timed->element.state.part;
  if (part == part_) return;
  part_ = part;
  drift_->begin_period(move.share);
  if (part + 1 < options_.parts) return;
  const std::optional<Eigen::VectorXd> change = drift_->ahead();
  if (!change) return;
  const Eigen::Vector<double, 9> shares =
      present_ ? present_->twin().output_shares() : Eigen::Vector<double, 9>::Zero();
  ahead_ = std::make_unique<ErrorField>(model_);
  ahead_->advance(online_.state(), shares);
  ahead_->advance(online_.state() + *change, shares);
}

void Predictor::step(double time, const Eigen::VectorXd& channels) {
  if (present_)
    present_->step(time, channels);
  else
    online_.step(time, channels, {});
}

void Predictor::end_short_step(const Row& row, const Eigen::VectorXd& channels) {
  // A further row that makes the step too long ends it at this row's end. It is itself no whole step.
  const double duration = row.to - row.from;
  if (duration > 4e-9 * options_.interval) step(row.to + options_.interval - 0.5 * duration, channels);
}

}  // namespace thermotwin::nc
