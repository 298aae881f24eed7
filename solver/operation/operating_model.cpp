// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/operating_model.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.h"
#include "core/interpolation.h"
#include "core/text.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "solver/operation/film_laws.h"
#include "solver/operation/grid_occupancy.h"
#include "solver/operation/layout.h"

namespace thermotwin::solver {

namespace {

namespace units = core::units;

int require_channel(const Channels& channels, const std::string& name, const std::string& place) {
  const int index = channels.index(name);
  if (index < 0) {
    throw core::InputError(place, "channel '" + name + "'",
                           "a channel of the machine (nearest: " + core::nearest(name, channels.names()) + ")");
  }
  return index;
}

int ambient_index(const mesh::Machine& machine, const std::string& id, const std::string& place) {
  if (const int index = machine.ambient_index(id); index >= 0) return index;
  throw core::InputError(place, "ambient '" + id + "'", "an ambient of the machine");
}

/// Below it the air does not know which way to go: the laws stay at what they give there.
constexpr double least_delta_K = 0.05;
/// A volume whose temperature is given follows it within about this time, s.
constexpr double given_time = 1.0;

/// Of a channel of speeds, in its unit; 0 for any other channel.
double largest_speed(const mesh::Machine& machine, const std::string& channel) {
  if (channel == "spindle.speed_rpm") return machine.spindle_max_rpm;
  for (const mesh::Axis& axis : machine.axes) {
    if (channel.starts_with("axis." + axis.id + ".feed_"))
      return axis.rapid * units::minute / (axis.kind == mesh::AxisKind::linear ? units::mm : units::deg);
  }
  return 0.0;
}

/// A power law beside the table: 1 at half of the largest speed, and at rest.
double by_speed(double relative, double exponent) {
  return exponent == 0.0 || !(relative > 0.0) ? 1.0 : std::pow(std::max(relative, 1e-3), exponent);
}

}  // namespace

OperatingModel::OperatingModel(const mesh::Machine& machine, const Layout& layout)
    : machine_(machine),
      layout_(layout),
      channels_(machine),
      machine_on_(channels_.index("machine.on")) {
  connect_ambients();
  connect_films();
  find_first_terms();
  connect_joints();
  connect_fluids();
  connect_sources();
}

void OperatingModel::connect_ambients() {
  for (const mesh::AmbientSpec& ambient : machine_.ambients) {
    ambient_channels_.push_back(channels_.index(ambient.id + ".T_C"));
    gradient_channels_.push_back(ambient.has_gradient ? channels_.index(ambient.id + ".gradient_K_m") : -1);
    ambient_follows_.push_back(
        ambient.follows.empty() ? -1 : ambient_index(machine_, ambient.follows, "ambient " + ambient.id));
  }
}

void OperatingModel::connect_films() {
  const double reference_K = machine_.reference_C + units::zero_C_in_K;
  const auto films = std::ssize(machine_.films);
  still_film_.resize(films);
  radiation_film_.resize(films);
  for (Eigen::Index i = 0; i < films; ++i) {
    const mesh::FilmSpec& film = machine_.films[i];
    if (film.of_temperature || (film.emissivity.value > 0.0 && film.exact_radiation)) follows_temperature_ = true;
    film_channels_.push_back(channels_of_film(i));
    still_film_[i] = film.kind == mesh::FilmKind::constant
                         ? film.coefficient.value
                         : free_convection(film.orientation, film.length, film.delta, reference_K);
    radiation_film_[i] = radiation(film.emissivity.value, reference_K);
  }
}

OperatingModel::FilmChannels OperatingModel::channels_of_film(int index) const {
  const mesh::FilmSpec& film = machine_.films[index];
  const std::string place = "film " + film.id;
  FilmChannels c{-1, -1, -1, -1, -1, -1, -1, 0.0, mesh::TableInput::value};
  c.own = reading_index(machine_, layout_, ObservedKind::film, index);
  if (const int volume = machine_.volume_index(film.ambient); volume >= 0)
    c.volume = reading_index(machine_, layout_, ObservedKind::volume, volume);
  else
    c.ambient = ambient_index(machine_, film.ambient, place);
  c.surroundings = film.surroundings.empty() ? c.ambient : ambient_index(machine_, film.surroundings, place);
  if (!film.table.input.empty()) {
    c.table = require_channel(channels_, film.table.input, place);
    c.table_input = mesh::table_input(film.table.input);
  }
  if (!film.state.empty()) c.state = require_channel(channels_, film.state, place);
  if (film.kind == mesh::FilmKind::rotating_disc) {
    const bool spindle = film.axis == "spindle";
    c.speed = require_channel(channels_, spindle ? "spindle.speed_rpm" : "axis." + film.axis + ".feed_deg_min", place);
    c.to_rad_s = spindle ? units::rpm : units::deg_min;
  }
  return c;
}

void OperatingModel::find_first_terms() {
  film_first_input_.assign(machine_.films.size(), -1);
  for (std::size_t k = 0; k < layout_.inputs.size(); ++k)
    if (layout_.inputs[k].kind == InputKind::film_ambient) film_first_input_[layout_.inputs[k].item] = k;
  joint_first_term_.assign(machine_.joints.size(), -1);
  for (std::size_t t = 0; t < layout_.terms.size(); ++t) {
    if (const Term& term = layout_.terms[t]; term.kind == TermKind::contact && term.part == 0)
      joint_first_term_[term.item] = t;
  }
}

void OperatingModel::connect_joints() {
  for (std::size_t j = 0; j < machine_.joints.size(); ++j) {
    const mesh::JointSpec& joint = machine_.joints[j];
    contact_factor_.push_back(joint.law.factor(false));
    clamped_factor_.push_back(joint.law.factor(true));
    joint_reading_.push_back(reading_index(machine_, layout_, ObservedKind::joint, j));
    if (joint_reading_.back() >= 0) follows_temperature_ = true;
    joint_clamped_.push_back(joint.law.clamped_pressure > 0.0 ? channels_.index("axis." + joint.axis + ".clamp.on")
                                                              : -1);
    joint_ambient_.push_back(joint.master.empty() ? ambient_index(machine_, joint.ambient, "joint " + joint.id) : -1);
  }
}

void OperatingModel::connect_fluids() {
  for (const mesh::CoolantSpec& coolant : machine_.coolants)
    coolant_on_.push_back(channels_.index("coolant." + coolant.id + ".on"));
  for (const mesh::VolumeSpec& volume : machine_.volumes) {
    const std::string place = "volume " + volume.id;
    volume_given_.push_back(channels_.index(volume.id + ".T_C"));
    std::vector<ExchangeChannels> exchanges;
    for (const mesh::VolumeExchange& exchange : volume.exchanges) {
      const bool with_volume = machine_.volume_index(exchange.with) >= 0;
      exchanges.push_back({exchange.state.empty() ? -1 : require_channel(channels_, exchange.state, place),
                           with_volume ? -1 : ambient_index(machine_, exchange.with, place)});
    }
    exchange_channels_.push_back(std::move(exchanges));
  }
}

void OperatingModel::connect_sources() {
  for (const mesh::SourceSpec& source : machine_.sources) {
    source_drive_.push_back(source.drive.empty() ? -1 : channels_.index(source.drive + ".power_W"));
    std::vector<LawChannel> laws;
    for (const mesh::PowerLaw& law : source.laws) {
      laws.push_back({require_channel(channels_, law.input, "source " + source.id), mesh::table_input(law.input),
                      0.5 * largest_speed(machine_, law.input)});
    }
    law_channels_.push_back(std::move(laws));
    std::vector<LossInput> losses;
    for (const mesh::LossLaw& loss : source.losses) losses.emplace_back(machine_, channels_, loss);
    loss_inputs_.push_back(std::move(losses));
  }
}

double OperatingModel::ambient_K(int ambient, const Eigen::VectorXd& row) const {
  const std::size_t i = ambient;
  const double measured = row[ambient_channels_[i]], offset = machine_.ambients[i].offset;
  // The offset of one that follows is a difference between two ambients: it ends where its own
  // channel is measured. Else it is one between the channel and the air that the machine feels.
  if (ambient_follows_[i] >= 0)
    return std::isfinite(measured) ? measured - machine_.reference_C : ambient_K(ambient_follows_[i], row) + offset;
  return (std::isfinite(measured) ? measured : machine_.ambients[i].default_C.value) + offset - machine_.reference_C;
}

double OperatingModel::gradient_K_m(int ambient, const Eigen::VectorXd& row) const {
  const std::size_t i = ambient;
  if (gradient_channels_[i] < 0) return 0.0;
  const double measured = row[gradient_channels_[i]];
  return std::isfinite(measured) ? measured : machine_.ambients[i].gradient.value;
}

Eigen::VectorXd OperatingModel::guide_K(const Eigen::VectorXd& row) const {
  Eigen::VectorXd guide = Eigen::VectorXd::Zero(std::ssize(machine_.coolants));
  for (Eigen::Index i = 0; i < guide.size(); ++i) {
    const mesh::CoolantSpec& coolant = machine_.coolants[i];
    if (const int ambient = machine_.ambient_index(coolant.guide_ambient); coolant.guide_sensor.empty() && ambient >= 0)
      guide[i] = ambient_K(ambient, row);
  }
  return guide;
}

OperatingModel::FilmCoefficients OperatingModel::film_coefficients(std::size_t i, const Eigen::VectorXd& row,
                                                                   const Eigen::VectorXd& readings_K) const {
  const mesh::FilmSpec& spec = machine_.films[i];
  const FilmChannels& c = film_channels_[i];
  const Eigen::Index film = i;
  const double reference_K = machine_.reference_C + units::zero_C_in_K;
  FilmCoefficients of_film{still_film_[film], radiation_film_[film], spec.emissivity.value, 0.0, 0.0};
  if (c.ambient >= 0) of_film.ambient_K = ambient_K(c.ambient, row);
  if (c.surroundings >= 0)
    of_film.surroundings_K = c.surroundings == c.ambient ? of_film.ambient_K : ambient_K(c.surroundings, row);
  if (c.own >= 0 && readings_K.size() > 0) {
    const double own = readings_K[c.own];
    if (spec.of_temperature) {
      const double ambient = c.volume >= 0 ? readings_K[c.volume] : of_film.ambient_K, delta = own - ambient;
      // Cold air sinks: under a plate that is colder than the air it behaves as over a warm one.
      mesh::Orientation orientation = spec.orientation;
      if (delta < 0.0 && orientation != mesh::Orientation::vertical)
        orientation = orientation == mesh::Orientation::up ? mesh::Orientation::down : mesh::Orientation::up;
      of_film.convection =
          free_convection(orientation, spec.length, std::max(std::abs(delta), least_delta_K), ambient + reference_K);
    }
    if (spec.exact_radiation)
      of_film.radiation =
          radiation_between(spec.emissivity.value, own + reference_K, of_film.surroundings_K + reference_K);
  }
  if (c.table >= 0) {
    const double value = row[c.table];
    // An input that nobody gives: its law has nothing to say.
    const double lowest = spec.table.power.front();
    of_film.convection = std::isfinite(value)
                             ? core::linear_at(spec.table.at, spec.table.power, mesh::at_input(c.table_input, value))
                             : 0.0;
    if (std::isfinite(value) && spec.speed_factor != 1.0)
      of_film.convection = std::max(0.0, lowest + spec.speed_factor * (of_film.convection - lowest));
  }
  if (c.speed >= 0) {
    const double forced = spec.speed_factor * spec.fraction * rotating_disc(row[c.speed] * c.to_rad_s, spec.radius),
                 still = of_film.convection;
    of_film.convection = std::cbrt(still * still * still + forced * forced * forced);
  }
  double factor = spec.kind != mesh::FilmKind::constant ? spec.coefficient.value : 1.0;
  if (c.state >= 0) factor *= row[c.state];
  of_film.convection *= factor;
  of_film.radiation *= factor;
  of_film.emissivity *= factor;
  return of_film;
}

double OperatingModel::source_power(std::size_t i, const Eigen::VectorXd& row) const {
  const mesh::SourceSpec& source = machine_.sources[i];
  const double drive = source_drive_[i] >= 0 ? row[source_drive_[i]] : not_given;
  const double standstill =
      source.standstill != 0.0 && machine_on_ >= 0 ? source.standstill * row[machine_on_] : source.standstill;
  if (std::isfinite(drive)) return source.scale.value * source.drive_loss_share * drive + standstill;
  double power = 0.0;
  for (std::size_t k = 0; k < source.laws.size(); ++k) {
    const auto& [channel, input, half_speed] = law_channels_[i][k];
    const double value = row[channel];
    // An input that nobody gives: its law has nothing to say.
    if (!std::isfinite(value)) continue;
    const double factor = half_speed > 0.0 ? by_speed(std::abs(value) / half_speed, source.speed_exponent) : 1.0;
    power += factor * core::linear_at(source.laws[k].at, source.laws[k].power, mesh::at_input(input, value));
  }
  for (std::size_t k = 0; k < source.losses.size(); ++k) {
    power += by_speed(2.0 * loss_inputs_[i][k].relative_speed(row), source.speed_exponent) *
             loss_inputs_[i][k].power(source.losses[k], row);
  }
  return source.scale.value * power + standstill;
}

double OperatingModel::conductance(std::size_t joint, const Eigen::VectorXd& row,
                                   const Eigen::VectorXd& readings_K) const {
  double factor = contact_factor_[joint];
  if (joint_clamped_[joint] >= 0) factor += row[joint_clamped_[joint]] * (clamped_factor_[joint] - factor);
  if (joint_reading_[joint] >= 0) {
    const double at_K = readings_K.size() > 0 ? readings_K[joint_reading_[joint]] : 0.0;
    factor *= machine_.joints[joint].law.by_temperature(machine_.reference_C + at_K);
  }
  return machine_.joints[joint].conductance.value * factor;
}

Eigen::VectorXd OperatingModel::source_powers(const Eigen::VectorXd& row) const {
  Eigen::VectorXd powers(std::ssize(machine_.sources));
  for (Eigen::Index i = 0; i < powers.size(); ++i) powers[i] = source_power(i, row);
  return powers;
}

mesh::Pose OperatingModel::pose(const Eigen::VectorXd& row) const {
  mesh::Pose pose(std::ssize(machine_.axes));
  for (Eigen::Index i = 0; i < pose.size(); ++i)
    pose[i] = row[channels_.of_axis(i).position] * channels_.of_axis(i).unit;
  return pose;
}

void OperatingModel::coefficients(const Eigen::VectorXd& row, const Eigen::VectorXd& inlet_K,
                                  const Eigen::VectorXd& readings_K, Coefficients& out) const {
  const auto terms = std::ssize(layout_.terms);
  out.p.resize(terms);
  out.q.resize(std::ssize(layout_.inputs));
  out.occupancy.resize(terms);
  out.occupancy.setOnes();
  out.radiation.clear();
  for (std::size_t j = 0; j < layout_.grids.size(); ++j) {
    const JointGrid& grid = layout_.grids[j];
    if (grid.axis < 0 || joint_first_term_[j] < 0) continue;
    const AxisChannels& axis = channels_.of_axis(grid.axis);
    double low = row[axis.low], high = row[axis.high];
    if (!std::isfinite(low) || !std::isfinite(high)) low = high = row[axis.position];
    grid_occupancy(grid, low * axis.unit, high * axis.unit,
                   out.occupancy.segment(joint_first_term_[j], std::ssize(grid.positions)));
  }
  for (Eigen::Index t = 0; t < terms; ++t) {
    const Term& term = layout_.terms[t];
    const std::size_t item = term.item;
    switch (term.kind) {
      case TermKind::film: {
        const FilmCoefficients of_film = film_coefficients(item, row, readings_K);
        out.p[t] = of_film.convection + of_film.radiation;
        if (film_channels_[item].ambient < 0) break;
        const Eigen::Index k = film_first_input_[item];
        out.q[k] = of_film.convection * of_film.ambient_K + of_film.radiation * of_film.surroundings_K +
                   machine_.films[item].radiation_load;
        if (gradient_channels_[film_channels_[item].ambient] >= 0)
          out.q[k + 1] = of_film.convection * gradient_K_m(film_channels_[item].ambient, row);
        if (machine_.films[item].exact_radiation && of_film.emissivity > 0.0)
          out.radiation.push_back({term.item, of_film.emissivity, of_film.radiation, of_film.surroundings_K});
        break;
      }
      case TermKind::contact: out.p[t] = conductance(item, row, readings_K) * out.occupancy[t]; break;
      case TermKind::coolant_wall: out.p[t] = machine_.coolants[item].segments[term.part].film_coefficient.value; break;
      case TermKind::coolant_flow: out.p[t] = machine_.coolants[item].flow.value * row[coolant_on_[item]]; break;
      case TermKind::volume_exchange: {
        const std::size_t part = term.part;
        const int state = exchange_channels_[item][part].state;
        out.p[t] = machine_.volumes[item].exchanges[part].conductance.value * (state >= 0 ? row[state] : 1.0);
        break;
      }
      case TermKind::volume_given:
        out.p[t] = std::isfinite(row[volume_given_[item]]) ? machine_.volumes[item].capacity.value / given_time : 0.0;
        break;
    }
  }
  for (Eigen::Index k = 0; k < out.q.size(); ++k) {
    const Input& input = layout_.inputs[k];
    const std::size_t item = input.item;
    switch (input.kind) {
      case InputKind::film_ambient:
      case InputKind::film_gradient: break;  // with their terms
      case InputKind::volume_ambient:
        out.q[k] = out.p[input.term] * ambient_K(exchange_channels_[item][input.place].ambient, row);
        break;
      case InputKind::volume_given:
        out.q[k] =
            out.p[input.term] > 0.0 ? out.p[input.term] * (row[volume_given_[item]] - machine_.reference_C) : 0.0;
        break;
      case InputKind::contact_ambient: out.q[k] = out.p[input.term] * ambient_K(joint_ambient_[item], row); break;
      case InputKind::coolant_inlet: out.q[k] = out.p[input.term] * inlet_K[input.item]; break;
      case InputKind::source: {
        const mesh::SourcePlace& place = machine_.sources[item].places[input.place];
        double share = place.share;
        if (!place.joint.empty())
          share *= out.occupancy[joint_first_term_[machine_.joint_index(place.joint)] + input.node];
        out.q[k] = source_power(item, row) * share;
        break;
      }
    }
  }
}

Coefficients OperatingModel::coefficients(const Eigen::VectorXd& row, const Eigen::VectorXd& inlet_K,
                                          const Eigen::VectorXd& readings_K) const {
  Coefficients out;
  coefficients(row, inlet_K, readings_K, out);
  return out;
}

}  // namespace thermotwin::solver
