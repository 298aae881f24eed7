// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/probe/probes.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/dense_algebra.h"
#include "core/error.h"
#include "core/minimum_norm.h"
#include "core/units.h"

namespace thermotwin::metrology {

namespace units = core::units;
using core::InputError;
using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr int most_rounds = 50;

/// What the contact of two spheres adds to a reading.
double contact(const Vector3d& direction, double radius, const Vector3d& displacement) {
  if (radius <= 0.0) return 0.0;
  const double across = (displacement - direction * direction.dot(displacement)).squaredNorm();
  return across < radius * radius ? radius - std::sqrt(radius * radius - across) : radius;
}

double flatness(const MatrixXd& vectors) {
  const VectorXd singular = Eigen::JacobiSVD<MatrixXd>(vectors).singularValues();
  return singular.size() < 3 || singular[0] <= 0.0 ? 0.0 : singular[2] / singular[0];
}

MatrixXd centred(const MatrixXd& rows) { return rows.rowwise() - rows.colwise().mean(); }

}  // namespace

Matrix3Xd tripod() {
  Matrix3Xd directions(3, 3);
  for (int i = 0; i < 3; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 3.0, across = std::sqrt(2.0 / 3.0);
    directions.col(i) = Vector3d(across * std::cos(angle), across * std::sin(angle), std::sqrt(1.0 / 3.0));
  }
  return directions;
}

VectorXd probe_readings(const Matrix3Xd& directions, double contact_radius, const Vector3d& displacement) {
  VectorXd readings = directions.transpose() * displacement;
  for (Index i = 0; i < readings.size(); ++i) readings[i] += contact(directions.col(i), contact_radius, displacement);
  return readings;
}

void require_spatial(const Matrix3Xd& directions, const std::string& place) {
  const double value = directions.cols() < 3 ? 0.0 : flatness(directions);
  if (value > flattest) return;
  throw InputError(
      place, fmt::format("{} probes whose smallest singular value is {:.2g} of the largest", directions.cols(), value),
      fmt::format("three or more probes in different directions, at least {}", flattest));
}

Calibration Calibration::fit(const core::Table& table, double contact_radius) {
  MatrixXd moved(table.rows(), 3);
  for (int i = 0; i < 3; ++i) {
    const std::string name = std::string(1, "xyz"[i]) + "_mm";
    table.require_complete(name);
    moved.col(i) = table.column(name) * units::mm;
  }
  Calibration result;
  result.contact_radius_ = contact_radius;
  for (const std::string& name : table.columns)
    if (name.ends_with("_um")) result.names_.push_back(name);
  const Index probes = std::ssize(result.names_);
  if (table.rows() < 4 || probes < 3) {
    throw InputError(table.source, fmt::format("{} displacements of {} probes", table.rows(), probes),
                     "at least four displacements, and three columns <probe>_um");
  }
  MatrixXd readings(table.rows(), probes);
  for (Index i = 0; i < probes; ++i) {
    table.require_complete(result.names_[i]);
    readings.col(i) = table.column(result.names_[i]) * units::um;
  }
  if (const double value = flatness(centred(moved)); !(value > flattest)) {
    throw InputError(table.source,
                     fmt::format("displacements whose smallest singular value is {:.2g} of the largest", value),
                     "displacements along x, y and z");
  }
  result.way_ = moved.cwiseAbs().maxCoeff();
  result.zero_ = VectorXd::Zero(probes);
  bool has_zero = false;
  for (Index i = 0; i < table.rows() && !has_zero; ++i) {
    has_zero = moved.row(i).norm() < 1e-9;
    if (has_zero) result.zero_ = readings.row(i).transpose();
  }
  if (contact_radius > 0.0 && !has_zero)
    throw InputError(table.source, "no row at 0, 0, 0", "such a row: the contact of spheres is counted from there");
  // The contact's share depends on the directions, which follow from the readings without it.
  MatrixXd linear = readings;
  for (int round = 0; round < most_rounds; ++round) {
    result.directions_ = core::minimum_norm_solution(centred(moved), centred(linear));
    require_spatial(result.directions_, table.source);
    if (contact_radius <= 0.0) break;
    MatrixXd next = readings;
    for (Index i = 0; i < next.rows(); ++i) {
      for (Index k = 0; k < probes; ++k)
        next(i, k) -= contact(result.directions_.col(k).normalized(), contact_radius, moved.row(i).transpose());
    }
    const double change = (next - linear).cwiseAbs().maxCoeff();
    linear = next;
    if (change < 1e-13) break;
  }
  if (!has_zero) result.zero_ = (linear.colwise().mean() - moved.colwise().mean() * result.directions_).transpose();
  result.transform_ = core::minimum_norm_solution(centred(linear), centred(moved));
  result.residual_rms_ = std::sqrt((centred(linear) * result.transform_ - centred(moved)).squaredNorm() / moved.size());
  return result;
}

Vector3d Calibration::displacement(const VectorXd& readings) const {
  const VectorXd against_zero = readings - zero_;
  Vector3d moved = transform_.transpose() * against_zero;
  if (contact_radius_ <= 0.0) return moved;
  for (int round = 0; round < most_rounds; ++round) {
    VectorXd linear = against_zero;
    for (Index k = 0; k < linear.size(); ++k)
      linear[k] -= contact(directions_.col(k).normalized(), contact_radius_, moved);
    const Vector3d next = transform_.transpose() * linear;
    const double change = (next - moved).norm();
    moved = next;
    if (change < 1e-13) break;
  }
  return moved;
}

}  // namespace thermotwin::metrology
