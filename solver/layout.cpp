// SPDX-License-Identifier: GPL-3.0-or-later
// Order of terms and inputs, and the weights of joint grids.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "solver/grid_occupancy.h"
#include "solver/operating_model.h"

namespace thermotwin::solver {

namespace {

constexpr double turn = 2.0 * std::numbers::pi;

/// Adds scale times the integrals over [a, b] of the two hat functions of the cell [left, right].
void add_cell(double left, double right, double a, double b, double scale, double& at_left, double& at_right) {
  const double length = right - left, width = b - a;
  const double to_right = width * (0.5 * (a + b) - left) / length;
  at_left += scale * (width - to_right);
  at_right += scale * to_right;
}

void linear_occupancy(const std::vector<double>& x, double low, double high, Eigen::Ref<Eigen::VectorXd> weights) {
  const auto n = static_cast<Eigen::Index>(x.size());
  const auto at = [&](Eigen::Index i) { return x[static_cast<std::size_t>(i)]; };
  if (high - low <= 1e-12 * (1.0 + std::abs(low))) {
    const double p = std::clamp(low, at(0), at(n - 1));
    const Eigen::Index cell = std::clamp<Eigen::Index>(
        std::upper_bound(x.begin(), x.end(), p) - x.begin() - 1, 0, n - 2);
    const double s = (p - at(cell)) / (at(cell + 1) - at(cell));
    weights[cell] += 1.0 - s;
    weights[cell + 1] += s;
    return;
  }
  const double scale = 1.0 / (high - low);
  // Beyond the grid the matrices of its end stand.
  weights[0] += scale * std::max(0.0, std::min(high, at(0)) - low);
  weights[n - 1] += scale * std::max(0.0, high - std::max(low, at(n - 1)));
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    const double a = std::max(low, at(i)), b = std::min(high, at(i + 1));
    if (b > a) add_cell(at(i), at(i + 1), a, b, scale, weights[i], weights[i + 1]);
  }
}

void periodic_occupancy(const std::vector<double>& x, double low, double high, Eigen::Ref<Eigen::VectorXd> weights) {
  const auto n = static_cast<Eigen::Index>(x.size());
  const auto at = [&](Eigen::Index i) { return x[static_cast<std::size_t>(i % n)] + (i >= n ? turn * static_cast<double>(i / n) : 0.0); };
  const double span = high - low;
  const double start = low - turn * std::floor((low - at(0)) / turn);  // in [x0, x0 + turn)
  if (span <= 1e-12 * turn) {
    for (Eigen::Index i = 0; i < n; ++i) {
      if (start > at(i + 1)) continue;
      const double s = std::max(0.0, (start - at(i)) / (at(i + 1) - at(i)));
      weights[i] += 1.0 - s;
      weights[(i + 1) % n] += s;
      return;
    }
    weights[0] += 1.0;
    return;
  }
  const double whole = std::floor(span / turn);
  for (Eigen::Index i = 0; whole > 0 && i < n; ++i)
    add_cell(at(i), at(i + 1), at(i), at(i + 1), whole / span, weights[i], weights[(i + 1) % n]);
  const double end = start + (span - whole * turn);
  for (Eigen::Index i = 0; i < 2 * n; ++i) {
    const double a = std::max(start, at(i)), b = std::min(end, at(i + 1));
    if (b > a) add_cell(at(i), at(i + 1), a, b, 1.0 / span, weights[i % n], weights[(i + 1) % n]);
  }
}

}  // namespace

void grid_occupancy(const JointGrid& grid, double low, double high, Eigen::Ref<Eigen::VectorXd> weights) {
  weights.setZero();
  if (grid.positions.size() < 2) {
    weights.setOnes();
    return;
  }
  if (high < low) std::swap(low, high);
  if (grid.periodic)
    periodic_occupancy(grid.positions, low, high, weights);
  else
    linear_occupancy(grid.positions, low, high, weights);
}

Eigen::VectorXd grid_weights(const JointGrid& grid, double low, double high) {
  Eigen::VectorXd weights(static_cast<Eigen::Index>(grid.positions.size()));
  grid_occupancy(grid, low, high, weights);
  return weights;
}

int Layout::observed_index(ObservedKind kind, int item) const {
  for (std::size_t i = 0; i < observed.size(); ++i)
    if (observed[i].kind == kind && observed[i].item == item) return static_cast<int>(i);
  return -1;
}

