// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/observer_model.h"

#include <algorithm>
#include <iterator>

#include "compensation/online/drive_heats.h"
#include "solver/campaign/simulation.h"

namespace thermotwin::compensation {
namespace {

template <class Values>
std::int32_t count_of(const Values& values) {
  return static_cast<std::int32_t>(values.size());
}

std::vector<std::int32_t> heating_drives(const reduction::ReducedModel& model,
                                         const solver::OperatingModel& operating) {
  const std::vector<DriveHeat> all = drive_heats(model, operating, operating.channels().defaults());
  std::vector<std::int32_t> heating;
  for (std::int32_t d = 0; d < count_of(all); ++d) {
    if (all[d].channel >= 0 && all[d].heat.squaredNorm() > 0.0) heating.push_back(d);
  }
  return heating;
}

}  // namespace

ObserverModel::ObserverModel(const reduction::ReducedModel& model, const solver::OperatingModel& operating,
                             const CompensatorOptions& options, double rank_tolerance)
    : drives_(heating_drives(model, operating)),
      sensors_(model, count_of(drives_), rank_tolerance),
      day_(model.machine, operating.channels(), sensors_) {
  add_readings(model.machine, operating.channels());
  const Eigen::VectorXd offset = solver::sensor_offsets(model.machine, model.system.layout);
  offset_.assign(offset.begin(), offset.end());
  for (const mesh::AmbientSpec& ambient : model.machine.ambients)
    ambient_channel_.push_back(operating.channels().index(ambient.id + ".T_C"));
  data_.sensors = &sensors_.data();
  data_.readings = &readings_;
  data_.heats = tt_day_heats(&day_.data());
  data_.ambients = count_of(ambient_channel_);
  data_.air_channel = operating.channels().index("air.T_C");
  data_.ambient_channel = ambient_channel_.data();
  data_.sensor_offset = offset_.data();
  data_.step_s = options.step_s;
  data_.correction_s = options.correction_s;
  data_.start_from_sensors = options.start_from_sensors;
}

void ObserverModel::add_readings(const mesh::Machine& machine, const solver::Channels& channels) {
  const Eigen::VectorXd& defaults = channels.defaults();
  default_.assign(defaults.begin(), defaults.end());
  for (const mesh::AmbientSpec& ambient : machine.ambients) {
    if (ambient.follows.empty()) own_ambient_.push_back(channels.index(ambient.id + ".T_C"));
  }
  for (std::int32_t k = 0; k < count_of(default_); ++k) {
    if (!channels.names()[k].ends_with("T_C")) continue;
    temperature_.push_back(k);
    is_ambient_.push_back(std::find(own_ambient_.begin(), own_ambient_.end(), k) != own_ambient_.end() ? 1 : 0);
  }
  readings_.low_C = machine.plausible_low_C;
  readings_.high_C = machine.plausible_high_C;
  readings_.reference_C = machine.reference_C;
  readings_.channels = count_of(default_);
  readings_.sensors = count_of(machine.sensors);
  readings_.temperatures = count_of(temperature_);
  readings_.ambients = count_of(own_ambient_);
  readings_.temperature = temperature_.data();
  readings_.is_ambient = is_ambient_.data();
  readings_.ambient = own_ambient_.data();
  readings_.default_C = default_.data();
}

}  // namespace thermotwin::compensation
