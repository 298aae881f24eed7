// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/machine_arrays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <variant>

#include "compensation/online/input_limits.h"
#include "core/units.h"
#include "solver/campaign/simulation.h"
#include "solver/elastic/outputs.h"
#include "solver/operation/film_laws.h"

namespace thermotwin::compensation {
namespace {

namespace units = core::units;

class MachineArrays {
public:
  MachineArrays(const mesh::Machine& machine, const solver::Layout& layout, const solver::Channels& channels,
                ControlData& data)
      : machine_(machine),
        layout_(layout),
        channels_(channels),
        data_(data),
        reference_K_(machine.reference_C + units::zero_C_in_K) {}

  void fill() {
    data_.curve_first = {0};
    data_.source_law_first = data_.source_loss_first = data_.joint_grid_first = data_.chain_first = {0};
    add_channels();
    add_axes();
    add_ambients();
    for (int i = 0; i < std::ssize(machine_.films); ++i) add_film(i);
    for (int j = 0; j < std::ssize(machine_.joints); ++j) add_joint(j);
    for (int i = 0; i < std::ssize(machine_.coolants); ++i) add_coolant(i);
    for (const mesh::SourceSpec& source : machine_.sources) add_source(source);
    for (const solver::Term& term : layout_.terms) add_term(term);
    for (const solver::Input& input : layout_.inputs) add_input(input);
    add_chains();
  }

private:
  int channel(const std::string& name) const { return name.empty() ? -1 : channels_.index(name); }

  int curve(const std::vector<double>& at, const std::vector<double>& value) {
    if (at.empty()) return -1;
    data_.curve_at.insert(data_.curve_at.end(), at.begin(), at.end());
    data_.curve_value.insert(data_.curve_value.end(), value.begin(), value.end());
    data_.curve_first.push_back(std::ssize(data_.curve_at));
    return std::ssize(data_.curve_first) - 2;
  }

  int ambient(const std::string& id) const { return id.empty() ? -1 : machine_.ambient_index(id); }
  int reading(solver::ObservedKind kind, int item) const {
    return solver::reading_index(machine_, layout_, kind, item);
  }

  void add_channels() {
    data_.channels = channels_.size();
    data_.channel_names = channels_.names();
    data_.machine_on = channels_.index("machine.on");
    const Eigen::VectorXd& defaults = channels_.defaults();
    data_.channel_default.assign(defaults.begin(), defaults.end());
    const std::vector<InputLimits> limits = input_limits(machine_, channels_);
    for (int k = 0; k < data_.channels; ++k) {
      const std::string& name = channels_.names()[k];
      data_.channel_low.push_back(limits[k].low - limits[k].slack);
      data_.channel_high.push_back(limits[k].high + limits[k].slack);
      data_.channel_state.push_back(name.ends_with(".on") || name.ends_with(".open"));
      data_.channel_temperature.push_back(name.ends_with("T_C"));
      const bool own = std::any_of(machine_.ambients.begin(), machine_.ambients.end(),
                                   [&](const auto& spec) { return spec.follows.empty() && name == spec.id + ".T_C"; });
      data_.channel_ambient.push_back(own);
    }
  }

  void add_axes() {
    data_.axes = std::ssize(machine_.axes);
    for (int a = 0; a < data_.axes; ++a) {
      const mesh::Axis& axis = machine_.axes[a];
      const solver::AxisChannels& of_axis = channels_.of_axis(a);
      data_.axis_names.push_back(axis.id);
      data_.axis_position.push_back(of_axis.position);
      data_.axis_feed.push_back(of_axis.feed);
      data_.axis_low.push_back(of_axis.low);
      data_.axis_high.push_back(of_axis.high);
      data_.axis_unit.push_back(of_axis.unit);
      data_.axis_rotary.push_back(axis.kind == mesh::AxisKind::rotary);
      data_.axis_direction.insert(data_.axis_direction.end(), axis.direction.begin(), axis.direction.end());
      data_.axis_origin.insert(data_.axis_origin.end(), axis.origin.begin(), axis.origin.end());
      if (axis.kind == mesh::AxisKind::linear) data_.linear_axis.push_back(a);
    }
    data_.linear_axes = std::ssize(data_.linear_axis);
  }

