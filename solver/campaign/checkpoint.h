// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The state of a run on disk, so that one that was killed at any moment goes on with the same bits.
// The file appears whole or not at all, knows by a hash what it belongs to, and notices damage. A
// run writes one whenever the interval has passed, and when it is interrupted.

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
  /// @param hash  of all that the run depends on: machine, mesh, loads, options
  /// @param members  what the run is made of (names of loads), to be found again by members()
  /// @param interval_s  wall clock seconds between two; 0: after every step
  /// @param resume  whether the file at hand is to be used
  Checkpoint(std::filesystem::path path, std::string hash, std::vector<std::string> members, double interval_s,
             bool resume);

  /// What belongs to the run besides its own state (recorders of results).
  std::function<void(core::BinaryWriter&)> save_rest;
  std::function<void(core::BinaryReader&)> load_rest;

  bool due() const;
  /// @param save  writes the state of the run
  void write(const std::function<void(core::BinaryWriter&)>& save);
  /// @param load  takes the state over
  /// @return false: no file, or one that is stale or damaged (a warning says which)
  bool restore(const std::function<void(core::BinaryReader&)>& load);
  void remove() const;

  struct Owner {
    std::string hash;
    std::vector<std::string> members;
  };
  /// Whose checkpoint a file is. @return nothing where it is none of this version
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
