// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// loads/*.toml, key by key as cases/README.md says.

#include <filesystem>

#include "core/config.h"
#include "solver/operation/load_program.h"

namespace thermotwin::solver {

/// The only one that writes a program's fields.
class LoadReader {
public:
  /// @param path  name for messages; its stem is the program's name
  /// @throws InputError naming file, line, key
  static LoadProgram read(const core::Config& config, const std::filesystem::path& path, const mesh::Machine& machine);

private:
  class Reading;
};

}  // namespace thermotwin::solver
