// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/frequency_sweep.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/progress.h"
#include "core/thread_pool.h"
#include "reduction/linear/lapack.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;

std::vector<double> log_spaced(Band band, double per_decade) {
  const double low = std::log10(0.1 * band.low), high = std::log10(10.0 * band.high);
  const int steps = std::max(1, static_cast<int>(std::ceil((high - low) * per_decade)));
  std::vector<double> grid{0.0};
  for (int k = 0; k <= steps; ++k) grid.push_back(std::pow(10.0, low + (high - low) * k / steps));
  return grid;
}

void add(std::vector<double>& grid, const std::vector<double>& more) {
  grid.insert(grid.end(), more.begin(), more.end());
  std::sort(grid.begin(), grid.end());
  grid.erase(std::unique(grid.begin(), grid.end()), grid.end());
}

/// The highest local maxima of values, by falling height.
std::vector<std::size_t> highest(const std::vector<double>& values, std::size_t most) {
  std::vector<std::size_t> maxima;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if ((k == 0 || values[k] >= values[k - 1]) && (k + 1 == values.size() || values[k] >= values[k + 1]))
      maxima.push_back(k);
  }
  std::stable_sort(maxima.begin(), maxima.end(), [&](std::size_t a, std::size_t b) { return values[a] > values[b]; });
  if (maxima.size() > most) maxima.resize(most);
  return maxima;
}

/// Golden section in the logarithm of the frequency.
Peak search(const std::function<double(double)>& value, double low, double high) {
  constexpr double golden = 0.6180339887498949;
  constexpr int halvings = 24;
  double a = std::log(low), b = std::log(high);
  double x = b - golden * (b - a), y = a + golden * (b - a);
  double fx = value(std::exp(x)), fy = value(std::exp(y));
  for (int k = 0; k < halvings; ++k) {
    if (fx >= fy) {
      b = y, y = x, fy = fx;
      x = b - golden * (b - a);
      fx = value(std::exp(x));
    } else {
      a = x, x = y, fx = fy;
      y = a + golden * (b - a);
      fy = value(std::exp(y));
    }
  }
  return fx >= fy ? Peak{fx, std::exp(x)} : Peak{fy, std::exp(y)};
}

/// Largest value on a grid and, by search, between its points.
Peak largest_on(const std::vector<double>& grid, const std::function<double(double)>& value,
                std::vector<double>* where = nullptr) {
  std::vector<double> values(grid.size());
  core::parallel_for(0, grid.size(), [&](std::size_t k) { values[k] = value(grid[k]); });
  constexpr std::size_t searched = 6;
  const std::vector<std::size_t> maxima = highest(values, searched);
  std::vector<Peak> peaks(maxima.size());
  core::parallel_for(0, maxima.size(), [&](std::size_t m) {
    const std::size_t k = maxima[m];
    peaks[m] = {values[k], grid[k]};
    const double low = k > 0 ? grid[k - 1] : grid[k], high = k + 1 < grid.size() ? grid[k + 1] : grid[k];
    if (low <= 0.0 || !(high > low)) return;
    if (const Peak between = search(value, low, high); between.value > peaks[m].value) peaks[m] = between;
  });
  Peak best;
  for (const Peak& peak : peaks) {
    if (where) where->push_back(peak.frequency);
    if (peak.value > best.value || best.value == 0.0) best = peak;
  }
  return best;
}

}  // namespace

double largest_singular_value(const MatrixXcd& matrix) {
  if (matrix.size() == 1) return std::abs(matrix(0));
  const double size = matrix.cwiseAbs().maxCoeff();
  if (size == 0.0 || !std::isfinite(size)) return size;
  const MatrixXcd scaled = matrix / size;
  const bool wide = matrix.cols() > matrix.rows();
  const MatrixXcd gram = wide ? MatrixXcd(scaled * scaled.adjoint()) : MatrixXcd(scaled.adjoint() * scaled);
  return size * std::sqrt(lapack::largest_eigenvalue(gram));
}

ReducedResponse::ReducedResponse(const ReducedLinearSystem& system) {
  lapack::Schur schur = lapack::schur(system.A);
  triangular_ = std::move(schur.triangular);
  b_ = schur.vectors.adjoint() * system.B;
  c_ = system.C * schur.vectors;
}

MatrixXcd ReducedResponse::operator()(double frequency) const {
  MatrixXcd x = b_;
  for (Index i = x.rows() - 1; i >= 0; --i) {
    x.row(i) /= Complex(0, frequency) - triangular_(i, i);
    if (i > 0) x.topRows(i).noalias() += triangular_.col(i).head(i) * x.row(i);
  }
  return c_ * x;
}

FrequencySweep::FrequencySweep(const SystemSolver& solver, const std::optional<ReducedLinearSystem>& stand_in)
    : solver_(solver) {
  if (stand_in) stand_in_.emplace(*stand_in);
  grid_ = log_spaced(solver.band(), solver.dense() ? 20 : 2);
  add(grid_, solver.peaks());
}

void FrequencySweep::ask(const std::vector<double>& frequencies) {
  std::vector<double> unknown;
  for (const double w : frequencies)
    if (known_.find(w) == known_.end()) unknown.push_back(w);
  std::vector<MatrixXcd> values(unknown.size());
  core::parallel_for(0, unknown.size(), [&](std::size_t k) {
    core::check_interrupt();
    values[k] = solver_.response(Complex(0, unknown[k]));
  });
  for (std::size_t k = 0; k < unknown.size(); ++k) known_[unknown[k]] = std::move(values[k]);
}

template <class Difference>
Peak FrequencySweep::largest(std::vector<double> grid, const Difference& difference) {
  if (stand_in_) {
    // Where the stand-in peaks the system is asked; what counts is what the system says.
    std::vector<double> fine = log_spaced(solver_.band(), 40);
    add(fine, grid);
    std::vector<double> places;
    largest_on(
        fine, [&](double w) { return largest_singular_value(difference(w, (*stand_in_)(w))); }, &places);
    add(grid, places);
    ask(grid);
    Peak best;
    for (const double w : grid)
      if (const double value = largest_singular_value(difference(w, known_[w])); value > best.value) best = {value, w};
    return best;
  }
  ask(grid);
  return largest_on(grid, [&](double w) {
    const auto found = known_.find(w);
    return largest_singular_value(
        difference(w, found != known_.end() ? found->second : solver_.response(Complex(0, w))));
  });
}

Peak FrequencySweep::norm() {
  return largest(grid_, [](double, const MatrixXcd& g) -> const MatrixXcd& { return g; });
}

Peak FrequencySweep::error(const ReducedResponse& reduced) {
  std::vector<double> grid = grid_;
  constexpr std::size_t most_poles = 100, most_poles_sparse = 6;
  add(grid, peak_frequencies(reduced.poles(), stand_in_ ? most_poles_sparse : most_poles));
  return largest(std::move(grid), [&](double w, const MatrixXcd& g) -> MatrixXcd { return g - reduced(w); });
}

}  // namespace thermotwin::reduction
