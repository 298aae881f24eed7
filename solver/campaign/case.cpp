// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/config.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/text.h"
#include "core/units.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/case_keys.h"

namespace thermotwin::solver {

std::vector<std::string> Case::load_names() const {
  std::vector<std::string> names;
  std::error_code ignored;  // no folder: no loads
  for (const auto& entry : std::filesystem::directory_iterator(folder / "loads", ignored))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

LoadProgram Case::load(const std::string& name) const {
  const std::vector<std::string> known = load_names();
  if (std::find(known.begin(), known.end(), name) == known.end()) {
    const std::string nearest = core::nearest(name, known);
    throw core::InputError(
        (folder / "loads").string(),
        "no load program '" + name + "'" + (nearest.empty() ? "" : "; did you mean '" + nearest + "'?"),
        known.empty() ? "files loads/<name>.toml, there are none" : core::join(known));
  }
  LoadProgram program = LoadProgram::read(folder / "loads" / (name + ".toml"), machine);
  if (time && !program.has_time()) program.set_time(*time);
  return program;
}

namespace {

/// A machine.toml in place of its case.
void refuse_machine(const core::Node& root, const std::filesystem::path& file, const std::filesystem::path& folder) {
  const std::vector<std::string> keys = root.keys();
  const auto has = [&](const char* key) { return std::find(keys.begin(), keys.end(), key) != keys.end(); };
  if (!has("body") && !has("material")) return;
  throw core::InputError(file.string(), "a machine.toml, not a case",
                         std::filesystem::exists(folder / "case.toml")
                             ? "the case's folder, " + folder.string()
                             : "a case: its folder with case.toml, which names machine.toml, and loads/*.toml");
}

/// A model is made at the poses of the grid: an error there says nothing about the interpolation between them.
void warn_of_grid_poses(const Case& read, const std::string& place) {
  const mesh::Workspace& workspace = read.machine.workspace;
  if (workspace.axes.empty() && workspace.table_axes.empty()) return;
  const auto stands_at = [&](const mesh::Pose& pose, const std::vector<std::string>& axes,
                             const std::vector<std::vector<double>>& positions) {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const double at = pose[read.machine.axis_index(axes[i])];
      if (std::none_of(positions[i].begin(), positions[i].end(), [&](double p) { return std::abs(p - at) < 1e-6; }))
        return false;
    }
    return true;
  };
  for (const mesh::Pose& pose : read.check_points) {
    if (!stands_at(pose, workspace.axes, workspace.positions) ||
        !stands_at(pose, workspace.table_axes, workspace.table_positions))
      continue;
    core::warn(
        fmt::format("{}: \"{}\" is a pose of the workspace grid, at which the model is made; allowed without "
                    "this warning: poses between the positions of [workspace]",
                    place, mesh::format_pose(read.machine, pose)));
  }
}

}  // namespace

Case read_case(const std::filesystem::path& path) {
  Case result;
  const std::filesystem::path file = std::filesystem::is_directory(path) ? path / "case.toml" : path;
  result.folder = std::filesystem::absolute(file).lexically_normal().parent_path();
  const core::Config config = core::Config::load(file, &case_keys());
  const core::Node root = config.root();
  refuse_machine(root, file, result.folder);
  root.schema(1);
  result.machine = mesh::read_machine(result.folder / root.text("machine"));
  result.size = root.text("size");
  result.train = root.texts_or_empty("train");
  result.holdout = root.texts_or_empty("holdout");
  if (root.has("measurement")) {
    result.measurement = result.folder / root.text("measurement");
    if (!std::filesystem::is_directory(result.measurement)) {
      throw core::InputError(root.place("measurement"), "no folder '" + root.text("measurement") + "'",
                             "a folder with channels.toml and data.csv");
    }
  }
  if (const auto reduction = root.table_if("reduction")) {
    result.tolerance_um = reduction->number("tolerance_um");
    reduction->finish();
  }
  if (const auto scheme = root.table_if("time")) result.time = read_time(*scheme);
  if (const auto points = root.table_if("check_points")) {
    for (const std::string& text : points->texts_or_empty("poses"))
      result.check_points.push_back(mesh::parse_pose(result.machine, text, points->place("poses")));
    warn_of_grid_poses(result, points->place("poses"));
    points->finish();
  }
  if (result.machine.axes.empty()) result.check_points.assign(1, mesh::Pose());  // the only pose there is
  if (const auto wrong = root.table_if("measured_machine")) {
    MeasuredMachine measured;
    measured.load = wrong->text("load");
    measured.kind = wrong->choice("kind");
    measured.where = wrong->text("where");
    measured.factor = wrong->number("factor");
    measured.seed = wrong->integer("seed");
    measured.size_factor = wrong->number("size_factor");
    measured.refine = wrong->number("refine");
    wrong->finish();
    result.measured_machine = measured;
  }
  root.finish();
  mesh::size_factor(result.machine, result.size);

  const std::vector<std::string> known = result.load_names();
  for (const auto& [key, names] : {std::pair{"train", &result.train}, std::pair{"holdout", &result.holdout}}) {
    for (const std::string& name : *names) {
      if (std::find(known.begin(), known.end(), name) == known.end()) {
        throw core::InputError(
            root.place(key), "load program '" + name + "'",
            known.empty() ? "files loads/<name>.toml, there are none" : "one of: " + core::join(known));
      }
    }
  }
  for (const std::string& name : result.holdout) {
    if (std::find(result.train.begin(), result.train.end(), name) != result.train.end()) {
      throw core::InputError(root.place("holdout"), "load program '" + name + "', which also trains",
                             "programs that the training does not see");
    }
  }
  return result;
}

}  // namespace thermotwin::solver
