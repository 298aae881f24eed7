// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/virtual_measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "compensation/measurement/channel.h"
#include "core/normal_draws.h"
#include "core/range.h"
#include "core/units.h"
#include "mesh/machine/flow_network.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;

/// Builds a measurement column by column.
class Builder {
public:
  explicit Builder(const core::Table& sensors) {
    rows_ = sensors.rows();
    add_column("time_s", sensors.values.col(0));
  }

  void add(MeasuredChannel channel, const Eigen::VectorXd& values) {
    channel.column = std::ssize(columns_);
    add_column(channel.id, values);
    measurement_.channels.push_back(std::move(channel));
  }

  Measurement finish(const std::string& source) {
    measurement_.data.source = source;
    measurement_.data.values.resize(rows_, std::ssize(columns_));
    for (std::size_t i = 0; i < columns_.size(); ++i) measurement_.data.values.col(i) = columns_[i];
    return std::move(measurement_);
  }

private:
  void add_column(const std::string& name, const Eigen::VectorXd& values) {
    measurement_.data.columns.push_back(name);
    columns_.push_back(values);
  }

  Index rows_ = 0;
  std::vector<Eigen::VectorXd> columns_;
  Measurement measurement_;
};

void describe_input(const std::string& name, MeasuredChannel& channel) {
  const Channel input = channel_named(name);
  channel.id = channel.input = name;
  channel.kind = input.kind;
  channel.unit = input.unit;
}

/// What a control sends: of a coolant what the load gives.
bool is_sent(const std::string& name, const mesh::Machine& machine, const Eigen::VectorXd& values) {
  for (const mesh::AmbientSpec& ambient : machine.ambients) {
    if (name == ambient.id + ".T_C") return is_told(ambient);
  }
  return values.array().isFinite().any();
}

}  // namespace

bool is_told(const mesh::AmbientSpec& ambient) { return ambient.id == "air"; }

mesh::Machine perturbed(const mesh::Machine& machine, std::uint64_t seed, double scale, Perturb what) {
  core::NormalDraws normal(seed);
  mesh::Machine result = machine;
  // One draw for each nominal, uncertain or not: a changed uncertainty leaves the others alone.
  const auto perturb_by = [&](core::Uncertain& nominal, double share) {
    const double factor = 1.0 + share * nominal.std_percent / 100.0 * std::clamp(normal(), -farthest_std, farthest_std);
    nominal.value *= std::max(0.2, factor);
  };
  if (what == Perturb::none) scale = 0.0;
  const double other = what == Perturb::all ? scale : 0.0;
  const auto perturb = [&](core::Uncertain& nominal) { perturb_by(nominal, other); };
  const auto perturb_thermal = [&](core::Uncertain& nominal) { perturb_by(nominal, scale); };
  for (mesh::Material& material : result.materials) {
    perturb(material.specific_heat);
    perturb(material.expansion);
  }
  for (mesh::JointSpec& joint : result.joints) {
    perturb_thermal(joint.conductance);
    perturb(joint.stiffness_normal);
    perturb(joint.stiffness_tangential);
  }
  for (mesh::ScaleSpec& tape : result.scales) perturb(tape.expansion);
  for (mesh::ScrewSpec& screw : result.screws) perturb(screw.expansion);
  for (mesh::FilmSpec& film : result.films) perturb_thermal(film.coefficient);
  for (mesh::AmbientSpec& ambient : result.ambients) {
    // A temperature scale has no natural zero in degC: its spread is that of the stated value, but
    // it may fall below any share of it.
    ambient.default_C.value *= 1.0 + other * ambient.default_C.std_percent / 100.0 * normal();
  }
  for (mesh::CoolantSpec& coolant : result.coolants) {
    perturb(coolant.flow);
    for (mesh::CoolantSegment& segment : coolant.segments) perturb_thermal(segment.film_coefficient);
  }
  for (mesh::SourceSpec& source : result.sources) perturb_thermal(source.scale);
  for (mesh::VolumeSpec& volume : result.volumes) {
    perturb(volume.capacity);
    for (mesh::VolumeExchange& exchange : volume.exchanges) perturb_thermal(exchange.conductance);
  }
  for (mesh::FilmSpec& film : result.films) {
    perturb_thermal(film.emissivity);
    film.emissivity.value = std::min(film.emissivity.value, 1.0);
  }
  for (mesh::JointSpec& joint : result.joints) perturb_thermal(joint.law.pressure);
  for (mesh::AmbientSpec& ambient : result.ambients) perturb_thermal(ambient.gradient);
  return result;
}

void VirtualOptions::validate() const {
  for (const auto& [name, value] : {std::pair{"size_factor", size_factor}, {"refine", refine}})
    core::require_option(value > 0.0, std::string("virtual measurement ") + name, value, "a number above 0");
  for (const auto& [name, value] : {std::pair{"sensor_noise_K", sensor_noise_K}, {"probe_noise_um", probe_noise_um}})
    core::require_option(value >= 0.0, std::string("virtual measurement ") + name, value, "0 or more");
}

Measurement measure_virtually(const solver::FullModel& perturbed_machine, const solver::LoadProgram& load,
                              const std::vector<mesh::Pose>& poses, const VirtualOptions& options) {
  options.validate();
  const mesh::Machine& machine = perturbed_machine.mesh.machine;
  solver::CampaignOptions campaign;
  campaign.poses = poses.empty() ? std::vector<mesh::Pose>{mesh::home_pose(machine)} : poses;
  campaign.refine = options.refine;
  campaign.time = options.time;
  campaign.checkpoints = options.checkpoints;
  campaign.checkpoint_s = options.checkpoint_s;
  campaign.resume = !options.checkpoints.empty();
  return measure_run(solver::run_campaign(perturbed_machine, {load}, campaign).front(), machine, campaign.poses,
                     options);
}

