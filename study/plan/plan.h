// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A plan of variants: a case, the parameters that differ, and how they are combined and drawn. docs/reference/study.md
// documents the file key by key.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "diagnosis/causes/parameter.h"
#include "solver/campaign/case.h"
#include "study/plan/distribution.h"

namespace thermotwin::study {

struct StudyParameter {
  diagnosis::Parameter parameter;
  std::string name;  ///< "source_power:spindle.stator"
  Distribution distribution;
};

enum class Sampling { latin, random, pick_freeze };

struct StudyPlan {
  std::filesystem::path path;
  std::string title;
  solver::Case machine_case;
  std::vector<std::string> loads, sizes;
  int samples = 0;
  Sampling sampling = Sampling::latin;
  std::uint64_t seed = 1;
  int block = 12;
  std::vector<StudyParameter> parameters;

  std::string name() const { return path.stem().string(); }
};

/// @throws InputError naming file, line, key: an unknown kind or item, a value out of the kind's range, two
///   distributions of one parameter, a parameter twice, draws without samples
StudyPlan read_variant_plan(const std::filesystem::path& path);

}  // namespace thermotwin::study
