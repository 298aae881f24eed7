// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The programs of a training record, by what the composite correlative model learns from them, and the two sensors that
// stand for the surroundings (Naumann et al. 2023, section 3.1).

#include <Eigen/Core>

#include <array>
#include <vector>

#include "compensation/measurement/dataset.h"

namespace thermotwin::compensation {

enum class ProgramKind {
  baseline,  ///< machine off
  ambient,   ///< machine on, and no speed, power or state beside
  internal,  ///< at work
};

struct ModuleProgram {
  Eigen::Index from, to;  ///< rows [from, to)
  ProgramKind kind;
};

/// One a stretch of the record, in the order of time.
std::vector<ModuleProgram> module_programs(const TrainingData& data);

/// Inputs whose range depends least on the program at work; first the one that moves less.
/// @param temperatures  inputs to choose from
/// @throws InputError (fewer than two have readings at work)
std::array<Eigen::Index, 2> ambient_sensors(const TrainingData& data, const std::vector<Eigen::Index>& temperatures,
                                            const std::vector<ModuleProgram>& programs);

}  // namespace thermotwin::compensation
