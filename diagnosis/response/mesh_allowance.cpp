// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/mesh_allowance.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace thermotwin::diagnosis {

namespace {

constexpr std::array<std::string_view, 6> quantities{"dx", "dy", "dz", "ra", "rb", "rc"};

}  // namespace

MeshAllowance::MeshAllowance(const mesh::Machine& machine, const std::optional<reduction::MeshError>& estimate,
                             const DiagnoseOptions& options)
    : machine_(machine),
      estimate_(estimate),
      displacement_(0.01 * options.displacement_error_percent.value_or(assumed_displacement_error_percent)),
      temperature_(0.01 * options.temperature_error_percent.value_or(assumed_temperature_error_percent)),
      given_displacement_(options.displacement_error_percent.has_value()),
      given_temperature_(options.temperature_error_percent.has_value()) {}

double MeshAllowance::of_sensor(const std::string& sensor) const {
  const int index = machine_.sensor_index(sensor);
  if (given_temperature_ || !estimate_ || index < 0 || index >= estimate_->sensors.size()) return temperature_;
  return std::max(least_temperature, estimate_->sensors[index]);
}

double MeshAllowance::of_displacement(const std::string& quantity) const {
  if (given_displacement_ || !estimate_) return displacement_;
  const auto at = std::find(quantities.begin(), quantities.end(), quantity);
  const double share = at == quantities.end() ? estimate_->tcp.maxCoeff() : estimate_->tcp[at - quantities.begin()];
  return std::max(least_displacement, share);
}

double MeshAllowance::of(const ObservedChannel& channel) const {
  return channel.is_temperature() ? of_sensor(channel.channel.sensor) : of_displacement(channel.channel.quantity);
}

double MeshAllowance::largest() const {
  double most = 0.0;
  for (const std::string_view quantity : quantities) most = std::max(most, of_displacement(std::string(quantity)));
  for (const mesh::SensorSpec& sensor : machine_.sensors) most = std::max(most, of_sensor(sensor.id));
  return most;
}

std::string MeshAllowance::sentence() const {
  const auto range = [](double low, double high) {
    return high - low < 5e-4 ? fmt::format("{:.2g} %", 100.0 * high)
                             : fmt::format("{:.2g} to {:.2g} %", 100.0 * low, 100.0 * high);
  };
  double low_K = temperature_, high_K = temperature_, low_um = displacement_, high_um = displacement_;
  if (estimate_ && !given_temperature_ && estimate_->sensors.size() > 0) {
    low_K = std::max(least_temperature, estimate_->sensors.minCoeff());
    high_K = std::max(least_temperature, estimate_->sensors.maxCoeff());
  }
  if (estimate_ && !given_displacement_) {
    low_um = std::max(least_displacement, estimate_->tcp.minCoeff());
    high_um = std::max(least_displacement, estimate_->tcp.maxCoeff());
  }
  const auto source = [&](bool given) {
    return given ? "stated" : estimate_ ? "from a second mesh" : "assumed, since the model file has no estimate";
  };
  return fmt::format(
      "Discretisation error: {} of each displacement's response ({}), {} of each temperature's ({}). An effect whose "
      "response has the form of the nominal response is hidden below these shares.",
      range(low_um, high_um), source(given_displacement_), range(low_K, high_K), source(given_temperature_));
}

}  // namespace thermotwin::diagnosis
