// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What `nc` predicts with: the machine, the model where one was given, and the state that the program begins from.

#include <filesystem>
#include <memory>
#include <optional>

#include "mesh/machine/machine.h"
#include "nc/motion/element.h"
#include "nc/prediction/present_machine.h"
#include "reduction/model/reduced_model.h"
#include "tools/nc/nc.h"

namespace thermotwin::tools {

/// The machine, and the model where one was given.
struct Twin {
  std::optional<reduction::ReducedModel> model;
  mesh::Machine machine;
};

/// @param path  a case folder, machine.toml or model.rom.h5  @param order  of the model; 0: its own
Twin read_twin(const std::filesystem::path& path, int order);

/// The machine as the saved state has it; none where there is no state.
std::unique_ptr<nc::PresentMachine> present_machine(const NcOptions& options, const Twin& twin);

/// @return where the axes are before the program  @param present  nullptr: there is no state
nc::Positions start_of(const NcOptions& options, const mesh::Machine& machine, const nc::PresentMachine* present);

}  // namespace thermotwin::tools
