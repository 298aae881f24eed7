// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/budget/gum.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "core/error.h"

namespace thermotwin::metrology {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Fourth order, within a twentieth of the standard uncertainty: the slope at the estimate.
VectorXd slope(const Budget& budget, const Budget::Model& model, const VectorXd& at, Index input) {
  const double step = std::max({0.05 * budget.inputs[input].std, 1e-5 * std::abs(at[input]), 1e-300});
  const auto moved = [&](double steps) {
    VectorXd x = at;
    x[input] += steps * step;
    return model(x);
  };
  VectorXd result = (8.0 * (moved(1.0) - moved(-1.0)) - (moved(2.0) - moved(-2.0))) / (12.0 * step);
  for (Index i = 0; i < result.size(); ++i) {
    if (std::isfinite(result[i])) continue;
    throw InputError(fmt::format("{} quantity[{}].formula", budget.source, i + 1),
                     fmt::format("no finite value for '{}' beside {}", budget.inputs[input].name, at[input]),
                     "a formula that is defined around the inputs' values");
  }
  return result;
}

double effective_degrees(const Budget& budget, const Eigen::RowVectorXd& contribution, double std) {
  if (!(std > 0.0)) return std::numeric_limits<double>::infinity();
  struct Term {
    VectorXd c;
    double degrees = std::numeric_limits<double>::infinity();
  };
  std::map<int, Term> terms;
  for (Index i = 0; i < contribution.size(); ++i) {
    Term& term = terms[budget.inputs[i].group];
    if (term.c.size() == 0) term.c = VectorXd::Zero(contribution.size());
    term.c[i] = contribution[i];
    if (contribution[i] != 0.0) term.degrees = std::min(term.degrees, budget.inputs[i].degrees_of_freedom);
  }
  double sum = 0.0;
  for (const auto& [group, term] : terms) {
    const double share = term.c.dot(budget.correlation * term.c) / (std * std);
    sum += share * share / term.degrees;
  }
  return sum > 0.0 ? 1.0 / sum : std::numeric_limits<double>::infinity();
}

double coverage_factor(double probability, double degrees) {
  const double tail = 0.5 * (1.0 - probability);
  constexpr double many = 1e7;  // a t distribution is normal to all digits
  if (degrees > many) return boost::math::quantile(boost::math::complement(boost::math::normal(), tail));
  return boost::math::quantile(boost::math::complement(boost::math::students_t(degrees), tail));
}

}  // namespace

GumResult gum(const Budget& budget) {
  const Budget::Model model(budget);
  const Index inputs = std::ssize(budget.inputs), quantities = std::ssize(budget.quantities);
  VectorXd at(inputs), std(inputs);
  for (Index i = 0; i < inputs; ++i) {
    at[i] = budget.inputs[i].value;
    std[i] = budget.inputs[i].std;
  }
  GumResult result;
  result.value = model(at);
  result.sensitivity.resize(quantities, inputs);
  for (Index i = 0; i < inputs; ++i) result.sensitivity.col(i) = slope(budget, model, at, i);
  result.contribution = result.sensitivity * std.asDiagonal();
  const MatrixXd covariance = result.contribution * budget.correlation * result.contribution.transpose();
  result.std = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  // Inputs with the correlation -1 cancel to the rounding of their products, whose root is 1e-8 of them.
  constexpr double rounding = 16.0 * std::numeric_limits<double>::epsilon();
  for (Index i = 0; i < quantities; ++i) {
    const double sum = result.contribution.row(i).cwiseAbs().sum();
    if (covariance(i, i) <= rounding * sum * sum) result.std[i] = 0.0;
  }
  result.correlation = MatrixXd::Identity(quantities, quantities);
  result.degrees_of_freedom.resize(quantities);
  result.factor.resize(quantities);
  for (Index i = 0; i < quantities; ++i) {
    for (Index k = 0; k < quantities; ++k) {
      const double product = result.std[i] * result.std[k];
      if (i != k) result.correlation(i, k) = product > 0.0 ? covariance(i, k) / product : 0.0;
    }
    result.degrees_of_freedom[i] = effective_degrees(budget, result.contribution.row(i), result.std[i]);
    result.factor[i] =
        budget.factor ? *budget.factor : coverage_factor(budget.probability, result.degrees_of_freedom[i]);
  }
  result.expanded = result.factor.cwiseProduct(result.std);
  return result;
}

}  // namespace thermotwin::metrology
