// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/fit/circle_fit.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/dense_algebra.h"
#include "core/error.h"

namespace thermotwin::metrology {

using core::InputError;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixX2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double flattest = 1e-10;  ///< smallest singular value of the points' equations over the largest

/// Of points about their mean, in units of their spread.
struct Algebraic {
  Vector2d centre;
  double radius;
};

Algebraic kasa(const MatrixX2d& p) {
  MatrixXd rows(p.rows(), 3);
  rows << p, VectorXd::Ones(p.rows());
  const Vector3d s = Eigen::HouseholderQR<MatrixXd>(rows).solve(-p.rowwise().squaredNorm());
  const Vector2d centre = -0.5 * s.head<2>();
  return {centre, std::sqrt(std::max(0.0, centre.squaredNorm() - s[2]))};
}

/// The smallest singular vector of [(z - mean z) / (2 sqrt(mean z)), x, y] with z = x^2 + y^2.
Algebraic taubin(const MatrixX2d& p) {
  const VectorXd z = p.rowwise().squaredNorm();
  const double mean = z.mean(), scale = 2.0 * std::sqrt(mean);
  MatrixXd rows(p.rows(), 3);
  rows << (z.array() - mean).matrix() / scale, p;
  const Vector3d v = Eigen::SelfAdjointEigenSolver<MatrixXd>(MatrixXd(rows.transpose() * rows)).eigenvectors().col(0);
  const double a = v[0] / scale, last = -mean * a;
  if (a == 0.0) return kasa(p);
  return {-0.5 / a * v.tail<2>(),
          std::sqrt(std::max(0.0, v.tail<2>().squaredNorm() - 4.0 * a * last)) / std::abs(2.0 * a)};
}

/// Sums over the points of the squared distances from the circle, and of their derivatives by centre and radius.
struct Sums {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d gradient = Vector3d::Zero();
  double squares = 0;
};
Sums sums_of(const MatrixX2d& p, const Vector3d& circle) {
  Sums sums;
  for (Index i = 0; i < p.rows(); ++i) {
    const double x = p(i, 0) - circle[0], y = p(i, 1) - circle[1], length = std::sqrt(x * x + y * y);
    const double distance = length - circle[2], to_unit = length > 0.0 ? 1.0 / length : 0.0;
    const Vector3d slope(-x * to_unit, -y * to_unit, -1.0);
    sums.normal.noalias() += slope * slope.transpose();
    sums.gradient += distance * slope;
    sums.squares += distance * distance;
  }
  return sums;
}

/// @return whether the steps became small
bool improve(const MatrixX2d& p, Vector3d& circle) {
  constexpr int most = 200;
  Sums at = sums_of(p, circle);
  double damping = 1e-4;
  for (int i = 0; i < most; ++i) {
    Matrix3d damped = at.normal;
    damped.diagonal() += damping * at.normal.diagonal();
    const Vector3d step = damped.ldlt().solve(-at.gradient);
    if (step.norm() <= 1e-12 * (1.0 + circle.norm())) return true;
    const Vector3d trial = circle + step;
    const Sums there = sums_of(p, trial);
    if (there.squares <= at.squares) {
      circle = trial;
      at = there;
      damping *= 0.1;
    } else {
      damping = std::max(1e-12, damping) * 10.0;
      if (damping > 1e12) return true;  // no step lowers the sum: a minimum to rounding
    }
  }
  return false;
}

void check(const MatrixX2d& points, const std::string& place) {
  if (points.rows() < 3) throw InputError(place, fmt::format("{} points", points.rows()), "at least 3 points");
  for (Index i = 0; i < points.rows(); ++i) {
    if (!points.row(i).allFinite()) {
      throw InputError(fmt::format("{} point {}", place, i + 1), fmt::format("({}, {})", points(i, 0), points(i, 1)),
                       "finite numbers");
    }
  }
}

}  // namespace

Circle fit_circle(const MatrixX2d& points, CircleMethod method, const std::string& place) {
  check(points, place);
  const Vector2d mean = points.colwise().mean();
  MatrixX2d p = points.rowwise() - mean.transpose();
  const double spread = std::sqrt(p.rowwise().squaredNorm().mean());
  if (!(spread > 0.0)) throw InputError(place, "points on one place", "points on an arc");
  p /= spread;
  const VectorXd singular =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(MatrixXd(p.transpose() * p), Eigen::EigenvaluesOnly).eigenvalues();
  if (!(singular[0] > flattest * flattest * singular[1]))
    throw InputError(place, "points on a line", "points on an arc");

  const Algebraic start = method == CircleMethod::kasa ? kasa(p) : taubin(p);
  Vector3d circle(start.centre[0], start.centre[1], start.radius);
  if (!circle.allFinite()) throw InputError(place, "points on a line", "points on an arc");
  Circle result;
  if (method == CircleMethod::geometric) result.converged = improve(p, circle);
  const Sums sums = sums_of(p, circle);
  result.centre = mean + spread * circle.head<2>();
  result.radius = spread * circle[2];
  result.rms = spread * std::sqrt(sums.squares / p.rows());
  result.cofactor = sums.normal.inverse();
  return result;
}

}  // namespace thermotwin::metrology
