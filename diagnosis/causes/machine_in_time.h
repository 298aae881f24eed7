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
  bool joint = false;  ///< of a joint, else of a source
  double factor = 1;
  double from_s = 0;  ///< in the time of the record
};

/// As a Machine it is the one before all of its factors.
struct MachineInTime : mesh::Machine {
  MachineInTime(const mesh::Machine& machine) : mesh::Machine(machine) {}
  MachineInTime(mesh::Machine&& machine) : mesh::Machine(std::move(machine)) {}
  std::vector<LaterFactor> later;
};

}  // namespace thermotwin::diagnosis
