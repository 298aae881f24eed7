// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/radiation_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "solver/operation/film_laws.h"
#include "solver/operation/layout.h"

namespace thermotwin::solver {

namespace {

constexpr double allowed = 0.01;
constexpr double no_flow_K = 0.1;  // closer to its surroundings a surface exchanges nothing to speak of

}  // namespace

RadiationCheck::RadiationCheck(const mesh::Machine& machine, const ThermalSystem& system) : machine_(machine) {
  for (std::size_t k = 0; k < system.layout.inputs.size(); ++k) {
    const Input& input = system.layout.inputs[k];
    if (input.kind != InputKind::film_ambient) continue;
    const mesh::FilmSpec& film = machine.films[input.item];
    if (!(film.emissivity.value > 0.0) || film.exact_radiation) continue;
    Film entry{input.item, system.inputs.col(k), 0, 0, 0, {}};
    entry.mean /= entry.mean.sum();
    films_.push_back(std::move(entry));
  }
}

void RadiationCheck::add(const OperatingModel& model, const std::string& load, const OutputState& output) {
  const double reference_K = machine_.reference_C + core::units::zero_C_in_K, linear = radiation(1.0, reference_K);
  for (Film& film : films_) {
    const double surface_K = film.mean.dot(output.state), surroundings_K = model.surroundings_K(film.film, output.row);
    if (std::abs(surface_K - surroundings_K) < no_flow_K) continue;
    const double off = linear / radiation_between(1.0, surface_K + reference_K, surroundings_K + reference_K) - 1.0;
    if (std::abs(off) <= std::abs(film.off)) continue;
    film.off = off;
    film.surface_C = surface_K + machine_.reference_C;
    film.surroundings_C = surroundings_K + machine_.reference_C;
    film.load = load;
  }
}

std::string RadiationCheck::warning() const {
  const auto worst = std::max_element(films_.begin(), films_.end(),
                                      [](const Film& a, const Film& b) { return std::abs(a.off) < std::abs(b.off); });
  if (worst == films_.end() || std::abs(worst->off) <= allowed) return {};
  const auto count =
      std::count_if(films_.begin(), films_.end(), [](const Film& film) { return std::abs(film.off) > allowed; });
  return fmt::format(
      "radiation linearised at {:.1f} degC has an error above 1 % at {} of {} films, {:+.1f} % at film {} (surface "
      "{:.1f}, surroundings {:.1f} degC, load {}). radiation = \"exact\" avoids this error",
      machine_.reference_C, count, films_.size(), 100.0 * worst->off, machine_.films[worst->film].id, worst->surface_C,
      worst->surroundings_C, worst->load);
}

}  // namespace thermotwin::solver
