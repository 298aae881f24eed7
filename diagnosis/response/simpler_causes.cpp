// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/simpler_causes.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/machine_value.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/statistics/covariance.h"

namespace thermotwin::diagnosis {

using Eigen::Index;

namespace {

/// ln of the Bayes factor at which two causes are told apart: that of what counts as identifiable.
constexpr double told_apart = 5.0;

struct Simpler {
  Kind kind;
  std::string where;
};
/// Simpler causes whose effect a parameter may have in a record: a material's in one of its bodies, an emissivity's as
/// its film, a pressure's as its contact.
std::vector<Simpler> simpler_causes(const mesh::Machine& machine, const Parameter& parameter) {
  if (parameter.kind == Kind::film_emissivity) return {{Kind::film_coefficient, parameter.where}};
  if (parameter.kind == Kind::contact_pressure) return {{Kind::contact_conductance, parameter.where}};
  std::vector<Simpler> bodies;
  if (row_of(parameter.kind).target != Target::body || machine.body_index(parameter.where) >= 0) return bodies;
  for (const mesh::BodySpec* body : bodies_of_material(machine, parameter.where))
    bodies.push_back({parameter.kind, body->id});
  return bodies;
}

}  // namespace

void drop_causes_like_simpler_ones(const mesh::Machine& machine, Problem& problem) {
  const Whitener whitener(problem.fitted_covariance());
  Eigen::MatrixXd nuisances;  // white, in units of their prior
  Eigen::LLT<Eigen::MatrixXd> factor;
  for (Parameter& broad : problem.parameters) {
    const std::vector<Simpler> simpler = simpler_causes(machine, broad);
    if (simpler.empty()) continue;
    if (nuisances.size() == 0) {
      nuisances = whitener.whiten(problem.fitted(problem.columns)) * problem.prior_std.asDiagonal();
      factor.compute(Eigen::MatrixXd::Identity(nuisances.cols(), nuisances.cols()) + nuisances.transpose() * nuisances);
    }
    // Inner products of white columns less what nuisances take of them; both per unit of their parameters.
    const auto product = [&](Index a, Index b) {
      const Eigen::VectorXd left = nuisances.col(a) / problem.prior_std[a],
                            right = nuisances.col(b) / problem.prior_std[b];
      const Eigen::VectorXd taken = factor.solve(nuisances.transpose() * right);
      return left.dot(right) - (nuisances.transpose() * left).dot(taken);
    };
    const Index own = &broad - problem.parameters.data();
    const auto log_evidence = [&](Index cause) {
      const Parameter& p = problem.parameters[cause];
      const double width = p.cause_std * p.cause_std - problem.prior_std[cause] * problem.prior_std[cause],
                   square = width * product(cause, cause), seen = product(cause, own) * broad.cause_std;
      return 0.5 * (width * seen * seen / (1.0 + square) - std::log1p(square));
    };
    const double of_broad = log_evidence(own);
    for (const Simpler& place : simpler) {
      const auto same = std::find_if(problem.parameters.begin(), problem.parameters.end(), [&](const Parameter& p) {
        return p.kind == place.kind && p.where == place.where;
      });
      if (same == problem.parameters.end()) continue;
      if (of_broad < log_evidence(same - problem.parameters.begin()) + told_apart) {
        broad.cause_std = broad.nominal_std;
        break;
      }
    }
  }
}

}  // namespace thermotwin::diagnosis