Layout make_layout(const mesh::Machine& machine, std::vector<JointGrid> grids) {
  Layout layout;
  layout.grids = std::move(grids);
  const auto next_term = [&] { return static_cast<int>(layout.terms.size()); };
  for (int i = 0; i < static_cast<int>(machine.films.size()); ++i) {
    const mesh::FilmSpec& film = machine.films[static_cast<std::size_t>(i)];
    // One to a volume has no ambient of its own: the volume is part of the state.
    if (const int ambient = machine.ambient_index(film.ambient); ambient >= 0) {
      layout.inputs.push_back({.kind = InputKind::film_ambient, .term = next_term(), .item = i});
      if (machine.ambients[static_cast<std::size_t>(ambient)].has_gradient)
        layout.inputs.push_back({.kind = InputKind::film_gradient, .term = next_term(), .item = i});
    }
    layout.terms.push_back({TermKind::film, i, 0});
    if (film.of_temperature || (film.emissivity > 0.0 && film.exact_radiation)) layout.observed.push_back({ObservedKind::film, i});
  }
  for (int i = 0; i < static_cast<int>(machine.joints.size()); ++i) {
    const bool grounded = machine.joints[static_cast<std::size_t>(i)].master.empty();
    if (!machine.joints[static_cast<std::size_t>(i)].law.by_temperature.at.empty()) layout.observed.push_back({ObservedKind::joint, i});
    const int nodes = static_cast<int>(layout.grids[static_cast<std::size_t>(i)].positions.size());
    for (int node = 0; node < nodes; ++node) {
      if (grounded)
        layout.inputs.push_back({.kind = InputKind::contact_ambient, .term = next_term(), .item = i, .node = node});
      layout.terms.push_back({TermKind::contact, i, node});
    }
  }
  for (int i = 0; i < static_cast<int>(machine.coolants.size()); ++i) {
    for (int s = 0; s < static_cast<int>(machine.coolants[static_cast<std::size_t>(i)].segments.size()); ++s)
      layout.terms.push_back({TermKind::coolant_wall, i, s});
    layout.inputs.push_back({.kind = InputKind::coolant_inlet, .term = next_term(), .item = i});
    layout.terms.push_back({TermKind::coolant_flow, i, 0});
  }
  for (int i = 0; i < static_cast<int>(machine.volumes.size()); ++i) {
    const mesh::VolumeSpec& volume = machine.volumes[static_cast<std::size_t>(i)];
    for (int e = 0; e < static_cast<int>(volume.exchanges.size()); ++e) {
      if (machine.volume_index(volume.exchanges[static_cast<std::size_t>(e)].with) < 0)
        layout.inputs.push_back({.kind = InputKind::volume_ambient, .term = next_term(), .item = i, .place = e});
      layout.terms.push_back({TermKind::volume_exchange, i, e});
    }
    layout.inputs.push_back({.kind = InputKind::volume_given, .term = next_term(), .item = i});
    layout.terms.push_back({TermKind::volume_given, i, 0});
  }
  for (int i = 0; i < static_cast<int>(machine.coolants.size()); ++i)
    if (const mesh::CoolantSpec& coolant = machine.coolants[static_cast<std::size_t>(i)];
        coolant.controls_return || coolant.control == mesh::ChillerControl::pi)
      layout.observed.push_back({ObservedKind::coolant_return, i});
  for (int i = 0; i < static_cast<int>(machine.volumes.size()); ++i) {
    const std::string& id = machine.volumes[static_cast<std::size_t>(i)].id;
    const bool guides = std::any_of(machine.coolants.begin(), machine.coolants.end(),
                                    [&](const mesh::CoolantSpec& coolant) { return coolant.guide_warmed_by == id; });
    const bool drives = std::any_of(machine.films.begin(), machine.films.end(),
                                    [&](const mesh::FilmSpec& film) { return film.of_temperature && film.ambient == id; });
    if (guides || drives) layout.observed.push_back({ObservedKind::volume, i});
  }
  for (int i = 0; i < static_cast<int>(machine.sources.size()); ++i) {
    const mesh::SourceSpec& source = machine.sources[static_cast<std::size_t>(i)];
    for (int k = 0; k < static_cast<int>(source.places.size()); ++k) {
      const std::string& joint = source.places[static_cast<std::size_t>(k)].joint;
      const int nodes = joint.empty() ? 1
                                      : static_cast<int>(layout.grids[static_cast<std::size_t>(machine.joint_index(joint))]
                                                             .positions.size());
      for (int node = 0; node < nodes; ++node)
        layout.inputs.push_back({.kind = InputKind::source, .item = i, .place = k, .node = node});
    }
  }
  return layout;
}

}  // namespace thermotwin::solver
