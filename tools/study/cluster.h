// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Carries out a study in units: on this host, as a task of an array job, or as scripts for Slurm.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "study/units/resources.h"
#include "study/units/unit.h"
#include "study/units/unit_files.h"
#include "study/units/unit_work.h"
#include "tools/study/study.h"

namespace thermotwin::tools {

struct UnitStudy {
  std::filesystem::path origin;  ///< plan or case, for messages
  std::filesystem::path folder;  ///< of the study; its name is that of the Slurm job
  std::string command;           ///< words after `thermotwin` that repeat the study, quoted for a shell
  std::vector<study::Unit> units;
  study::ComputeUnit compute;
  std::function<double(std::size_t unit)> disk_bytes;  ///< of a unit's tables
  /// Of the unit among these that needs most memory.
  std::function<study::MemoryWanted(const std::vector<std::size_t>& units)> memory;
  std::function<void(const study::Work&)> gather;  ///< makes the study's results from the units that are done
};

/// Before the units are made: a study that is only gathered has to be there; another one gets its folder, which is of
/// this plan or case alone. @param folder  of the study
/// @throws InputError if there is no such study, or the folder is of another one or cannot be written
void open_study(const ClusterOptions& cluster, const std::filesystem::path& folder,
                const std::filesystem::path& origin);

/// Computes the units and gathers their results, computes the units of one part of an array job, only gathers,
/// writes the scripts for Slurm, or says what there is to compute. Nothing is written once the study's folder has gone
/// away, and no unit is begun if disk or memory are too little for those that are left.
/// @throws SolverError or InputError if no unit can be computed; InputError for a folder that has gone away, too little
///   disk or memory
void carry_out(const CommonOptions& options, const ClusterOptions& cluster, const UnitStudy& study);

/// @return whether all units are computed here, and no other host takes part
bool is_local(const ClusterOptions& cluster);

/// For the end of the gathering job, after the results of the units that are done. @param missing  units without
/// results, in words  @throws InputError if there are any
void require_none_missing(const UnitStudy& study, const std::vector<std::string>& missing);

/// @throws SolverError if units could not be computed, naming them
void require_none_failed(const UnitStudy& study, const study::Standing& standing);

/// Writes failures.csv, or removes an earlier one.
void write_failures(const UnitStudy& study, const study::Standing& standing);

}  // namespace thermotwin::tools
