// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A machine that changes once in the course of a record.

#include <string>
#include <utility>
#include <vector>

#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// A factor on the power of a source or the conductance of a joint from a time of the record on.
struct LaterFactor {
  std::string item;    ///< id of the source or joint
  bool joint = false;  ///< the item is a joint, else a source
  double factor = 1;
  double from_s = 0;  ///< time of the record (time_s) at which the factor begins
};

/// A machine with factors that begin during the record. The base class is the machine before the first of them.
struct MachineInTime : mesh::Machine {
  MachineInTime(const mesh::Machine& machine) : mesh::Machine(machine) {}
  MachineInTime(mesh::Machine&& machine) : mesh::Machine(std::move(machine)) {}
  std::vector<LaterFactor> later;
};

}  // namespace thermotwin::diagnosis
