// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/study/sensor_confirmation.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "compensation/evaluation/validation.h"
#include "core/error.h"
#include "study/placement/placed_model.h"

namespace thermotwin::tools {

namespace {

/// In the directions that axes move.
double rms_left(const compensation::Validation& validation, int draw) {
  double sum = 0.0;
  int count = 0;
  for (const compensation::ValidationRow& row : validation.rows) {
    if (row.draw != draw) continue;
    sum += row.rms_sensors_um * row.rms_sensors_um - row.rms_unmoved_um * row.rms_unmoved_um;
    ++count;
  }
  return std::sqrt(std::max(0.0, sum) / std::max(count, 1));
}

/// @param nodes  receives those of the machines' mesh
std::vector<double> left_on_machines(const StudySensorsOptions& options, const solver::Case& machine_case,
                                     const reduction::ReducedModel& model, const std::string& name,
                                     Eigen::Index& nodes) {
  compensation::ValidationOptions settings;
  settings.loads = options.loads;
  settings.draws = options.confirm;
  settings.machine.what = compensation::Perturb::thermal;
  settings.machine.probe_noise_um = 0.0;  // it would count to what the compensator leaves
  settings.machine.mesh_cache = options.out / "cache";
  settings.keep = options.out / "study/sensors/measured" / name;
  const compensation::Validation validation = compensation::validate_online(machine_case, model, settings);
  nodes = validation.measured_nodes;
  std::vector<double> left;
  for (int draw = 0; draw < options.confirm; ++draw) left.push_back(rms_left(validation, draw));
  return left;
}

}  // namespace

bool has_linear_axis(const mesh::Machine& machine) {
  return std::any_of(machine.axes.begin(), machine.axes.end(),
                     [](const mesh::Axis& axis) { return axis.kind == mesh::AxisKind::linear; });
}

void require_confirmable(const solver::Case& machine_case) {
  if (machine_case.check_points.empty()) {
    throw core::InputError((machine_case.folder / "case.toml").string(), "no check points, which --confirm compares at",
                           "[check_points] with poses, or no --confirm");
  }
  if (!has_linear_axis(machine_case.machine)) {
    throw core::InputError(machine_case.machine.path.string(), "no linear axis, whose offsets --confirm judges",
                           "a machine with a linear axis, or no --confirm");
  }
}

ConfirmedSensors confirmed_sensors(const StudySensorsOptions& options, const solver::Case& machine_case,
                                   const solver::Case& placed, const reduction::ReducedModel& model,
                                   const Eigen::MatrixXd& rows, Eigen::Index nodes) {
  ConfirmedSensors on;
  Eigen::Index measured = 0;
  on.own = left_on_machines(options, machine_case, model, "own", measured);
  on.chosen = left_on_machines(options, placed, study::placed_model(model, placed.machine, rows), "chosen", measured);
  on.own_mesh = measured == nodes;
  return on;
}

}  // namespace thermotwin::tools
