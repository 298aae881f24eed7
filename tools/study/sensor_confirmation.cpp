// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/study/sensor_confirmation.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "compensation/evaluation/validation.h"
#include "core/error.h"
#include "mesh/machine_mesh.h"
#include "study/placement/placed_model.h"

namespace thermotwin::tools {

namespace {

using compensation::ValidationRow;

/// In the directions that axes move. @param load  empty: all  @param left  what is left with sensors or without
double rms_left(const std::vector<ValidationRow>& rows, int draw, const std::string& load = "",
                double ValidationRow::*left = &ValidationRow::rms_sensors_um) {
  double sum = 0.0;
  int count = 0;
  for (const ValidationRow& row : rows) {
    if (row.draw != draw || (!load.empty() && row.load != load)) continue;
    sum += row.*left * row.*left - row.rms_unmoved_um * row.rms_unmoved_um;
    ++count;
  }
  return std::sqrt(std::max(0.0, sum) / std::max(count, 1));
}

std::vector<ConfirmedLoad> by_load(const std::vector<ValidationRow>& own, const std::vector<ValidationRow>& chosen,
                                   const std::vector<std::string>& loads, int draws) {
  const auto median = [&](const std::vector<ValidationRow>& rows, const std::string& load,
                          double ValidationRow::*left) {
    std::vector<double> each;
    for (int draw = 0; draw < draws; ++draw) each.push_back(rms_left(rows, draw, load, left));
    return core::median(each);
  };
  std::vector<ConfirmedLoad> found;
  for (const std::string& load : loads) {
    found.push_back({load, median(own, load, &ValidationRow::rms_model_um),
                     median(own, load, &ValidationRow::rms_sensors_um),
                     median(chosen, load, &ValidationRow::rms_sensors_um)});
  }
  return found;
}

/// The chosen sensors with names of their own, so that a machine can have them beside the case's.
solver::Case renamed(solver::Case placed, const mesh::Machine& own, Eigen::Index chosen) {
  for (Eigen::Index s = 0; s < chosen; ++s) {
    std::string& id = placed.machine.sensors[s].id;
    do {
      id = "chosen_" + id;
    } while (own.sensor_index(id) >= 0);
  }
  return placed;
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
  const solver::Case others = renamed(placed, machine_case.machine, rows.rows());
  std::vector<mesh::SensorSpec> sensors = machine_case.machine.sensors;
  sensors.insert(sensors.end(), others.machine.sensors.begin(), others.machine.sensors.begin() + rows.rows());
  const solver::Case both = study::placed_case(machine_case, sensors);
  const reduction::ReducedModel other_model = study::placed_model(model, others.machine, rows);

  compensation::ValidationOptions settings;
  settings.loads = options.loads;
  settings.draws = options.confirm;
  settings.machine.what = compensation::Perturb::thermal;
  settings.machine.probe_noise_um = 0.0;  // it would count to what the compensator leaves
  // A mesh that is finer than the model's, whatever its size.
  settings.machine.size_factor *= std::min(1.0, mesh::size_factor(machine_case.machine, machine_case.size));
  settings.machine.mesh_cache = options.out / "cache";
  settings.keep = options.out / "study/sensors/measured";
  std::vector<ValidationRow> own, chosen;
  const auto judge = [&](int draw, const compensation::MeasuredLoad& load, const compensation::Measurement& measured) {
    const std::string& name = load.program.name();
    std::ranges::move(judge_compensation(measured, machine_case.machine, model, name, draw), std::back_inserter(own));
    std::ranges::move(judge_compensation(measured, others.machine, other_model, name, draw),
                      std::back_inserter(chosen));
  };
  const Eigen::Index measured = measure_each(both, validation_loads(both, settings), settings, judge);
  ConfirmedSensors on;
  for (int draw = 0; draw < options.confirm; ++draw) {
    on.own.push_back(rms_left(own, draw));
    on.chosen.push_back(rms_left(chosen, draw));
  }
  on.loads = by_load(own, chosen, options.loads, options.confirm);
  on.own_mesh = measured == nodes;
  return on;
}

}  // namespace thermotwin::tools
