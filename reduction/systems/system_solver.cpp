// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/system_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "core/error.h"
#include "core/range.h"
#include "reduction/systems/dense_solver.h"
#include "reduction/systems/sparse_solver.h"

namespace thermotwin::reduction {

using Eigen::Index;

void refuse_unstable(const std::string& place, Complex value, bool within_rounding) {
  const std::string shown = value.imag() == 0.0
                                ? fmt::format("{:.6g}", value.real())
                                : fmt::format("{:.6g} +- {:.6g} i", value.real(), std::abs(value.imag()));
  throw core::InputError(
      place,
      within_rounding
          ? fmt::format("not stable: A is singular, (A, E) has the eigenvalue {}, zero within rounding", shown)
          : fmt::format("not stable: (A, E) has the eigenvalue {}", shown),
      "eigenvalues with negative real parts (give a free or undamped part a support, a film or damping; split off an "
      "unstable part)");
}

void refuse_singular(const std::string& place, const Sparse& e, double rcond) {
  Eigen::VectorXi entries = Eigen::VectorXi::Zero(e.rows());
  for (Index k = 0; k < e.outerSize(); ++k) {
    for (Sparse::InnerIterator it(e, k); it; ++it)
      if (it.value() != 0.0) ++entries(it.row());
  }
  const auto empty = (entries.array() == 0).count();
  const std::string what = empty > 0 ? fmt::format("{} of its {} rows are empty", empty, e.rows())
                                     : fmt::format("reciprocal condition {:.2g}", rcond);
  throw core::InputError(place + "/E.mtx", "singular: " + what,
                         "a regular E; first eliminate the equations without a time derivative (Schur complement; "
                         "their direct feedthrough goes to D)");
}

std::vector<Index> by_dominance(const Eigen::VectorXcd& values, const Eigen::VectorXd& dominance, Index count) {
  std::vector<Index> order(values.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return dominance(a) > dominance(b); });
  std::vector<bool> taken(order.size(), false);
  std::vector<Index> chosen;
  for (const Index i : order) {
    if (std::ssize(chosen) >= count) break;
    if (taken[i]) continue;
    Index partner = -1;
    if (values(i).imag() != 0.0) {
      double nearest = 1e-6 * std::abs(values(i));
      for (const Index j : order) {
        const double distance = std::abs(values(j) - std::conj(values(i)));
        if (j != i && !taken[j] && distance <= nearest) partner = j, nearest = distance;
      }
      if (partner < 0) continue;
    }
    for (const Index j : {i, partner}) {
      if (j < 0) continue;
      taken[j] = true;
      chosen.push_back(j);
    }
  }
  return chosen;
}

std::vector<double> peak_frequencies(const Eigen::VectorXcd& poles, std::size_t most) {
  constexpr double light_damping = 0.3;
  std::vector<std::pair<double, double>> found;
  for (const Complex& pole : poles) {
    const double ratio = -pole.real() / std::abs(pole);
    if (pole.imag() > 0.0 && ratio < light_damping) found.emplace_back(ratio, pole.imag());
  }
  std::sort(found.begin(), found.end());
  if (found.size() > most) found.resize(most);
  std::vector<double> frequencies;
  for (const auto& [ratio, frequency] : found) frequencies.push_back(frequency);
  return frequencies;
}

void SolverOptions::validate() const {
  core::require_option(dense_limit >= 0, "system solver dense_limit", dense_limit, "0 or more states");
  core::require_option(residual > 0.0 && residual < 1.0, "system solver residual", residual, "above 0, below 1");
}

std::unique_ptr<SystemSolver> make_system_solver(const StateSpace& system, const std::string& place,
                                                 const SolverOptions& options) {
  options.validate();
  if (system.size() <= options.dense_limit) return make_dense_solver(system, place);
  return make_sparse_solver(system, place, options);
}

}  // namespace thermotwin::reduction
