// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/placement/placed_model.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/file.h"

namespace thermotwin::study {

using Eigen::Index;

std::vector<mesh::SensorSpec> placed_sensors(const mesh::Machine& machine, const std::vector<Place>& places) {
  std::vector<mesh::SensorSpec> guides;
  for (const mesh::SensorSpec& own : machine.sensors) {
    if (std::any_of(machine.coolants.begin(), machine.coolants.end(),
                    [&](const mesh::CoolantSpec& coolant) { return coolant.guide_sensor == own.id; }))
      guides.push_back(own);
  }
  std::vector<mesh::SensorSpec> sensors;
  int number = 0;
  for (const Place& place : places) {
    mesh::SensorSpec sensor;
    const auto taken = [&](const mesh::SensorSpec& guide) { return guide.id == sensor.id; };
    do {
      sensor.id = fmt::format("S{}", ++number);
    } while (std::any_of(guides.begin(), guides.end(), taken));
    sensor.body = machine.bodies[place.body].id;
    sensor.point = place.point;
    sensors.push_back(sensor);
  }
  sensors.insert(sensors.end(), guides.begin(), guides.end());
  return sensors;
}

solver::Case placed_case(const solver::Case& machine_case, const std::vector<mesh::SensorSpec>& sensors) {
  solver::Case placed = machine_case;
  placed.machine.sensors = sensors;
  std::string words = machine_case.machine.hash;
  for (const mesh::SensorSpec& sensor : sensors)
    words += fmt::format(" {} {} {:.9g} {:.9g} {:.9g}", sensor.id, sensor.body, sensor.point.x(), sensor.point.y(),
                         sensor.point.z());
  placed.machine.hash = core::content_hash(words);
  return placed;
}

reduction::ReducedModel placed_model(const reduction::ReducedModel& model, const mesh::Machine& placed,
                                     const Eigen::MatrixXd& rows) {
  reduction::ReducedModel made = model;
  const Index before = std::ssize(model.machine.sensors), now = std::ssize(placed.sensors);
  const Index observed = model.system.sensors.rows() - before;
  made.machine = placed;
  made.system.sensors.resize(now + observed, model.system.order());
  made.system.sensors.topRows(rows.rows()) = rows;
  for (Index s = rows.rows(); s < now; ++s)
    made.system.sensors.row(s) = model.system.sensors.row(model.machine.sensor_index(placed.sensors[s].id));
  made.system.sensors.bottomRows(observed) = model.system.sensors.bottomRows(observed);
  made.sensor_air.reset();
  if (made.mesh_error && made.mesh_error->sensors.size() > 0)
    made.mesh_error->sensors = Eigen::VectorXd::Constant(now, model.mesh_error->sensors.mean());
  return made;
}

}  // namespace thermotwin::study
