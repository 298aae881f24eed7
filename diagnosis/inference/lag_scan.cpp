// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/lag_scan.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

#include "core/thread_pool.h"
#include "diagnosis/causes/parameter.h"

namespace thermotwin::diagnosis {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int scan_points = 24;
constexpr double scan_widths = 3.0;  ///< of the prior, either way
constexpr double scan_gains = 4.0;   ///< chi-square below that at nominal that is worth a closer look
constexpr std::size_t most_scanned = 4;

}  // namespace

std::vector<ScannedReading> scan_readings(const Problem& problem, const Response& response,
                                          const mesh::Machine& machine, const White& white, const LinearForm& form,
                                          const std::vector<int>& candidates) {
  std::vector<int> curved;
  for (const int i : candidates) {
    const bool member = std::find(form.members.begin(), form.members.end(), i) != form.members.end();
    if (acts_in_time(problem.parameters[i].kind) && !member) curved.push_back(i);
  }
  if (curved.empty()) return {};
  std::vector<Parameter> members;
  VectorXd prior_std = form.prior_std;
  for (const int i : form.members) {
    members.push_back(problem.parameters[i]);
    prior_std[i] = members.back().cause_std;
  }
  const MachineInTime base = with_parameters(problem.machine_around(machine, form.members), members, form.value);
  const MatrixXd states = response.states(base);
  // Nuisances take what they can, whatever the reading.
  const MatrixXd scaled = form.columns * prior_std.asDiagonal();
  MatrixXd precision = MatrixXd::Identity(scaled.cols(), scaled.cols());
  precision.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
  const Eigen::LLT<MatrixXd> factor(precision);
  const auto chi_square = [&](const VectorXd& residual) {
    const VectorXd b = scaled.transpose() * residual;
    return residual.squaredNorm() - b.dot(factor.solve(b));
  };
  const double nominal = chi_square(form.residual);
  const auto residual_at = [&](const Parameter& p, double value) {
    return VectorXd(
        white.of(problem, problem.measured - response.read(with_parameter(base, p, value), states) + form.shift));
  };
  std::vector<std::pair<double, ScannedReading>> found(curved.size());
  core::parallel_for(0, curved.size(), [&](std::size_t c) {
    const Parameter& p = problem.parameters[curved[c]];
    const double low = std::max(p.low, p.nominal - scan_widths * p.cause_std),
                 high = std::min(p.high, p.nominal + scan_widths * p.cause_std);
    double best = nominal, at = p.nominal;
    for (int k = 0; k <= scan_points; ++k) {
      const double value = low + (high - low) * k / scan_points;
      const double chi = chi_square(residual_at(p, value)) + std::pow((value - p.nominal) / p.cause_std, 2);
      if (chi < best) best = chi, at = value;
    }
    found[c].first = nominal - best;
    found[c].second.parameter = curved[c];
    found[c].second.value = at;
  });
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<ScannedReading> kept;
  for (auto& [gain, scanned] : found) {
    if (gain < scan_gains || kept.size() >= most_scanned) break;
    const Parameter& p = problem.parameters[scanned.parameter];
    const double above = std::min(scanned.value + p.step, p.high), below = std::max(scanned.value - p.step, p.low);
    scanned.column = (residual_at(p, below) - residual_at(p, above)) / (above - below);
    scanned.residual = residual_at(p, scanned.value) + scanned.column * (scanned.value - p.nominal);
    kept.push_back(std::move(scanned));
  }
  return kept;
}

}  // namespace thermotwin::diagnosis
