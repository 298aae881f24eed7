// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/error_terms.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/text.h"

namespace thermotwin::metrology {

namespace {

bool is_component(const std::string& name) { return name.size() >= 4 && name[0] == 'E'; }

/// "EYX2" of the axis X.
ErrorTerm component_term(const std::string& name) {
  const std::string axis = name.substr(2, name.size() - 3);
  return {name, std::string(1, name[1]) + "0" + axis, axis, name.back() - '0'};
}

std::vector<std::string> component_names(const mesh::KinematicChain& chain) {
  std::vector<std::string> names;
  for (const std::string& id : chain.ids()) {
    if (chain.find(id)->rotary) continue;
    for (const char component : std::string("XYZABC"))
      for (int n = 1; n <= highest_power; ++n)
        names.push_back("E" + std::string(1, component) + id + std::to_string(n));
  }
  return names;
}

}  // namespace

std::vector<ErrorTerm> error_terms(const std::vector<std::string>& names, const compensation::LocationOffsets& map,
                                   const mesh::KinematicChain& chain, const std::string& place) {
  std::vector<std::string> known = map.known_errors();
  const std::vector<std::string> components = component_names(chain);
  known.insert(known.end(), components.begin(), components.end());
  std::vector<ErrorTerm> terms;
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      throw core::InputError(
          place, "'" + name + "'",
          "of this chain: " + core::join(map.known_errors()) +
              (components.empty() ? "" : ", or component errors " + components.front() + " to " + components.back()) +
              " (nearest: " + core::nearest(name, known) + ")");
    }
    terms.push_back(is_component(name) ? component_term(name) : ErrorTerm{name, name, "", 0});
  }
  return terms;
}

Eigen::Vector3d shift_of(const ErrorTerm& term, const compensation::LocationOffsets& map,
                         const std::map<std::string, double>& positions, const Eigen::Vector3d& point) {
  double factor = 1.0;
  if (term.power > 0) {
    const auto at = positions.find(term.axis);
    factor = at == positions.end() ? 0.0 : std::pow(at->second, term.power);
  }
  return map.motion_of(term.located, factor, positions, point).shift;
}

std::string unit_of_error(const std::string& name) {
  const bool component = is_component(name);
  const char letter = component ? name[1] : name[0];
  const int power = (component ? name.back() - '0' : 0) + ((letter >= 'A' && letter <= 'C') || letter == 'r' ? 1 : 0);
  return power == 0 ? "um" : power == 1 ? "um/m" : "um/m" + std::to_string(power);
}

std::vector<std::string> units_of_errors(const std::vector<std::string>& names) {
  std::vector<std::string> units;
  for (const std::string& name : names) units.push_back(unit_of_error(name));
  return units;
}

}  // namespace thermotwin::metrology
