// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/detectability.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/text.h"

namespace thermotwin::compensation {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double least = 1.0;  ///< deviations of a reading

/// 1 / smallest real part of the eigenvalues of (A, E); infinite where one has none.
double slowest_time(const MatrixXd& capacity, const MatrixXd& operator_matrix) {
  const Eigen::LLT<MatrixXd> factor(capacity);
  MatrixXd scaled = factor.matrixL().solve(operator_matrix);
  scaled = factor.matrixL().solve(scaled.transpose()).transpose();
  const VectorXd poles = Eigen::EigenSolver<MatrixXd>(scaled, false).eigenvalues().real();
  const double slowest = poles.minCoeff();
  return slowest > 1e-14 * poles.cwiseAbs().maxCoeff() ? 1.0 / slowest : std::numeric_limits<double>::infinity();
}

}  // namespace

Detectability detectability(const MatrixXd& capacity, const MatrixXd& operator_matrix, const MatrixXd& rates,
                            const MatrixXd& sensors, const std::vector<ErrorModel::State>& states,
                            const VectorXd& reading_std) {
  Detectability result;
  result.slowest_s = slowest_time(capacity, operator_matrix);
  const MatrixXd gain = sensors * Eigen::PartialPivLU<MatrixXd>(operator_matrix).solve(rates);
  std::vector<Index> used;
  for (Index s = 0; s < reading_std.size(); ++s) {
    if (std::isfinite(reading_std[s])) used.push_back(s);
  }
  result.sensors = std::ssize(used);
  const auto count = std::ssize(states);
  MatrixXd columns = MatrixXd::Zero(result.sensors, count);
  for (Index k = 0; k < count; ++k) {
    for (Index i = 0; i < result.sensors; ++i) {
      const Index s = used[i];
      const double moved = k < rates.cols() ? gain(s, k) : (k - rates.cols() == s ? 1.0 : 0.0);
      columns(i, k) = moved * states[k].prior_std / reading_std[s];
    }
    result.states.push_back({states[k], columns.col(k).norm(), 0.0, false, ""});
  }

  // Pivoted Gram and Schmidt: the most telling one, then what is most telling beyond it, ...
  MatrixXd rest = columns;
  std::vector<Index> chosen;
  std::vector<bool> taken(count, false);
  while (std::ssize(chosen) < result.sensors) {
    Index best = -1;
    for (Index k = 0; k < count; ++k) {
      if (!taken[k] && (best < 0 || rest.col(k).norm() > rest.col(best).norm())) best = k;
    }
    if (best < 0 || !(rest.col(best).norm() >= least)) break;
    taken[best] = true;
    result.states[best].beyond = rest.col(best).norm();
    result.states[best].detectable = true;
    chosen.push_back(best);
    const VectorXd direction = rest.col(best).normalized();
    rest -= direction * (direction.transpose() * rest).eval();
  }
  result.detectable = std::ssize(chosen);
  if (!chosen.empty())
    result.margin = Eigen::JacobiSVD<MatrixXd>(columns(Eigen::all, chosen)).singularValues().minCoeff();
  for (Index k = 0; k < count; ++k) {
    AugmentedState& state = result.states[k];
    if (state.detectable) continue;
    state.beyond = rest.col(k).norm();
    double nearest = 0.0;
    for (const Index other : chosen) {
      const double product = columns.col(k).norm() * columns.col(other).norm();
      const double alike = product > 0.0 ? std::abs(columns.col(k).dot(columns.col(other))) / product : 0.0;
      if (alike <= nearest) continue;
      nearest = alike;
      state.like = states[other].name;
    }
  }
  std::stable_sort(result.states.begin(), result.states.end(), [](const AugmentedState& a, const AugmentedState& b) {
    if (a.detectable != b.detectable) return a.detectable;
    return (a.detectable ? a.beyond : a.reach) > (b.detectable ? b.beyond : b.reach);
  });
  return result;
}

std::string Detectability::brief() const {
  std::string text = fmt::format(
      "detectability of the disturbance states at the mean operating point (Popov-Belevitch-Hautus test)\nthermal "
      "states: {}\n{} of {} disturbance states, taken as constants, are observable with {} sensors; smallest singular "
      "value {:.2f} standard deviations of a reading\n",
      std::isfinite(slowest_s)
          ? fmt::format("all decay, the slowest with a time constant of {:.1f} h", slowest_s / 3600.0)
          : "not all decay, because a part of the machine has no path for its heat",
      detectable, states.size(), sensors, margin);
  std::vector<std::vector<std::string>> table{{"state", "detectable", "reach", "beyond the others", "prior std",
                                               "std after the run", "value", "unit", "similar to"}};
  for (const AugmentedState& a : states) {
    table.push_back({a.state.name,
                     a.detectable      ? "yes"
                     : a.reach < least ? "no: no sensor nearby"
                                       : "no",
                     fmt::format("{:.2f}", a.reach), fmt::format("{:.2f}", a.beyond),
                     fmt::format("{:.3g}", a.state.prior_std), fmt::format("{:.3g}", a.state.std),
                     fmt::format("{:.3g}", a.state.value), a.state.unit, a.like});
  }
  return text + core::format_table(table) +
         "A state that is not detectable keeps its prior, and std_um includes it.\nVarying loads identify more states "
         "than a standing machine; see std after the run.\n";
}

}  // namespace thermotwin::compensation
