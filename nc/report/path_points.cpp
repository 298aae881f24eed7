// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/path_points.h"

#include <algorithm>
#include <utility>

namespace thermotwin::nc {

namespace {

constexpr std::size_t chunk_size = 2048;  ///< bounds the time of a chunk that hardly thins

/// How far a point is from a straight stretch, in tolerances.
double apart(const PathPoint& a, const PathPoint& b, const PathPoint& point, double place_m, double error_um) {
  const Eigen::Vector3d chord = b.place - a.place;
  const double squared = chord.squaredNorm(),
               share = squared > 0.0 ? std::clamp(chord.dot(point.place - a.place) / squared, 0.0, 1.0) : 0.0;
  const double off = (a.place + share * chord - point.place).norm() / place_m,
               wrong = (a.error_um + share * (b.error_um - a.error_um) - point.error_um).norm() / error_um;
  return std::max(off, wrong);
}

}  // namespace

PathPoints::PathPoints(const Options& options)
    : options_(options),
      place_m_(options.place_m),
      error_um_(options.error_um),
      place_sum_(options.place_m),
      error_sum_(options.error_um) {}

void PathPoints::add(const PathPoint& point) {
  ++given_;
  points_.push_back(point);
  if (points_.size() - chunk_ >= chunk_size) close_chunk();
}

void PathPoints::close_chunk() {
  thin(chunk_, true);
  while (points_.size() > options_.most) {
    place_m_ *= 2.0;
    error_um_ *= 2.0;
    place_sum_ += place_m_;
    error_sum_ += error_um_;
    thin(0, false);
  }
  chunk_ = points_.empty() ? 0 : points_.size() - 1;
}

void PathPoints::finish() { close_chunk(); }

void PathPoints::thin(std::size_t from, bool keeps_kinds) {
  const std::size_t count = points_.size();
  if (count - from < 3) return;
  std::vector<char> kept(count, 0);
  std::vector<std::pair<std::size_t, std::size_t>> stack;
  std::size_t begin = from;
  kept[from] = kept[count - 1] = 1;
  for (std::size_t i = from + 1; i < count; ++i) {
    const bool ends =
        i + 1 == count || i - begin >= chunk_size || (keeps_kinds && points_[i].rapid != points_[i + 1].rapid);
    if (!ends) continue;
    kept[i] = 1;
    stack.emplace_back(begin, i);
    begin = i;
  }
  while (!stack.empty()) {
    const auto [a, b] = stack.back();
    stack.pop_back();
    double most = 1.0;
    std::size_t at = 0;
    for (std::size_t i = a + 1; i < b; ++i) {
      const double off = apart(points_[a], points_[b], points_[i], place_m_, error_um_);
      if (off > most) most = off, at = i;
    }
    if (at == 0) continue;
    kept[at] = 1;
    stack.emplace_back(a, at);
    stack.emplace_back(at, b);
  }
  // A stretch that joins both kinds is no rapid one.
  std::size_t out = from;
  bool rapid = true;
  for (std::size_t i = from; i < count; ++i) {
    rapid = rapid && points_[i].rapid;
    if (kept[i] == 0) continue;
    if (i > from) points_[i].rapid = rapid;
    points_[out++] = points_[i];
    rapid = true;
  }
  points_.resize(out);
}

}  // namespace thermotwin::nc
