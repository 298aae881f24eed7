// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/prediction/prediction.h"

#include <algorithm>
#include <cmath>
#include <iterator>

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
  settings.largest_um = options.largest_um;
  settings.rate_um_s = options.rate_um_s;
  auto cold = std::make_unique<compensation::Compensator>(model, settings);
  if (options.rested) cold->rested();
  return cold;
}

Row standing_at(const Positions& start, const std::vector<std::string>& drives) {
  Row standing;
  standing.process_W = Eigen::VectorXd::Zero(std::ssize(drives));
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

const ErrorField::Stretch& ErrorField::at(double time) const {
  auto row = rows_.rbegin();
  while (row->from > time && std::next(row) != rows_.rend()) ++row;
  return *row;
}

solver::TcpError ErrorField::error(const Positions& positions, double time) const {
  const Stretch& row = at(time);
  const double share = row.to > row.from ? std::clamp((time - row.from) / (row.to - row.from), 0.0, 1.0) : 1.0;
  solver::TcpError error = map_.tcp(row.base, row.change, share, positions);
  if (row.shares.isZero(0.0)) return error;
  for (int i = 0; i < 3; ++i) {
    error.tool[i] *= 1.0 + row.shares[i];
    error.table[i] *= 1.0 + row.shares[3 + i];
    error.error[i] = error.tool[i] - error.table[i] + row.shares[6 + i];
  }
  return error;
}

Eigen::VectorXd ErrorField::offsets(const Positions& positions, double time) const {
  return map_.offsets(error(positions, time));
}

Eigen::Vector3d ErrorField::error_std(const Eigen::VectorXd& of_offsets) const {
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < of_offsets.size(); ++i)
    variance += map_.motion(of_offsets[i] * Eigen::VectorXd::Unit(of_offsets.size(), i)).cwiseAbs2();
  return variance.cwiseSqrt();
}

void ErrorField::advance(const Eigen::VectorXd& state, const Eigen::Vector<double, 9>& shares, double time) {
  if (state_.size() == 0) state_ = state;
  Stretch row;
  row.from = rows_.empty() ? time : rows_.back().to;
  row.to = time;
  row.shares = shares;
  map_.project(state_, row.base);
  map_.project(state - state_, row.change);
  rows_.push_back(std::move(row));
  state_ = state;
}

void ErrorField::forget(double time) {
  while (rows_.size() > 1 && rows_.front().to < time) rows_.pop_front();
}

std::vector<double> ErrorField::bends(double from, double to) const {
  std::vector<double> times;
  if (rows_.back().from <= from) return times;
  const double rounding = 1e-9 * (1.0 + to);
  for (const Stretch& row : rows_)
    if (row.to > from + rounding && row.to < to - rounding) times.push_back(row.to);
  return times;
}

double PredictedMove::time_at(double u) const {
  double way = u * length;
  for (const TimeCourse& course : *before) {
    if (way <= course.length) return course.start + course.seconds_at(way / course.length);
    way -= course.length;
  }
  return timed->start + timed->seconds_at(way / timed->length);
}

double PredictedMove::share_at(double seconds) const {
  double way = 0.0;
  for (const TimeCourse& course : *before) {
    way += course.length * course.share_at(seconds - course.start);
    if (seconds < course.end()) return way / length;
  }
  return (way + timed->length * timed->share_at(seconds - timed->start)) / length;
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
  const Row standing = standing_at(start, options.drives);
  const Eigen::VectorXd row = row_channels(model.machine, online_.channels().names(), options_.drives, standing);
  if (present_)
    present_->stand_until_start(row);
  else
    online_.step(0.0, row, {});
  advance_field(0.0);
}

void Predictor::advance_field(double time) {
  field_.advance(online_.state(), present_ ? present_->twin().output_shares() : Eigen::Vector<double, 9>::Zero(), time);
}

void Predictor::add(const Timed& timed) {
  if (timed.element.pause > 0.0) return;
  if (!open_) {
    moving_ = {};
    moving_.start = timed.start;
    moving_.begin = timed.element.at(0.0);
    open_ = true;
  }
  sample(timed);
  moving_.length += timed.length;
  if (!timed.element.last) {
    moving_.before.push_back(timed);
    return;
  }
  moving_.last = timed;
  pending_.push_back(std::move(moving_));
  open_ = false;
}

/// Moments of one grid over the program, on which the ends of rows lie.
void Predictor::sample(const Timed& timed) {
  constexpr double wanted = 2.5;  // s
  const double spacing = options_.interval > wanted ? options_.interval / std::ceil(options_.interval / wanted)
                                                    : options_.interval * std::ceil(1.0 / options_.interval);
  const double rounding = 1e-9 * (1.0 + timed.start), end = timed.end() - rounding;
  for (double k = std::floor((timed.start + rounding) / spacing) + 1.0; k * spacing < end; k += 1.0) {
    const double u = timed.share_at(k * spacing - timed.start);
    samples_.push_back({k * spacing, moving_.length + u * timed.length, timed.element.at(u), {}});
  }
}

