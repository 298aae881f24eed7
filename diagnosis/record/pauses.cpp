// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/pauses.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace thermotwin::diagnosis {

using compensation::Channel, compensation::Quantity;
using Eigen::Index;

namespace {

constexpr double last_part_s = 300;  ///< and each part before it this many times as long:
constexpr double growth = 3.0;
constexpr double any_share = 0.5773502691896258;  ///< root mean square of a share between 0 and 1, any alike
constexpr std::size_t most_columns = 64;

Index row_at(const Eigen::VectorXd& time, double at) {
  return std::lower_bound(time.begin(), time.end(), at) - time.begin();
}

/// Bounds of the parts of a pause, s before its end, rising from 0 to its length.
std::vector<double> parts_of(double length) {
  std::vector<double> bounds = {0.0};
  for (double part = last_part_s; bounds.back() + part < length; part *= growth) bounds.push_back(bounds.back() + part);
  if (bounds.size() > 1 && length - bounds.back() < 0.5 * (bounds.back() - bounds[bounds.size() - 2]))
    bounds.back() = length;
  else
    bounds.push_back(length);
  return bounds;
}

/// The value of the channel that is farthest from the given one; not a number where there is none.
double farthest(const Eigen::MatrixXd& rows, Index channel, double from) {
  double found = from;
  for (const double each : rows.col(channel))
    if (std::abs(each - from) > std::abs(found - from)) found = each;  // not of NaN
  return found;
}

/// @return what else the channel may have been, unless it is known
std::optional<double> other_value(const Eigen::MatrixXd& rows, const Watched& w, double before) {
  if (std::abs(before) >= 0.5 * w.largest) return 0.0;
  if (std::isfinite(before)) return farthest(rows, w.channel, 0.0);
  return std::nullopt;
}

}  // namespace

void add_unknown_operation(const Eigen::VectorXd& time, const Eigen::MatrixXd& rows, const std::vector<Channel>& inputs,
                           const std::vector<Watched>& watched, Observations& out) {
  std::vector<Observations::OpenChange> pauses = out.pauses;
  std::stable_sort(pauses.begin(), pauses.end(),
                   [](const auto& a, const auto& b) { return a.shown - a.from > b.shown - b.from; });
  std::size_t left = most_columns;
  for (const Observations::OpenChange& pause : pauses) {
    const Index i = row_at(time, pause.from);
    std::vector<std::pair<Index, double>> others;
    for (const Watched& w : watched)
      if (const auto other = other_value(rows, w, rows(i, w.channel))) others.emplace_back(w.channel, *other);
    for (Index c = 0; c < rows.cols(); ++c) {
      if (inputs[c].quantity != Quantity::position) continue;
      if (const double other = farthest(rows, c, rows(i, c)); std::abs(other - rows(i, c)) > 0.0)
        others.emplace_back(c, other);
    }
    const std::vector<double> bounds = parts_of(pause.shown - pause.from);
    const std::size_t columns = others.size() * (bounds.size() - 1);
    if (columns > left) return;
    left -= columns;
    for (const auto& [channel, other] : others) {
      Eigen::VectorXd row = rows.row(i).transpose();
      row[channel] = other;
      for (std::size_t k = 0; k + 1 < bounds.size(); ++k) {
        out.may_hold.push_back({.from = pause.shown - bounds[k + 1],
                                .to = pause.shown - bounds[k],
                                .row = row,
                                .channels = {channel},
                                .std = any_share,
                                .shown = pause.shown,
                                .earlier = true,
                                .in_pause = true});
      }
    }
  }
}

void let_wander(const Eigen::VectorXd& time, const Eigen::MatrixXd& rows, const std::vector<Channel>& inputs,
                Observations& out) {
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
