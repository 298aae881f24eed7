// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Divides the flow of a coolant circuit among its segments.

#include <string>
#include <utility>
#include <vector>

#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// Shares of the circuit's flow. Segments without a share of their own divide their common inflow evenly.
struct FlowNetwork {
  std::vector<double> share;  ///< (segments)
  std::vector<std::vector<std::pair<int, double>>>
      inflow;                                     ///< (segments) upstream segment (-1: chiller), share of the inflow
  std::vector<std::pair<int, double>> to_return;  ///< segments that end in the return, share of it
};

/// @throws InputError (place) for shares that do not balance, a closed loop or an unknown segment
FlowNetwork flow_network(const CoolantSpec& coolant, const std::string& place);

}  // namespace thermotwin::mesh
