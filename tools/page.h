// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// report.html of a verb: written whole or not at all, never a reason for the verb to fail.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "compensation/evaluation/validation.h"
#include "core/html_page.h"
#include "diagnosis/judge/diagnosis.h"
#include "solver/campaign/full_model.h"
#include "solver/export/machine_scene.h"
#include "solver/operation/load_program.h"

namespace thermotwin::tools {

/// Writes what `make` returns; where that fails, a warning says why and no page is left.
void write_page(const std::filesystem::path& file, const std::function<std::string()>& make);

/// Options of mesh and solver as they were given, each after a blank, for a command that goes on.
std::string mesh_words(const std::string& size, int mesh_order, const std::string& solver = "auto");

/// What may follow a diagnosis. @param folder, model  empty: none was given  @param data  one or more records
std::vector<core::NextStep> steps_after(const diagnosis::Diagnosis& diagnosed, const std::filesystem::path& folder,
                                        const std::vector<std::filesystem::path>& data,
                                        const std::filesystem::path& model, const std::filesystem::path& out);

/// Tables as sections of a page.
std::string mesh_section(const solver::FullModel& full);
std::string loads_section(const std::vector<solver::LoadProgram>& loads, const solver::MachineScene& scene);

/// Errors over time at the check points of each traced machine and load, chosen by a list.
std::string traces_section(const std::vector<compensation::ValidationTrace>& traces);

}  // namespace thermotwin::tools
