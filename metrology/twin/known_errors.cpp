// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/twin/known_errors.h"

#include <charconv>
#include <cmath>

#include "core/error.h"
#include "core/units.h"
#include "metrology/plan/sphere.h"
#include "metrology/rtest/error_terms.h"

namespace thermotwin::metrology {

std::pair<std::string, double> known_error(const std::string& text) {
  constexpr double largest = 1e5;
  const std::size_t equals = text.find('=');
  double value = 0.0;
  const char* end = text.data() + text.size();
  const bool has = equals != std::string::npos && equals > 0;
  const auto read = std::from_chars(text.data() + (has ? equals + 1 : text.size()), end, value);
  if (!has || read.ec != std::errc() || read.ptr != end || !(std::abs(value) <= largest)) {
    throw core::InputError("--add", "'" + text + "'",
                           "an error of the chain and a number of at most 1e5 in um, um/m ..., such as EXX1=20");
  }
  return {text.substr(0, equals), value * core::units::um};
}

void add_known_errors(const mesh::Machine& machine, const std::vector<PlannedPoint>& points,
                      const std::map<std::string, double>& errors, VirtualRun& run) {
  if (errors.empty()) return;
  const mesh::KinematicChain chain = chain_of(machine);
  compensation::OffsetOptions options;
  if (machine.tcp.table_radius > 0) options.table_radius = machine.tcp.table_radius;
  const compensation::LocationOffsets map(chain, options);
  std::vector<std::string> names;
  for (const auto& [name, value] : errors) names.push_back(name);
  const std::vector<ErrorTerm> terms = error_terms(names, map, chain, "--add");
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].cycle == points.front().cycle) continue;
    for (const ErrorTerm& term : terms) {
      const Eigen::Vector3d shift = shift_of(term, map, positions_of(machine, points[i].pose), points[i].sphere);
      run.error[i].head<3>() += errors.at(term.name) * shift;
    }
  }
}

}  // namespace thermotwin::metrology
