// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The subjects of tools/bench; each runs its pairs and returns its table.

#include <filesystem>
#include <string>

namespace thermotwin::bench {

struct Settings {
  std::filesystem::path case_path = "cases/vmc5", programs, thermotwin, work;
  std::filesystem::path model;  ///< empty: made from the case, kept in work
  std::string size = "coarse", body = "column";
  int threads = 0;  ///< of whole-machine work; what is compared with a single-threaded program has one
  int pairs = 5, steps = 100;
  int deck_steps = 6;  ///< time steps of CalculiX, which factorises in each
  int variants = 200;  ///< of a study
  std::string study_load = "validation_21C";
  bool bodies_only = false;  ///< leave the whole machine out
};

std::string solver_subject(const Settings& settings);
std::string reduction_subject(const Settings& settings);
std::string compensate_subject(const Settings& settings);
std::string online_subject(const Settings& settings);
std::string study_subject(const Settings& settings);

/// model.rom.h5 to be used: --model, or the one in the work folder, made if it is missing.
std::filesystem::path model_of(const Settings& settings);

}  // namespace thermotwin::bench
