// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/measured_model.h"

#include <algorithm>
#include <iostream>

#include "compensation/measurement/measurement_check.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/text.h"
#include "diagnosis/judge/diagnosis.h"
#include "solver/campaign/case.h"
#include "tools/chain.h"

namespace thermotwin::tools {

namespace {

std::string evaluate_instead(const std::filesystem::path& data) {
  return "; for data without a machine model, leave out CASE and --model: thermotwin evaluate --data " + data.string() +
         " or thermotwin diagnose --data " + data.string();
}

}  // namespace

void require_measured_on(const mesh::Machine& machine, compensation::Measurement& measurement) {
  const bool names_machine =
      std::any_of(measurement.channels.begin(), measurement.channels.end(),
                  [](const auto& channel) { return !channel.quantity.empty() || !channel.input.empty(); });
  try {
    keep_plausible(measurement, machine.plausible_range());
    compensation::require_fits(measurement, machine);
  } catch (const core::InputError& error) {
    if (names_machine) throw;
    throw core::InputError(std::string(error.what()) + evaluate_instead(measurement.folder));
  }
}

void keep_plausible(compensation::Measurement& measurement, const mesh::PlausibleRange& range) {
  for (const std::string& blanked : compensation::blank_implausible(measurement, range)) core::warn(blanked);
}

namespace {

/// Without points a location error is predicted from what its axis carries; a test against the tool has the tool's
/// motion in it too.
void warn_of_location_errors(const compensation::Measurement& measurement) {
  std::vector<std::string> names;
  for (const auto& channel : measurement.channels)
    if (channel.quantity.size() == 3 && channel.quantity[1] == '0' && channel.points.empty())
      names.push_back(channel.id);
  if (names.empty()) return;
  core::warn(
      "location errors " + core::join(names) +
      " state no points of a test and are predicted from what their axis carries alone. A test between tool and table "
      "has the tool's motion in them: a diagnosis may name a wrong cause. measure analyse writes the points as "
      "[[arrangement]]");
}

}  // namespace

reduction::ReducedModel model_of(compensation::Measurement& measurement, const std::filesystem::path& case_path,
                                 const std::filesystem::path& model, const std::filesystem::path& out) {
  if (model.empty()) require_measured_on(open_case(case_path, "", 0).machine, measurement);
  reduction::ReducedModel made = model_for(case_path, model, out);
  require_measured_on(made.machine, measurement);
  warn_of_location_errors(measurement);
  return made;
}

diagnosis::Scene scene_of(const mesh::Machine& machine, const diagnosis::Diagnosis& found,
                          const std::filesystem::path& cache) {
  try {
    const mesh::MachineMesh mesh = mesh::build_machine_mesh(machine, {mesh::size_factor(machine, "coarse"), cache});
    return diagnosis::make_scene(mesh, diagnosis::marked_causes(found));
  } catch (const core::InputError& error) {
    std::cerr << "report.html shows no machine: " << error.what() << "\n";
    return {};
  }
}

std::vector<solver::LoadProgram> programs_of(const solver::Case& machine_case, const mesh::Machine& machine) {
  std::vector<solver::LoadProgram> programs;
  for (const auto* names : {&machine_case.train, &machine_case.holdout}) {
    for (const std::string& name : *names)
      programs.push_back(solver::LoadProgram::read(machine_case.folder / "loads" / (name + ".toml"), machine));
  }
  return programs;
}

}  // namespace thermotwin::tools