  void add_ambients() {
    data_.ambients = std::ssize(machine_.ambients);
    for (const mesh::AmbientSpec& spec : machine_.ambients) {
      data_.ambient_channel.push_back(channel(spec.id + ".T_C"));
      data_.ambient_follows.push_back(ambient(spec.follows));
      data_.ambient_gradient_channel.push_back(spec.has_gradient ? channel(spec.id + ".gradient_K_m") : -1);
      data_.ambient_default_C.push_back(spec.default_C.value);
      data_.ambient_offset.push_back(spec.offset);
      data_.ambient_gradient.push_back(spec.gradient.value);
    }
  }

  void add_film(int i) {
    const mesh::FilmSpec& film = machine_.films[i];
    const bool constant = film.kind == mesh::FilmKind::constant, disc = film.kind == mesh::FilmKind::rotating_disc;
    const int volume = machine_.volume_index(film.ambient), own = ambient(film.ambient);
    ++data_.films;
    data_.film_still.push_back(constant
                                   ? film.coefficient.value
                                   : solver::free_convection(film.orientation, film.length, film.delta, reference_K_));
    data_.film_radiation.push_back(solver::radiation(film.emissivity.value, reference_K_));
    data_.film_emissivity.push_back(film.emissivity.value);
    data_.film_length.push_back(film.length);
    data_.film_factor.push_back(constant ? 1.0 : film.coefficient.value);
    data_.film_load.push_back(film.radiation_load);
    data_.film_radius.push_back(film.radius);
    data_.film_fraction.push_back(film.fraction);
    data_.film_speed_factor.push_back(film.speed_factor);
    data_.film_ambient.push_back(own);
    data_.film_surroundings.push_back(film.surroundings.empty() ? own : ambient(film.surroundings));
    data_.film_own.push_back(reading(solver::ObservedKind::film, i));
    data_.film_volume.push_back(volume >= 0 ? reading(solver::ObservedKind::volume, volume) : -1);
    data_.film_of_temperature.push_back(film.of_temperature);
    data_.film_exact.push_back(film.exact_radiation);
    data_.film_orientation.push_back(static_cast<int>(film.orientation));
    data_.film_table.push_back(film.table.input.empty() ? -1 : curve(film.table.at, film.table.power));
    data_.film_table_channel.push_back(channel(film.table.input));
    data_.film_table_input.push_back(static_cast<int>(mesh::table_input(film.table.input)));
    data_.film_state.push_back(channel(film.state));
    const bool spindle = film.axis == "spindle";
    data_.film_speed_channel.push_back(
        disc ? channel(spindle ? "spindle.speed_rpm" : "axis." + film.axis + ".feed_deg_min") : -1);
    data_.film_to_rad_s.push_back(spindle ? units::rpm : units::deg_min);
    const auto found = std::find_if(layout_.inputs.begin(), layout_.inputs.end(), [&](const solver::Input& input) {
      return input.kind == solver::InputKind::film_ambient && input.item == i;
    });
    data_.film_first_input.push_back(found == layout_.inputs.end() ? -1 : found - layout_.inputs.begin());
  }

  void add_joint(int j) {
    const mesh::JointSpec& joint = machine_.joints[j];
    const solver::JointGrid& grid = layout_.grids[j];
    ++data_.joints;
    const auto first = std::find_if(layout_.terms.begin(), layout_.terms.end(), [&](const solver::Term& term) {
      return term.kind == solver::TermKind::contact && term.item == j && term.part == 0;
    });
    data_.joint_first_term.push_back(first == layout_.terms.end() ? -1 : first - layout_.terms.begin());
    data_.joint_conductance.push_back(joint.conductance.value);
    data_.joint_factor.push_back(joint.law.factor(false));
    data_.joint_clamped_factor.push_back(joint.law.factor(true));
    data_.joint_clamp.push_back(joint.law.clamped_pressure > 0.0 ? channel("axis." + joint.axis + ".clamp.on") : -1);
    data_.joint_reading.push_back(reading(solver::ObservedKind::joint, j));
    data_.joint_curve.push_back(curve(joint.law.by_temperature.at, joint.law.by_temperature.value));
    data_.joint_grid_axis.push_back(grid.axis);
    data_.joint_periodic.push_back(grid.periodic);
    data_.joint_positions.insert(data_.joint_positions.end(), grid.positions.begin(), grid.positions.end());
    data_.joint_grid_first.push_back(std::ssize(data_.joint_positions));
  }

