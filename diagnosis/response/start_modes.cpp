// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/start_modes.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "solver/operation/operating_model.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double least_start_s = 1800.0;
constexpr Index most_start_modes = 16;
constexpr double start_std_K = 0.2;   ///< of the uniform start, beside its spread
constexpr double warm_start_K = 1.0;  ///< from which on two first readings tell that something ran before
constexpr double shortest_step_s = 60;

/// The time before the record, with the operation of its first row, in steps that get shorter.
Observations time_before(const Observations& of) {
  Observations before;
  before.start_C = of.start_C;
  double earliest = of.points[0];
  for (const Observations::MayHold& may : of.before) earliest = std::min(earliest, may.from);
  std::vector<double> points = {0.0};
  while (points.back() < of.points[0] - earliest)
    points.push_back(points.back() + std::max(shortest_step_s, 0.15 * points.back()));
  before.points.resize(std::ssize(points));
  for (Index i = 0; i < before.points.size(); ++i) before.points[i] = of.points[0] - points[points.size() - 1 - i];
  before.rows = of.rows.row(0).replicate(before.points.size() - 1, 1);
  return before;
}

}  // namespace

MatrixXd conduction_at_start(const reduction::ReducedModel& model, const mesh::Machine& machine,
                             const Observations& observations) {
  const solver::OperatingModel operating(machine, model.system.layout);
  const VectorXd p =
      operating.coefficients(observations.rows.row(0).transpose(), VectorXd::Zero(std::ssize(machine.coolants))).p;
  MatrixXd a = model.system.conduction;
  for (Index j = 0; j < p.size(); ++j)
    if (p[j] != 0.0) a += p[j] * model.system.terms[j];
  return 0.5 * (a + a.transpose());
}

MatrixXd start_modes(const reduction::ReducedModel& model, const mesh::Machine& machine,
                     const Observations& observations) {
  const reduction::ReducedSystem& system = model.system;
  if (observations.start_spread_K < even_start_K) return MatrixXd(system.order(), 0);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(conduction_at_start(model, machine, observations),
                                                                 system.capacity);
  Index count = 0;
  while (count < std::min(most_start_modes, system.order()) && eigen.eigenvalues()[count] * least_start_s < 1.0)
    ++count;
  return std::sqrt(system.one_kelvin.dot(system.capacity * system.one_kelvin)) * eigen.eigenvectors().leftCols(count);
}

bool begins_warm(const Observations& record) {
  return record.start_spread_K >= even_start_K || record.start_second_K >= warm_start_K;
}

double start_std(const Observations& record) { return std::hypot(start_std_K, record.start_spread_K); }

MatrixXd earlier_operation(const Nominal& nominal) {
  const Observations& of = nominal.observations;
  const Index r = nominal.model.system.order();
  if (!begins_warm(of)) return MatrixXd(r, 0);
  const Observations before = time_before(of);
  std::vector<Variant> variants;
  for (const Observations::MayHold& may : of.before) variants.push_back({.machine = nominal.machine, .held = &may});
  const MatrixXd all = MatrixXd::Identity(r, r);
  const std::vector<MatrixXd> states =
      propagate({nominal.model, before, nominal.machine, all, nominal.capacity}, variants);
  MatrixXd fields(r, std::ssize(variants));
  for (Index i = 0; i < fields.cols(); ++i) fields.col(i) = states[i + 1].bottomRows(1).transpose();
  return fields;
}

}  // namespace thermotwin::diagnosis