void Predictor::predict_samples(double until) {
  for (; predicted_samples_ < samples_.size(); ++predicted_samples_) {
    MoveSample& sample = samples_[predicted_samples_];
    if (sample.time > until) break;
    sample.offset_um = field_.offsets(sample.positions, sample.time) * 1e6;
  }
}

void Predictor::row(const Row& row) {
  const Eigen::VectorXd channels = row_channels(model_.machine, online_.channels().names(), options_.drives, row);
  const Eigen::VectorXd before = drift_ ? online_.state() : Eigen::VectorXd();
  step(row.to, channels);
  if (row.to - row.from < options_.interval * (1.0 - 1e-9)) end_short_step(row, channels);
  advance_field(row.to);
  if (drift_) drift_->row(row.to - row.from, channels, before, online_.state());
  const double until = row.to * (1.0 + 1e-12);
  predict_samples(until);
  auto first_left = pending_.begin();
  for (; first_left != pending_.end(); ++first_left) {
    if (first_left->last.end() > until) break;
    take(*first_left, row);
  }
  pending_.erase(pending_.begin(), first_left);
  field_.forget(!pending_.empty() ? pending_.front().start : open_ ? moving_.start : row.to);
}

/// The begin of a move is the end of the last one, unless the machine stood between them.
void Predictor::begin(const Moving& moving) {
  if (move_.offset_um.size() > 0 && move_.time >= moving.start * (1.0 - 1e-12))
    move_.begin_um = move_.offset_um;
  else
    move_.begin_um = field_.offsets(moving.begin, moving.start) * 1e6;
  move_.begin = moving.begin;
  move_.start = moving.start;
  move_.length = moving.length;
  move_.before = &moving.before;
  move_.timed = &moving.last;
}

/// Mean by the trapezoidal rule over the begin, the moments within a long move, and the end.
void Predictor::set_range() {
  move_.low_um = move_.begin_um.cwiseMin(move_.offset_um);
  move_.high_um = move_.begin_um.cwiseMax(move_.offset_um);
  const double duration = move_.duration();
  for (const MoveSample& sample : move_.inside) {
    move_.low_um = move_.low_um.cwiseMin(sample.offset_um);
    move_.high_um = move_.high_um.cwiseMax(sample.offset_um);
  }
  if (move_.inside.size() < 2) {
    move_.mean_um = 0.5 * (move_.begin_um + move_.offset_um);
    return;
  }
  double time = move_.start;
  const Eigen::VectorXd* last = &move_.begin_um;
  move_.mean_um.setZero(move_.offset_um.size());
  const auto add = [&](double until, const Eigen::VectorXd& offset_um) {
    move_.mean_um += 0.5 * (until - time) / duration * (*last + offset_um);
    time = until;
    last = &offset_um;
  };
  for (const MoveSample& sample : move_.inside) add(sample.time, sample.offset_um);
  add(move_.time, move_.offset_um);
}

void Predictor::take(const Moving& moving, const Row& row) {
  begin(moving);
  const Timed& timed = moving.last;
  move_.end = timed.element.end();
  move_.time = timed.end();
  move_.field = &field_;
  const solver::TcpError error = field_.error(move_.end, move_.time);
  move_.error_um = error.error.head<3>() * 1e6;
  move_.offset_um = field_.offsets(error) * 1e6;
  move_.std_um = online_.std_um(move_.end);
  move_.outside = field_.outside(move_.end);
  move_.inside.clear();
  for (; !samples_.empty() && samples_.front().time < move_.time; --predicted_samples_) {
    samples_.front().u /= moving.length;
    move_.inside.push_back(std::move(samples_.front()));
    samples_.pop_front();
  }
  set_range();
  move_.ahead_um.resize(0);
  if (drift_ && !timed.element.rapid) {
    see_part(move_, std::clamp((move_.time - row.from) / (row.to - row.from), 0.0, 1.0));
    if (ahead_) move_.ahead_um = (ahead_->offsets(move_.end, 1.0) - ahead_->offsets(move_.end, 0.0)) * 1e6;
  }
  take_(move_);
}

void Predictor::see_part(const PredictedMove& move, double share) {
  const int part = move.timed->element.state.part;
  if (part == part_) return;
  part_ = part;
  drift_->begin_period(share);
  if (part + 1 < options_.parts) return;
  const std::optional<Eigen::VectorXd> change = drift_->ahead();
  if (!change) return;
  const Eigen::Vector<double, 9> shares =
      present_ ? present_->twin().output_shares() : Eigen::Vector<double, 9>::Zero();
  ahead_ = std::make_unique<ErrorField>(model_);
  ahead_->advance(online_.state(), shares, 0.0);
  ahead_->advance(online_.state() + *change, shares, 1.0);
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