  void add_coolant(int i) {
    const mesh::CoolantSpec& coolant = machine_.coolants[i];
    ++data_.coolants;
    data_.coolant_on.push_back(channel("coolant." + coolant.id + ".on"));
    data_.coolant_inlet.push_back(channel("coolant." + coolant.id + ".inlet_T_C"));
    data_.coolant_guide.push_back(coolant.guide_sensor.empty() ? -1 : machine_.sensor_index(coolant.guide_sensor));
    data_.coolant_guide_ambient.push_back(coolant.guide_sensor.empty() ? ambient(coolant.guide_ambient) : -1);
    data_.coolant_returns.push_back(reading(solver::ObservedKind::coolant_return, i));
    data_.coolant_warmed_by.push_back(
        reading(solver::ObservedKind::volume, machine_.volume_index(coolant.guide_warmed_by)));
    data_.coolant_control.push_back(static_cast<int>(coolant.control));
    data_.coolant_controls_return.push_back(coolant.controls_return);
    data_.coolant_warmed_share.push_back(coolant.guide_warmed_share);
    data_.coolant_offset.push_back(coolant.guide_offset);
    data_.coolant_inlet_offset.push_back(coolant.inlet_offset);
    data_.coolant_time_constant.push_back(coolant.time_constant);
    data_.coolant_band.push_back(coolant.band);
    data_.coolant_pull_down.push_back(coolant.pull_down);
    data_.coolant_drift_up.push_back(coolant.drift_up);
    data_.coolant_gain.push_back(coolant.gain);
    data_.coolant_integral_time.push_back(coolant.integral_time);
    data_.coolant_heat_flow.push_back(coolant.flow.value * coolant.specific_heat);
    data_.coolant_power.push_back(coolant.power);
  }

  /// Of a channel of speeds, in its unit; 0 for any other channel.
  double largest_speed(const std::string& name) const {
    if (name == "spindle.speed_rpm") return machine_.spindle_max_rpm;
    for (std::size_t a = 0; a < machine_.axes.size(); ++a) {
      if (name.starts_with("axis." + machine_.axes[a].id + ".feed_"))
        return machine_.axes[a].rapid * units::minute / channels_.of_axis(a).unit;
    }
    return 0.0;
  }

  void add_source(const mesh::SourceSpec& source) {
    ++data_.sources;
    data_.source_drive.push_back(source.drive.empty() ? -1 : channel(source.drive + ".power_W"));
    data_.source_scale.push_back(source.scale.value);
    data_.source_loss_share.push_back(source.drive_loss_share);
    data_.source_standstill.push_back(source.standstill);
    data_.source_exponent.push_back(source.speed_exponent);
    for (const mesh::PowerLaw& law : source.laws) {
      data_.law_channel.push_back(channel(law.input));
      data_.law_input.push_back(static_cast<int>(mesh::table_input(law.input)));
      data_.law_half_speed.push_back(0.5 * largest_speed(law.input));
      data_.law_curve.push_back(curve(law.at, law.power));
    }
    data_.source_law_first.push_back(std::ssize(data_.law_channel));
    for (const mesh::LossLaw& loss : source.losses) add_loss(loss);
    data_.source_loss_first.push_back(std::ssize(data_.loss_kind));
  }

