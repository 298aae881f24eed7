// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Computes units of a study: all of them, or every N-th as a task of an array job. Two processes never compute the same
// unit, and one that was stopped goes on from what it has left in its folder.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "study/units/unit.h"
#include "study/units/unit_files.h"

namespace thermotwin::study {

/// Every N-th unit from unit I on.
struct Part {
  std::size_t index = 0, of = 1;
};

/// @param words  I/N; empty: all units  @throws UsageError
Part part_of(const std::string& words);

/// Removed from a unit's folder once the unit is done.
inline constexpr const char* checkpoint_file = "checkpoint.bin";

/// Computes unit number `unit` in its folder. @return the results
/// @throws MeshError, SolverError if it cannot be computed
using ComputeUnit = std::function<UnitFiles(std::size_t unit, const std::filesystem::path& folder)>;

struct Work {
  std::size_t computed = 0, kept = 0;
  std::vector<std::string> failed;  ///< in words, with their reasons
  bool unsolved = false;            ///< a SolverError was among them
};

/// Computes the units of the part that are not done. The reason why one cannot be computed is noted; the others go on.
/// @throws InputError for a folder that another process writes or that cannot be written; Interrupted
Work compute(const std::filesystem::path& study, const std::vector<Unit>& units, const Part& part,
             const ComputeUnit& compute_unit);

}  // namespace thermotwin::study
