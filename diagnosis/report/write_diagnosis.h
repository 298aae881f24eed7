// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The files of a diagnosis, each whole or not at all.

#include <filesystem>
#include <vector>

#include "core/html_page.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/report/scene.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::diagnosis {

/// diagnosis.json, report.html, residuals.csv, extended/machine.toml (and extended/model.rom.h5),
/// each whole or not at all. @param scene  of the machine, for the page; may be empty
/// @param steps  commands that may follow, for the page
void write_diagnosis(const std::filesystem::path& out, const Diagnosis& diagnosis, const reduction::ReducedModel& model,
                     const Scene& scene = {}, const std::vector<core::NextStep>& steps = {});

/// The same files of data without a machine, which are never extended.
void write_diagnosis(const std::filesystem::path& out, const Diagnosis& diagnosis,
                     const std::vector<core::NextStep>& steps = {});

}  // namespace thermotwin::diagnosis
