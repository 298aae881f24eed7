// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/flow_network.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"

namespace thermotwin::mesh {

using core::InputError;

FlowNetwork flow_network(const CoolantSpec& coolant, const std::string& place) {
  constexpr double slack = 1e-9;
  const std::size_t count = coolant.segments.size();
  FlowNetwork network{std::vector<double>(count, 0.0), {}, {}};
  network.inflow.resize(count);
  const auto index_of = [&](const std::string& id, int before) {
    for (int i = 0; i < before; ++i)
      if (coolant.segments[i].id == id) return i;
    throw InputError(place + " segment " + coolant.segments[before].id + " after", "'" + id + "'",
                     "\"chiller\", or segments that stand before it in the file");
  };
  std::vector<char> taken(count, 0);
  std::vector<char> done(count, 0);
  for (std::size_t s = 0; s < count; ++s) {
    if (done[s]) continue;
    const CoolantSegment& first = coolant.segments[s];
    std::vector<int> parents;
    double inflow = first.after.empty() ? 1.0 : 0.0;
    for (const std::string& id : first.after) {
      parents.push_back(index_of(id, s));
      const std::size_t parent = parents.back();
      if (taken[parent]) {
        throw InputError(place + " segment " + first.id + " after",
                         "'" + id + "', whose flow already goes to another segment",
                         "branches after the same segments name the same list");
      }
      taken[parent] = 1;
      inflow += network.share[parent];
    }
    // Branches after the same segments divide what flows out of these.
    std::vector<std::size_t> branches;
    double given = 0.0;
    std::size_t open = 0;
    for (std::size_t b = s; b < count; ++b) {
      if (done[b] || coolant.segments[b].after != first.after) continue;
      branches.push_back(b);
      if (std::isnan(coolant.segments[b].share))
        ++open;
      else
        given += coolant.segments[b].share;
    }
    if (given > inflow + slack || (open == 0 && given < inflow - slack) || (open > 0 && given > inflow - slack)) {
      throw InputError(place + " segment " + first.id + " share",
                       fmt::format("shares that add to {:.6g}{}", given, open > 0 ? ", and a branch without one" : ""),
                       fmt::format("{} of the circuit's flow, the sum of the inflows", fmt::format("{:.6g}", inflow)));
    }
    for (const std::size_t b : branches) {
      const double share = coolant.segments[b].share;
      network.share[b] = std::isnan(share) ? (inflow - given) / open : share;
      if (!(network.share[b] > 0.0)) {
        throw InputError(place + " segment " + coolant.segments[b].id + " share", fmt::format("{}", share),
                         "a number > 0");
      }
      for (const int parent : parents) network.inflow[b].emplace_back(parent, network.share[parent] / inflow);
      if (parents.empty()) network.inflow[b].emplace_back(-1, 1.0);
      done[b] = 1;
    }
  }
  for (std::size_t s = 0; s < count; ++s)
    if (!taken[s]) network.to_return.emplace_back(s, network.share[s]);
  return network;
}

}  // namespace thermotwin::mesh
