// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Disk and memory that units need, compared with what there is before the first of them. Memory is a lower bound, and
// tables are counted without checkpoints: a study that passes can still run out of either, with a message of its own.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "mesh/machine/machine.h"
#include "study/units/unit.h"
#include "study/units/unit_work.h"

namespace thermotwin::study {

inline constexpr double GiB = 1024.0 * 1024.0 * 1024.0;  ///< bytes

struct MemoryWanted {
  double bytes = 0;    ///< of the unit that needs most; 0: not known
  std::string words;   ///< what needs it, e.g. "12 variants of 4321 nodes"
  std::string remedy;  ///< e.g. "block = 5 or less"
};

/// Units of the part that have no result yet, without a look at the content of results.
std::vector<std::size_t> pending_units(const std::filesystem::path& study, const std::vector<Unit>& units,
                                       const Part& part);

/// Size of a table of so many numbers on disk, bytes.
double table_bytes(double numbers);

/// @param cache  of meshes  @return nodes of the machine's mesh; 0 if it cannot be meshed, which its units will say
Eigen::Index nodes_of_mesh(const mesh::Machine& machine, double size_factor, const std::filesystem::path& cache);

/// What a process with a full model of this mesh holds at least, bytes.
double model_bytes(Eigen::Index nodes);

/// @return bytes that are free where the folder is, or where the nearest one above it is; infinite: not known
double free_disk(std::filesystem::path folder);

/// @param bytes  of the tables that are still to be written  @throws InputError if the disk has no room for them
void require_disk(const std::filesystem::path& study, double bytes);

/// @param place  what offers the memory, for the message, e.g. "--task-memory"  @throws InputError if it is too little
void require_memory(const MemoryWanted& wanted, const std::string& place, double available_bytes);

}  // namespace thermotwin::study
