// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/observer_noise.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <cmath>
#include <iterator>

#include "core/error.h"
#include "core/range.h"
#include "mesh/machine_mesh.h"
#include "reduction/linear/matrix_exponential.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int most_doublings = 60;
constexpr double settled = 1e-10;

MatrixXd symmetric(const MatrixXd& m) { return 0.5 * (m + m.transpose()); }

/// The nearest matrix without negative eigenvalues.
MatrixXd non_negative(const MatrixXd& m) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(symmetric(m));
  return modes.eigenvectors() * modes.eigenvalues().cwiseMax(0.0).asDiagonal() * modes.eigenvectors().transpose();
}

}  // namespace

void ObserverOptions::validate() const {
  core::require_option(interval_s > 0.0 && std::isfinite(interval_s), "observer interval_s", interval_s,
                       "a time above 0");
  core::require_option(unstated_share >= 0.0, "observer unstated_share", unstated_share, "0 or more");
}

double prior_share(const mesh::Machine& machine, const ObserverOptions& options) {
  options.validate();
  double squares = 0.0, count = 0.0;
  const auto add = [&](const core::Uncertain& value) {
    squares += value.std_percent * value.std_percent / 1e4;
    count += 1.0;
  };
  for (const mesh::SourceSpec& source : machine.sources) add(source.scale);
  for (const mesh::FilmSpec& film : machine.films) add(film.coefficient);
  return squares > 0.0 ? std::sqrt(squares / count) : options.unstated_share;
}

MatrixXd stationary_prediction(const MatrixXd& f, const MatrixXd& q, const MatrixXd& h, const VectorXd& r) {
  const Index n = f.rows();
  MatrixXd a = f.transpose(), g = h.transpose() * r.cwiseInverse().asDiagonal() * h, s = q;
  for (int i = 0; i < most_doublings; ++i) {
    // With W = (1 + G S)^-1: A <- A W A, G <- G + A W G A^T, S <- S + A^T S W A.
    const Eigen::PartialPivLU<MatrixXd> w(MatrixXd::Identity(n, n) + g * s);
    const MatrixXd wa = w.solve(a), wg = w.solve(g), change = symmetric(a.transpose() * (s * wa));
    g = symmetric(g + a * (wg * a.transpose()));
    a = (a * wa).eval();
    s += change;
    if (!s.allFinite()) break;
    if (change.norm() <= settled * s.norm()) return s;
  }
  throw core::SolverError("observer: the stationary covariance does not settle");
}

ObserverNoise observer_noise(const ReducedModel& model, const MatrixXd& states, const VectorXd& standing,
                             const ObserverOptions& options) {
  const ReducedSystem& system = model.system;
  const Index r = system.order();
  const auto sensors = std::ssize(model.machine.sensors);
  if (states.rows() != r || states.cols() == 0)
    throw core::InputError("observer", "no states of the campaign", "snapshots of the training loads");
  const double share = prior_share(model.machine, options);
  const MatrixXd prior = share * share / states.cols() * (states * states.transpose());
  MatrixXd k = system.conduction;
  for (Index j = 0; j < standing.size(); ++j)
    if (standing(j) != 0.0) k += standing(j) * system.terms[j];
  const MatrixXd f = matrix_exponential(-options.interval_s * system.capacity.partialPivLu().solve(k));
  const MatrixXd q = non_negative(prior - f * prior * f.transpose());
  VectorXd variance(sensors);
  for (Index s = 0; s < sensors; ++s) variance(s) = std::pow(model.machine.sensors[s].uncertainty, 2);
  const MatrixXd rows = value_rows(model, mesh::workspace_poses(model.machine));
  const Index poses = std::ssize(mesh::workspace_poses(model.machine)), values = rows.rows() / poses;
  const auto seen = [&](const MatrixXd& covariance) {
    double sum = 0.0;
    for (Index i = 0; i < poses; ++i) {
      const MatrixXd of_pose = rows.middleRows(i * values, 3);
      sum += (of_pose * covariance * of_pose.transpose()).trace();
    }
    return std::sqrt(std::max(0.0, sum / poses));
  };
  ObserverNoise noise;
  noise.open_um = seen(stationary_prediction(f, q, MatrixXd::Zero(1, r), VectorXd::Ones(1)));
  noise.predicted_um =
      sensors == 0 ? noise.open_um : seen(stationary_prediction(f, q, system.sensors.topRows(sensors), variance));
  return noise;
}

}  // namespace thermotwin::reduction
