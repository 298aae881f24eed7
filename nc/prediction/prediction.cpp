// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/prediction/prediction.h"

#include <algorithm>

#include "core/range.h"

namespace thermotwin::nc {

namespace {

compensation::CompensatorOptions settings(const PredictionOptions& options) {
  compensation::CompensatorOptions result;
  result.use_sensors = false;
  result.start_C = options.start_C;
  result.step_s = options.interval;
  return result;
}

}  // namespace

void PredictionOptions::validate() const {
  core::require_within("nc: --start-C", start_C, {-50.0, 100.0});
  core::require_within("nc: --row-s", interval, {0.1, 3600.0});
}

solver::TcpError ErrorField::error(const Positions& positions, double share) const {
  return map_.tcp(base_, change_, share, positions);
}

Eigen::VectorXd ErrorField::offsets(const Positions& positions, double share) const {
  return map_.offsets(error(positions, share));
}

void ErrorField::advance(const Eigen::VectorXd& state) {
  if (state_.size() == 0) state_ = state;
  map_.project(state_, base_);
  map_.project(state - state_, change_);
  state_ = state;
}

Predictor::Predictor(const reduction::ReducedModel& model, const Positions& start, const PredictionOptions& options,
                     std::function<void(const PredictedMove&)> take)
    : model_(model),
      compensator_(model, settings(options)),
      field_(model),
      take_(std::move(take)) {
  Row standing;
  standing.to = 1.0;
  standing.travel = Positions::Zero(start.size());
  standing.low = standing.high = standing.end = start;
  compensator_.step(0.0, row_channels(model.machine, compensator_.channels().names(), standing), {});
  field_.advance(compensator_.state());
}

void Predictor::add(const Timed& timed) {
  if (timed.element.last) pending_.push_back(timed);
}

void Predictor::row(const Row& row) {
  compensator_.step(row.to, row_channels(model_.machine, compensator_.channels().names(), row), {});
  field_.advance(compensator_.state());
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
    move.std_um = compensator_.std_um(move.end);
    move.outside = field_.outside(move.end);
    take_(move);
  }
  pending_.erase(pending_.begin(), first_left);
}

}  // namespace thermotwin::nc