namespace {

/// A clock shows the time of its row, and not the mean since the row before. @param means  (rows) h
Eigen::VectorXd at_rows(const Eigen::VectorXd& time, const Eigen::VectorXd& means) {
  Eigen::VectorXd hours = means;
  for (Index i = 1; i < hours.size(); ++i) hours[i] += 0.5 * (time[i] - time[i - 1]) / core::units::hour;
  if (hours.size() > 1) hours[0] = hours[1] - (time[1] - time[0]) / core::units::hour;
  return hours;
}

/// (rows) K, outflow less inflow of a segment: the heat of its walls over its flow times specific heat. 0 while the
/// circuit is off and before the first output.
Eigen::VectorXd rise_of(const solver::LoadResult& truth, const mesh::CoolantSpec& coolant, std::size_t segment,
                        double share) {
  const Eigen::VectorXd power =
      truth.heat_flows.column(fmt::format("coolant.{}.{}.cooling_power_W", coolant.id, coolant.segments[segment].id));
  const Eigen::VectorXd on = truth.inputs.column("coolant." + coolant.id + ".on");
  constexpr double least_share = 0.01;  // of the flow
  Eigen::VectorXd rise = Eigen::VectorXd::Zero(power.size());
  for (Index i = 0; i < rise.size(); ++i) {
    if (std::isfinite(power[i]) && on[i] > least_share)
      rise[i] = power[i] / (on[i] * coolant.flow.value * share * coolant.specific_heat);
  }
  return rise;
}

void add_rises(const solver::LoadResult& truth, const mesh::Machine& machine, const VirtualOptions& options,
               core::NormalDraws& normal, Builder& builder) {
  const double noise_K = std::numbers::sqrt2 * options.sensor_noise_K;  // of two sensors
  for (const mesh::CoolantSpec& coolant : machine.coolants) {
    const mesh::FlowNetwork network = mesh::flow_network(coolant, machine.path.string() + " coolant " + coolant.id);
    for (std::size_t s = 0; s < coolant.segments.size(); ++s) {
      MeasuredChannel channel;
      channel.id = fmt::format("coolant.{}.{}.rise", coolant.id, coolant.segments[s].id);
      channel.kind = ChannelKind::temperature;
      channel.unit = "degC";
      channel.uncertainty = std::max(noise_K, 1e-3);
      Eigen::VectorXd values = rise_of(truth, coolant, s, network.share[s]);
      for (double& value : values) value += noise_K * normal();
      builder.add(channel, values);
    }
  }
}

}  // namespace

Measurement measure_run(const solver::LoadResult& truth, const mesh::Machine& machine,
                        const std::vector<mesh::Pose>& poses, const VirtualOptions& options) {
  options.validate();
  core::NormalDraws normal(options.seed);
  const Index times = truth.sensors.rows();
  Builder builder(truth.sensors);
  const solver::Channels channels(machine);
  for (const std::string& name : channels.names()) {
    if (!is_sent(name, machine, truth.inputs.column(name))) continue;
    const Eigen::VectorXd values = truth.inputs.column(name);
    // The campaign's row i is the mean since output i - 1; a measurement's row holds until the next.
    Eigen::VectorXd held(times);
    for (Index i = 0; i < times; ++i) held[i] = values[std::min(i + 1, times - 1)];
    if (name == mesh::time_of_day) held = at_rows(truth.sensors.values.col(0), values);
    MeasuredChannel channel;
    describe_input(name, channel);
    if (channel.kind == ChannelKind::temperature) {
      channel.uncertainty = std::max(options.sensor_noise_K, 1e-3);  // the control reads the air from a sensor too
      for (double& value : held) value += options.sensor_noise_K * normal();
    }
    builder.add(channel, held);
  }
  for (const mesh::SensorSpec& sensor : machine.sensors) {
    MeasuredChannel channel;
    channel.id = channel.sensor = sensor.id;
    channel.kind = ChannelKind::temperature;
    channel.unit = "degC";
    channel.uncertainty = std::max(options.sensor_noise_K, 1e-3);
    Eigen::VectorXd values = truth.sensors.column(sensor.id + "_C");
    for (double& value : values) value += options.sensor_noise_K * normal();
    builder.add(channel, values);
  }
  static constexpr const char* quantities[] = {"dx", "dy", "dz"};
  const Index count = std::ssize(poses);
  for (Index p = 0; p < count; ++p) {
    for (const char* quantity : quantities) {
      MeasuredChannel channel;
      channel.id = fmt::format("{}@{}", quantity, p + 1);
      channel.kind = ChannelKind::displacement;
      channel.unit = "um";
      channel.uncertainty = std::max(options.probe_noise_um, 1e-3);
      channel.quantity = quantity;
      channel.pose_text = mesh::format_pose(machine, poses[p]);
      const Eigen::VectorXd all = truth.tcp.column(std::string(quantity) + "_um");
      Eigen::VectorXd values(times);
      for (Index i = 0; i < times; ++i) values[i] = all[i * count + p] + options.probe_noise_um * normal();
      builder.add(channel, values);
    }
  }
  if (options.coolant_rise && truth.heat_flows.rows() == times) add_rises(truth, machine, options, normal, builder);
  Measurement measurement = builder.finish("virtual measurement of " + truth.load);
  measurement.machine = machine.name;
  return measurement;
}

}  // namespace thermotwin::compensation