  void add_loss(const mesh::LossLaw& loss) {
    const int axis = machine_.axis_index(loss.motion);
    if (axis < 0) {
      data_.loss_speed.push_back(channel("spindle.speed_rpm"));
      for (std::vector<std::int32_t>* none :
           {&data_.loss_position, &data_.loss_low, &data_.loss_high, &data_.loss_clamp})
        none->push_back(-1);
      data_.loss_to_position.push_back(1.0);
      data_.loss_to_speed.push_back(loss.turns / units::minute);
      data_.loss_fastest.push_back(machine_.spindle_max_rpm);
    } else {
      const solver::AxisChannels& of_axis = channels_.of_axis(axis);
      const bool linear = machine_.axes[axis].kind == mesh::AxisKind::linear;
      const bool by_speed =
          std::holds_alternative<mesh::GuideLoss>(loss.law) || std::holds_alternative<mesh::ScrewLoss>(loss.law);
      data_.loss_speed.push_back(of_axis.feed);
      data_.loss_position.push_back(of_axis.position);
      data_.loss_low.push_back(of_axis.low);
      data_.loss_high.push_back(of_axis.high);
      data_.loss_clamp.push_back(of_axis.clamped);
      data_.loss_to_position.push_back(of_axis.unit);
      data_.loss_to_speed.push_back((by_speed ? units::mm
                                     : linear ? loss.turns * units::mm
                                              : loss.turns / 360.0) /
                                    units::minute);
      data_.loss_fastest.push_back(machine_.axes[axis].rapid * units::minute / of_axis.unit);
    }
    std::array<double, TT_LOSS_NUMBERS> numbers{};
    int torque = -1;
    data_.loss_kind.push_back(numbers_of(loss, numbers, torque));
    data_.loss_curve.push_back(torque);
    data_.loss_numbers.insert(data_.loss_numbers.end(), numbers.begin(), numbers.end());
  }

  /// Their meaning is in laws.h.
  int numbers_of(const mesh::LossLaw& loss, std::array<double, TT_LOSS_NUMBERS>& numbers, int& torque) {
    if (const auto* bearing = std::get_if<mesh::BearingLoss>(&loss.law)) {
      const double dm = bearing->mean_diameter * 1e3;  // mm
      numbers = {bearing->viscosity * 1e6, 1e-7 * bearing->f0 * dm * dm * dm, bearing->f1 * bearing->load * dm,
                 bearing->count};
      return TT_BEARING;
    }
    if (const auto* guide = std::get_if<mesh::GuideLoss>(&loss.law)) {
      numbers = {guide->coulomb, guide->viscous};
      return TT_GUIDE;
    }
    if (const auto* screw = std::get_if<mesh::ScrewLoss>(&loss.law)) {
      const double drag = 0.05 / std::sqrt(screw->lead / (std::numbers::pi * screw->diameter));
      numbers = {drag * screw->preload + screw->load * (1.0 - screw->efficiency) / screw->efficiency};
      return TT_SCREW;
    }
    if (const auto* motor = std::get_if<mesh::MotorLoss>(&loss.law)) {
      numbers = {motor->torque_constant, motor->phases * motor->resistance * mesh::copper_factor(motor->winding_C),
                 motor->hysteresis, motor->eddy, motor->nominal_speed};
      torque = curve(motor->torque.at, motor->torque.value);
      return TT_MOTOR;
    }
    const auto& holding = std::get<mesh::HoldingLoss>(loss.law);
    const int axis = machine_.axis_index(loss.motion);
    numbers = {holding.balanced, holding.full_power,          holding.linear_share,
               holding.friction, std::asin(holding.friction), 1.0 * channels_.of_axis(axis).positive};
    return TT_HOLDING;
  }

