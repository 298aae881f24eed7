// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Keeps the state of a run on disk, so that a run killed at any moment continues and ends with the same bits. The file
// appears whole or not at all, identifies its run by a hash, and detects damage. A run writes a checkpoint after each
// interval and when it is interrupted.

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/binary.h"

namespace thermotwin::solver {

class Checkpoint {
public:
  /// @param hash  of everything that the run depends on: machine, mesh, loads, options
  /// @param members  names of the loads in the run, for owner()
  /// @param interval_s  wall clock seconds between two checkpoints; 0: after every step
  /// @param resume  whether an existing file is used
  Checkpoint(std::filesystem::path path, std::string hash, std::vector<std::string> members, double interval_s,
             bool resume);

  /// Save and load what belongs to the run besides its state, such as the recorders of results.
  std::function<void(core::BinaryWriter&)> save_rest;
  std::function<void(core::BinaryReader&)> load_rest;

  bool due() const;
  /// Writes the checkpoint. @param save  writes the state of the run
  void write(const std::function<void(core::BinaryWriter&)>& save);
  /// Reads the checkpoint. @param load  takes over the state of the run
  /// @return false if there is no file, or it is stale or damaged; a warning names the reason
  bool restore(const std::function<void(core::BinaryReader&)>& load);
  void remove() const;

  struct Owner {
    std::string hash;
    std::vector<std::string> members;
  };
  /// @return the run that a checkpoint file belongs to; nothing if it is no checkpoint of this version
  static std::optional<Owner> owner(const std::filesystem::path& path);

private:
  std::optional<std::string> read() const;
  std::filesystem::path path_;
  std::string hash_;
  std::vector<std::string> members_;
  double interval_s_;
  bool resume_;
  std::optional<std::chrono::steady_clock::time_point> last_;  // none: the first step leaves one
};

}  // namespace thermotwin::solver
