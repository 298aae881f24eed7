// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The path of the tool's tip with the error along it, thinned for a picture. A point is left out where it lies within a
// tolerance of the straight line between its kept neighbours, in place and in error (Ramer, Douglas and Peucker). Where
// more points are left than asked for, both tolerances double; memory is independent of the program's length.

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace thermotwin::nc {

struct PathPoint {
  Eigen::Vector3d place;             ///< m, in the workpiece, seen with all axes at home
  Eigen::Vector3d error_um, std_um;  ///< of the TCP, tool against table, X Y Z of the machine
  double time = 0;                   ///< s
  std::uint32_t line = 0;            ///< of the program
  bool rapid = false;                ///< the stretch that ends here
};

class PathPoints {
public:
  struct Options {
    std::size_t most = 40000;  ///< points, at least 16
    double place_m = 1e-5;     ///< first tolerances
    double error_um = 0.05;
  };
  PathPoints() : PathPoints(Options()) {}
  explicit PathPoints(const Options& options);

  void add(const PathPoint& point);
  void finish();

  const std::vector<PathPoint>& points() const { return points_; }
  double place_tolerance() const { return place_sum_; }  ///< m, how far the path may be from this one
  double error_tolerance_um() const { return error_sum_; }
  long given() const { return given_; }

private:
  void close_chunk();
  /// Thins points_ from an index on. @param keeps_kinds  rapid and feed stretches stay apart
  void thin(std::size_t from, bool keeps_kinds);

  Options options_;
  double place_m_, error_um_, place_sum_, error_sum_;
  std::vector<PathPoint> points_;
  std::size_t chunk_ = 0;  ///< index of the first point that is not thinned yet
  long given_ = 0;
};

}  // namespace thermotwin::nc
