// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads a load program from loads/*.toml. docs/reference/load.md documents its keys.

#include <filesystem>

#include "core/config.h"
#include "solver/operation/load_program.h"

namespace thermotwin::solver {

/// The only class that sets the fields of a LoadProgram.
class LoadReader {
public:
  /// @param path  name for messages; its stem is the program's name
  /// @throws InputError naming file, line, key
  static LoadProgram read(const core::Config& config, const std::filesystem::path& path, const mesh::Machine& machine);

private:
  class Reading;
};

}  // namespace thermotwin::solver
