// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "core/config.h"
#include "core/error.h"
#include "core/text.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "solver/export/calculix_deck.h"
#include "solver/export/matrix_export.h"
#include "tools/chain.h"
#include "tools/options.h"

namespace thermotwin::tools {

namespace {

/// A case, or a machine with the loads/ beside it.
solver::Case open_machine(const ExportOptions& options) {
  std::filesystem::path path = options.model;
  if (std::filesystem::is_directory(path))
    path /= std::filesystem::exists(path / "case.toml") ? "case.toml" : "machine.toml";
  if (!core::Config::load(path).root().has("kinematic_chain") && !core::Config::load(path).root().has("body"))
    return open_case(path, options.size, options.mesh_order, Asked::heat);
  solver::Case found;
  found.machine = mesh::read_machine(path);
  found.folder = std::filesystem::absolute(path).lexically_normal().parent_path();
  if (options.mesh_order > 0) found.machine.order = options.mesh_order;
  if (!options.size.empty()) found.size = options.size;
  mesh::size_factor(found.machine, found.size);
  return found;
}

}  // namespace

namespace {

void export_matrices(const ExportOptions& options, const solver::Case& machine_case) {
  const mesh::Machine& machine = machine_case.machine;
  const mesh::Pose pose =
      options.pose.empty() ? mesh::home_pose(machine) : mesh::parse_pose(machine, options.pose, "--pose");
  require_writable(options.out);
  const solver::FullModel full = build(machine_case, options.out);
  const std::filesystem::path folder = options.out / "matrices";
  const solver::MatrixFiles made = solver::write_matrices(folder, full, pose);
  std::string text = fmt::format(
      "{}: {} states, {} parameters (films), {} inputs, {} outputs; names.toml describes them\n", machine.name,
      made.size, made.names.films.size(), made.names.inputs.size(), made.names.outputs.size());
  for (const std::string& note : made.notes) text += "- " + note + "\n";
  text += fmt::format("{} files in {}; next: thermotwin reduce --matrices {}\n", made.files.size(), folder.string(),
                      folder.string());
  const nlohmann::json json = {{"folder", folder.string()},
                               {"files", made.files},
                               {"states", made.size},
                               {"films", made.names.films.size()},
                               {"inputs", made.names.inputs.size()},
                               {"outputs", made.names.outputs.size()},
                               {"notes", made.notes}};
  print_summary(options, text, json.dump());
}

}  // namespace

void export_model(const ExportOptions& options) {
  if (options.calculix == options.matrices)
    throw core::UsageError("export needs exactly one of --calculix, --matrices, --c, --fmu and --linuxcnc");
  const solver::Case machine_case = open_machine(options);
  if (options.matrices) return export_matrices(options, machine_case);
  const mesh::Machine& machine = machine_case.machine;
  solver::DeckOptions deck;
  if (!options.pose.empty()) deck.pose = mesh::parse_pose(machine, options.pose, "--pose");
  std::optional<solver::LoadProgram> program;
  if (!options.load.empty()) {
    program = machine_case.load(options.load);
    deck.program = &*program;
    deck.steady_at = options.steady_at_s;
    if (options.time_step_s > 0.0) deck.refine = options.time_step_s / program->longest_step();
  }
  deck.body = options.body;
  deck.heat_only = options.heat_only;
  require_writable(options.out);
  const mesh::MachineMesh meshed =
      mesh::build_machine_mesh(machine, {mesh::size_factor(machine, machine_case.size), options.out / "cache"});
  const std::filesystem::path folder = options.out / "calculix";
  const solver::DeckSummary summary = solver::write_calculix_deck(folder, meshed, deck);

  std::string text = fmt::format(
      "{}: {} nodes, {} tetrahedra {}, {}\n", options.body.empty() ? machine.name : machine.name + " " + options.body,
      summary.nodes, summary.elements, machine.order == 2 ? "C3D10" : "C3D4",
      summary.end > 0.0
          ? fmt::format("{} increments in {} steps to {:g} s", summary.increments, summary.steps, summary.end)
          : std::string("steady state"));
  text += "Differences from thermotwin:\n";
  for (const std::string& note : summary.notes) text += "- " + note + "\n";
  text += fmt::format(
      "{} in {}; next: cd {} && ccx heat{}\n", core::join(summary.files), folder.string(), folder.string(),
      std::find(summary.files.begin(), summary.files.end(), "static.inp") == summary.files.end() ? ""
                                                                                                 : " && ccx static");
  const nlohmann::json json = {{"folder", folder.string()},        {"files", summary.files}, {"nodes", summary.nodes},
                               {"elements", summary.elements},     {"order", machine.order}, {"steps", summary.steps},
                               {"increments", summary.increments}, {"end_s", summary.end},   {"notes", summary.notes}};
  print_summary(options, text, json.dump());
}

}  // namespace thermotwin::tools
