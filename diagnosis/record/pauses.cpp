// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/pauses.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/units.h"
#include "solver/operation/channels.h"

namespace thermotwin::diagnosis {

using compensation::Channel, compensation::Quantity;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double last_part_s = 300;            ///< and each part before it some times as long:
constexpr double growths[] = {3.0, 9.0, 1e9};  ///< the first of which that has no more columns than
constexpr std::size_t most_columns = 128;
constexpr double earlier_s = 36.0 * core::units::hour;  ///< that act on the start of a record
constexpr double any_share = 0.5773502691896258;        ///< root mean square of a share between 0 and 1, any alike
constexpr double half = 0.5;                            ///< of the largest value, from which on something runs
constexpr double least_move = 1.0;                      ///< mm or deg, that makes another position

Index row_at(const VectorXd& time, double at) { return std::lower_bound(time.begin(), time.end(), at) - time.begin(); }

/// Bounds of the parts of a pause, s before its end, rising from 0 to its length.
std::vector<double> parts_of(double length, double growth) {
  std::vector<double> bounds = {0.0};
  for (double part = last_part_s; bounds.back() + part < length; part *= growth) bounds.push_back(bounds.back() + part);
  if (bounds.size() > 1 && length - bounds.back() < 0.5 * (bounds.back() - bounds[bounds.size() - 2]))
    bounds.back() = length;
  else
    bounds.push_back(length);
  return bounds;
}

/// Index of the value in the column that is farthest from the given one.
Index farthest(const MatrixXd& rows, Index channel, double from) {
  Index found = 0;
  double distance = -1.0;
  for (Index i = 0; i < rows.rows(); ++i)
    if (const double d = std::abs(rows(i, channel) - from); d > distance) found = i, distance = d;  // not of NaN
  return found;
}

/// Inputs that belong together, and what else they may have been.
struct Alternative {
  std::vector<Index> channels;
  VectorXd row;
};

/// What the record has seen, and thus what may have run in its pauses.
class SeenOperation {
public:
  SeenOperation(const MatrixXd& rows, const std::vector<Channel>& inputs, const std::vector<Watched>& watched)
      : rows_(rows),
        inputs_(inputs),
        watched_(watched) {}

  /// @param held  inputs of the model in a part of the pause
  std::vector<Alternative> others(const VectorXd& held) const {
    std::vector<Alternative> found;
    for (const Watched& w : watched_) {
      const Quantity quantity = inputs_[w.channel].quantity;
      if (!std::isfinite(held[w.channel]) || quantity == Quantity::gradient) continue;  // which wanders
      const bool runs = std::abs(held[w.channel]) >= half * w.largest;
      if (quantity == Quantity::feed) {
        found.push_back(runs ? standing(held, w.channel) : moving(held, w.channel));
        continue;
      }
      found.push_back({{w.channel}, held});
      found.back().row[w.channel] = runs ? 0.0 : rows_(farthest(rows_, w.channel, 0.0), w.channel);
    }
    for (Index c = 0; c < held.size(); ++c) {
      if (inputs_[c].quantity != Quantity::position) continue;
      const double other = rows_(farthest(rows_, c, held[c]), c);
      if (!(std::abs(other - held[c]) >= least_move)) continue;
      found.push_back(standing(held, c));
      found.back().row[c] = other;
    }
    return found;
  }

private:
  /// Feed, position and range of the channel's axis.
  std::vector<Index> of_axis(Index channel) const {
    std::vector<Index> all;
    for (Index c = 0; c < std::ssize(inputs_); ++c)
      if (inputs_[c].axis == inputs_[channel].axis) all.push_back(c);
    return all;
  }
  Alternative standing(const VectorXd& held, Index channel) const {
    Alternative other{of_axis(channel), held};
    for (const Index c : other.channels) {
      if (inputs_[c].quantity == Quantity::feed) other.row[c] = 0.0;
      if (inputs_[c].quantity == Quantity::range) other.row[c] = solver::not_given;
    }
    return other;
  }
  /// As where it was fastest.
  Alternative moving(const VectorXd& held, Index feed) const {
    Alternative other{of_axis(feed), held};
    other.row(other.channels) = rows_.row(farthest(rows_, feed, 0.0)).transpose()(other.channels);
    return other;
  }

  const MatrixXd& rows_;
  const std::vector<Channel>& inputs_;
  const std::vector<Watched>& watched_;
};

/// Inputs of the model at a time.
VectorXd inputs_at(const Observations& of, double when) {
  const Index step = std::upper_bound(of.points.begin(), of.points.end(), when) - of.points.begin() - 1;
  return of.rows.row(std::clamp<Index>(step, 0, of.rows.rows() - 1)).transpose();
}

std::vector<Observations::MayHold> in_parts(const Observations::OpenChange& pause, double growth,
                                            const SeenOperation& seen, const Observations& of) {
  std::vector<Observations::MayHold> all;
  const std::vector<double> bounds = parts_of(pause.shown - pause.from, growth);
  for (std::size_t k = 0; k + 1 < bounds.size(); ++k) {
    const double from = pause.shown - bounds[k + 1], to = pause.shown - bounds[k];
    for (Alternative& other : seen.others(inputs_at(of, 0.5 * (from + to)))) {
      all.push_back({.from = from,
                     .to = to,
                     .row = std::move(other.row),
                     .channels = std::move(other.channels),
                     .std = any_share,
                     .shown = pause.shown,
                     .earlier = true,
                     .in_pause = true});
    }
  }
  return all;
}

}  // namespace

void add_unknown_operation(const MatrixXd& rows, const std::vector<Channel>& inputs,
                           const std::vector<Watched>& watched, bool in_pauses, Observations& out) {
  std::vector<Observations::OpenChange> pauses = out.pauses;
  std::stable_sort(pauses.begin(), pauses.end(),
                   [](const auto& a, const auto& b) { return a.shown - a.from > b.shown - b.from; });
  const SeenOperation seen(rows, inputs, watched);
  out.before = in_parts({out.points[0] - earlier_s, out.points[0]}, growths[0], seen, out);
  if (!in_pauses) return;
  std::vector<std::vector<Observations::MayHold>> each;
  for (const double growth : growths) {
    each.clear();
    std::size_t columns = 0;
    for (const Observations::OpenChange& pause : pauses) {
      each.push_back(in_parts(pause, growth, seen, out));
      columns += each.back().size();
    }
    if (columns <= most_columns) break;
  }
  std::size_t left = most_columns;
  for (std::vector<Observations::MayHold>& whiles : each) {
    if (whiles.size() > left) continue;
    left -= whiles.size();
    std::move(whiles.begin(), whiles.end(), std::back_inserter(out.may_hold));
  }
}

void let_wander(const VectorXd& time, const MatrixXd& rows, const std::vector<Channel>& inputs, Observations& out) {
  for (const Observations::OpenChange& pause : out.pauses) {
    const Index i = row_at(time, pause.from);
    for (Index s = 0; s < out.rows.rows(); ++s) {
      const double share = (0.5 * (out.points[s] + out.points[s + 1]) - time[i]) / (time[i + 1] - time[i]);
      if (out.points[s] < time[i] - 1e-6 || share >= 1.0) continue;
      for (Index c = 0; c < rows.cols(); ++c) {
        const bool wanders = inputs[c].quantity == Quantity::temperature || inputs[c].quantity == Quantity::gradient;
        const double value = rows(i, c) + share * (rows(i + 1, c) - rows(i, c));
        if (wanders && std::isfinite(value)) out.rows(s, c) = value;
      }
    }
  }
}

}  // namespace thermotwin::diagnosis
