// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/observer_arrays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "compensation/online/drive_heats.h"
#include "compensation/online/uncertain_quantities.h"
#include "core/units.h"
#include "reduction/model/output_grid.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;

constexpr double half = 0.5;
constexpr double warmer_K = 2.0;  ///< surroundings than the hall, over a day

void append(std::vector<std::int32_t>& first, std::vector<std::int32_t>& items, const std::vector<int>& more) {
  items.insert(items.end(), more.begin(), more.end());
  first.push_back(std::ssize(items));
}

void add_quantities(const reduction::ReducedModel& model, ControlData& data) {
  data.quantity_term_first = data.quantity_input_first = data.quantity_warm_first = {0};
  data.air_quantity = -1;
  for (const UncertainQuantity& quantity : uncertain_quantities(model)) {
    data.quantity_std.push_back(quantity.std);
    data.quantity_memory.push_back(quantity.memory);
    data.quantity_ambient.push_back(quantity.ambient);
    append(data.quantity_term_first, data.quantity_term, quantity.terms);
    append(data.quantity_input_first, data.quantity_input, quantity.inputs);
    append(data.quantity_warm_first, data.quantity_warm, quantity.ambient_inputs);
    if (quantity.ambient >= 0) {
      data.warm_quantity.push_back(data.quantities);
      data.warm_K.push_back(warmer_K);
      if (model.machine.ambients[quantity.ambient].id == "air") data.air_quantity = data.quantities;
    }
    ++data.quantities;
  }
  data.warm = std::ssize(data.warm_quantity);
}

void add_drives(const reduction::ReducedModel& model, const solver::OperatingModel& operating, ControlData& data) {
  for (const DriveHeat& drive : drive_heats(model, operating, operating.channels().defaults())) {
    if (drive.channel >= 0 && drive.heat.squaredNorm() > 0.0) data.heating_drive.push_back(data.day_drives);
    data.drive_channel.push_back(drive.channel);
    data.drive_half_speed.push_back(drive.half_speed);
    ++data.day_drives;
  }
  data.heating = std::ssize(data.heating_drive);
  for (const mesh::Axis& axis : model.machine.axes) {
    const double to_unit = axis.kind == mesh::AxisKind::linear ? 1e3 : 180.0 / std::numbers::pi;
    data.day_low.push_back(axis.low * to_unit);
    data.day_high.push_back(axis.high * to_unit);
  }
}

/// Channels that may leap: speeds, feeds, powers, states.
bool leaps(const std::string& name) {
  constexpr std::array<const char*, 5> endings = {"_rpm", "_min", ".power_W", ".on", ".open"};
  return std::any_of(endings.begin(), endings.end(), [&](const char* ending) { return name.ends_with(ending); });
}

void add_channels(const solver::Channels& channels, ControlData& data) {
  for (std::int32_t k = 0; k < data.channels; ++k) {
    if (leaps(channels.names()[k])) data.leaping_channel.push_back(k);
  }
  data.leaping = std::ssize(data.leaping_channel);
  for (int i = 0; i < data.ambients; ++i) {
    const int channel = data.ambient_channel[i];
    if (data.ambient_follows[i] < 0 && channel >= 0) data.own_ambient.push_back(channel);
  }
  data.own_ambients = std::ssize(data.own_ambient);
  data.air_channel = channels.index("air.T_C");
  data.fluid_on = channels.index("cutting_fluid.on");
}

/// The workspace grid, on which deviations are computed (output_map.h).
void add_grid(const reduction::ReducedModel& model, const OutputMap& map, ControlData& data) {
  const reduction::OutputGrid grid(model.machine, model.outputs.tool.size());
  const std::vector<std::size_t>& places = grid.table_grid_places();
  data.grid_poses = grid.grid_count();
  data.grid_tables = std::ssize(places);
  data.grid_table.assign(places.begin(), places.end());
  data.grid_table_first = {0};
  std::size_t stride = grid.table_count();
  for (const reduction::OutputGrid::GridAxis& axis : grid.stored_table_axes()) {
    const std::size_t count = axis.positions.size();
    stride /= count;
    std::vector<std::size_t> own;
    for (const std::size_t place : places) {
      const std::size_t at = place / stride % count;
      if (std::find(own.begin(), own.end(), at) == own.end()) own.push_back(at);
    }
    for (const std::size_t at : own) data.grid_table_positions.push_back(axis.positions[at]);
    data.grid_table_first.push_back(std::ssize(data.grid_table_positions));
  }
  const std::vector<mesh::Pose>& poses = map.workspace_poses();
  data.grid_angles = std::ssize(poses) / (data.grid_poses * data.grid_tables);
  for (const mesh::Pose& pose : poses) data.grid_pose.insert(data.grid_pose.end(), pose.begin(), pose.end());
}

}  // namespace

void fill_observer(const reduction::ReducedModel& model, const solver::OperatingModel& operating, const OutputMap& map,
                   const CompensatorOptions& options, ControlData& data) {
  data.observer = 1;
  data.start_from_sensors = options.start_from_sensors ? 1 : 0;
  for (const reduction::ReductionErrors& error : model.errors)
    data.model_error = std::max(data.model_error, error.rms_um * core::units::um);
  for (const mesh::SensorSpec& sensor : model.machine.sensors) data.sensor_std.push_back(sensor.uncertainty);
  add_quantities(model, data);
  add_drives(model, operating, data);
  add_channels(operating.channels(), data);
  add_grid(model, map, data);
}

}  // namespace thermotwin::compensation
