// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/cutting_fluid.h"

#include <algorithm>

namespace thermotwin::mesh {
namespace {

constexpr const char* channel = "cutting_fluid.on";

bool is_over(const PowerLaw& law) { return law.input == channel; }
bool listens(const FilmSpec& film) { return film.state == channel || is_over(film.table); }
bool listens(const VolumeSpec& volume) {
  return std::any_of(volume.exchanges.begin(), volume.exchanges.end(),
                     [](const VolumeExchange& exchange) { return exchange.state == channel; });
}
bool listens(const SourceSpec& source) { return std::any_of(source.laws.begin(), source.laws.end(), is_over); }

}  // namespace

bool has_cutting_fluid(const Machine& machine) {
  const auto any = [](const auto& parts) {
    return std::any_of(parts.begin(), parts.end(), [](const auto& part) { return listens(part); });
  };
  return any(machine.films) || any(machine.volumes) || any(machine.sources);
}

}  // namespace thermotwin::mesh