  void add_term(const solver::Term& term) {
    constexpr double given_time = 1.0;  // s: operating_model.cpp
    double value = 0.0;
    int multiplied_by = -1;
    switch (term.kind) {
      case solver::TermKind::film:
      case solver::TermKind::contact: break;
      case solver::TermKind::coolant_wall:
        value = machine_.coolants[term.item].segments[term.part].film_coefficient.value;
        break;
      case solver::TermKind::coolant_flow:
        value = machine_.coolants[term.item].flow.value;
        multiplied_by = channel("coolant." + machine_.coolants[term.item].id + ".on");
        break;
      case solver::TermKind::volume_exchange: {
        const mesh::VolumeExchange& exchange = machine_.volumes[term.item].exchanges[term.part];
        value = exchange.conductance.value;
        multiplied_by = channel(exchange.state);
        break;
      }
      case solver::TermKind::volume_given:
        value = machine_.volumes[term.item].capacity.value / given_time;
        multiplied_by = channel(machine_.volumes[term.item].id + ".T_C");
        break;
    }
    ++data_.terms;
    data_.term_kind.push_back(static_cast<int>(term.kind));
    data_.term_item.push_back(term.item);
    data_.term_value.push_back(value);
    data_.term_channel.push_back(multiplied_by);
  }

  void add_input(const solver::Input& input) {
    int of_ambient = -1, given = -1, occupied = -1;
    double share = 1.0;
    switch (input.kind) {
      case solver::InputKind::contact_ambient: of_ambient = ambient(machine_.joints[input.item].ambient); break;
      case solver::InputKind::volume_ambient:
        of_ambient = ambient(machine_.volumes[input.item].exchanges[input.place].with);
        break;
      case solver::InputKind::volume_given: given = channel(machine_.volumes[input.item].id + ".T_C"); break;
      case solver::InputKind::source: {
        const mesh::SourcePlace& place = machine_.sources[input.item].places[input.place];
        share = place.share;
        if (!place.joint.empty()) occupied = data_.joint_first_term[machine_.joint_index(place.joint)] + input.node;
        break;
      }
      default: break;
    }
    ++data_.inputs;
    data_.input_kind.push_back(static_cast<int>(input.kind));
    data_.input_term.push_back(input.term);
    data_.input_item.push_back(input.item);
    data_.input_ambient.push_back(of_ambient);
    data_.input_channel.push_back(given);
    data_.input_occupancy.push_back(occupied);
    data_.input_share.push_back(share);
  }

  void add_chains() {
    const solver::TableFrames frames = solver::table_frames(machine_);
    for (int body : {machine_.body_index(machine_.tcp.tool_body), frames.carrier, frames.table}) {
      for (; body >= 0; body = machine_.body_index(machine_.bodies[body].parent)) {
        const std::string& axis = machine_.bodies[body].axis;
        if (const int a = axis.empty() ? -1 : machine_.axis_index(axis); a >= 0) data_.chain_axis.push_back(a);
      }
      data_.chain_first.push_back(std::ssize(data_.chain_axis));
    }
    const auto [origin, direction] = solver::growth_axis(machine_);
    data_.growth_origin.assign(origin.begin(), origin.end());
    data_.growth_direction.assign(direction.begin(), direction.end());
    data_.tool_point.assign(machine_.tcp.tool_point.begin(), machine_.tcp.tool_point.end());
    data_.table_point.assign(machine_.tcp.table_point.begin(), machine_.tcp.table_point.end());
    data_.table_radius = machine_.tcp.table_radius;
  }

  const mesh::Machine& machine_;
  const solver::Layout& layout_;
  const solver::Channels& channels_;
  ControlData& data_;
  double reference_K_;
};

}  // namespace

void fill_machine(const mesh::Machine& machine, const solver::Layout& layout, const solver::Channels& channels,
                  ControlData& data) {
  data.name = machine.name;
  data.reference_C = machine.reference_C;
  data.plausible_low_C = machine.plausible_low_C;
  data.plausible_high_C = machine.plausible_high_C;
  data.sensors = std::ssize(machine.sensors);
  for (const mesh::SensorSpec& sensor : machine.sensors) data.sensor_names.push_back(sensor.id);
  const Eigen::VectorXd offsets = solver::sensor_offsets(machine, layout);
  data.sensor_offset.assign(offsets.begin(), offsets.end());
  data.readings = offsets.size();
  MachineArrays(machine, layout, channels, data).fill();
}

}  // namespace thermotwin::compensation
