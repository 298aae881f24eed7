// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/response.h"

#include <Eigen/LU>

#include <algorithm>
#include <cassert>
#include <iterator>

#include "core/thread_pool.h"
#include "core/units.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/record/readings.h"
#include "diagnosis/response/seen_sides.h"
#include "diagnosis/response/start_modes.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/simulation.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double spread_s = 600.0;  ///< 18 cm in steel

/// Of each record, below each other; columns that one has fewer of are zero.
template <class Responses, class Values>
MatrixXd below(const Responses& responses, const Values& values_of) {
  MatrixXd all;
  for (const auto& one : responses) {
    const MatrixXd values = values_of(one);
    const Index rows = all.rows(), columns = all.cols();
    all.conservativeResize(rows + values.rows(), std::max(columns, values.cols()));
    all.bottomRows(values.rows()).setZero();
    all.rightCols(all.cols() - columns).setZero();
    all.bottomLeftCorner(values.rows(), values.cols()) = values;
  }
  return all;
}

/// Each in rows and columns of its own.
MatrixXd blocks(const std::vector<MatrixXd>& parts) {
  MatrixXd all;
  for (const MatrixXd& part : parts) {
    const Index rows = all.rows(), columns = all.cols();
    MatrixXd both = MatrixXd::Zero(rows + part.rows(), columns + part.cols());
    both.topLeftCorner(rows, columns) = all;
    if (part.size() > 0) both.bottomRightCorner(part.rows(), part.cols()) = part;  // else it may point at nothing
    all = std::move(both);
  }
  return all;
}

}  // namespace

MachineInTime with_parameters(const MachineInTime& base, const std::vector<Parameter>& parameters,
                              const VectorXd& values) {
  MachineInTime machine = base;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (values[i] != parameters[i].nominal) machine = with_parameter(machine, parameters[i], values[i]);
  return machine;
}

MatrixXd Response::rows_of(const Rows& all, const PartChanges& changes) const {
  MatrixXd rows = all.base;
  const auto add = [&](const std::vector<MatrixXd>& parts, const VectorXd& amounts) {
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (const double amount = amounts[i]; amount != 0.0 && parts[i].size() > 0) rows += amount * parts[i];
  };
  add(all.bodies, changes.bodies);
  add(all.scales, changes.scales);
  add(all.screws, changes.screws);
  if (!all.stiffness.empty()) add(all.stiffness, stiffness_amounts(*model_.parts, changes));
  return rows;
}

Response::Response(const reduction::ReducedModel& model, const Observations& observations)
    : model_(model),
      observations_(observations) {
  for (const Observations& record : observations.records) each_.emplace_back(model, record);
  if (!each_.empty()) return;
  rows_ = observed_rows();
  set_air();
}

MatrixXd Response::nominal_rows() const {
  if (!each_.empty()) return below(each_, [](const Response& one) { return one.nominal_rows(); });
  return rows_.base.topRows(std::ssize(observations_.channels));
}

void Response::set_air() {
  const mesh::Machine& machine = model_.machine;
  const solver::OperatingModel operating(machine, model_.system.layout);
  const Index points = observations_.points.size(), steps = observations_.rows.rows();
  std::vector<int> ambients;  // of each column of air_
  for (Index s = 0; s < std::ssize(machine.sensors); ++s) {
    const int film = model_.sensor_air ? model_.sensor_air->film[s] : -1;
    const std::string id = film < 0 ? "air" : machine.films[film].ambient;
    of_volume_.push_back(model_.sensor_air ? machine.volume_index(id) : -1);
    const int ambient = machine.ambient_index(id);
    const auto column = std::find(ambients.begin(), ambients.end(), ambient);
    of_ambient_.push_back(of_volume_.back() >= 0 ? -1 : column - ambients.begin());
    if (of_volume_.back() < 0 && column == ambients.end()) ambients.push_back(ambient);
  }
  air_.setConstant(points, std::ssize(ambients), machine.reference_C);
  for (Index a = 0; a < air_.cols(); ++a) {
    if (ambients[a] < 0) continue;  // a machine without air: its reference temperature
    VectorXd means(steps);
    for (Index s = 0; s < steps; ++s)
      means[s] = operating.ambient_K(ambients[a], observations_.rows.row(s).transpose());
    means = without_noise(means);
    for (Index i = 0; i <= steps; ++i)
      air_(i, a) += 0.5 * (means[std::max<Index>(i - 1, 0)] + means[std::min(i, steps - 1)]);
  }
}

VectorXd Response::air_beside(int sensor, const MatrixXd& states) const {
  if (of_ambient_[sensor] >= 0) return air_.col(of_ambient_[sensor]);
  const Index first = std::ssize(observations_.channels);
  return states.col(first + of_volume_[sensor]).array() + model_.machine.reference_C;
}

Response::Rows Response::observed_rows() const {
  const mesh::Machine& machine = model_.machine;
  const Index r = model_.system.order(), channels = std::ssize(observations_.channels),
              count = channels + (model_.sensor_air ? model_.sensor_air->volumes.rows() : 0);
  std::vector<Sides> sides;  // of displacements
  for (const ObservedChannel& observed : observations_.channels)
    sides.push_back(observed.is_temperature() ? Sides() : sides_of(machine, observed));
  const auto displacements = [&](const reduction::ReducedOutputs& outputs) {
    MatrixXd all = MatrixXd::Zero(count, r);
    for (Index k = 0; k < channels; ++k) {
      for (std::size_t i = 0; i < sides[k].poses.size(); ++i)
        all.row(k) += sides[k].rows[i] * reduction::side_rows(machine, outputs, sides[k].poses[i]);
    }
    return all;
  };
  Rows rows;
  rows.base = displacements(model_.outputs);
  if (model_.sensor_air) rows.base.bottomRows(count - channels) = model_.sensor_air->volumes;
  for (Index k = 0; k < channels; ++k) {
    if (const ObservedChannel& observed = observations_.channels[k]; observed.is_temperature())
      rows.base.row(k) = model_.system.sensors.row(machine.sensor_index(observed.channel.sensor));
  }
  if (!model_.parts) return rows;
  const auto all_of = [&](const std::vector<reduction::ReducedOutputs>& outputs) {
    std::vector<MatrixXd> all;
    for (const reduction::ReducedOutputs& output : outputs)
      all.push_back(output.tool.empty() ? MatrixXd() : displacements(output));
    return all;
  };
  rows.bodies = all_of(model_.parts->bodies);
  rows.scales = all_of(model_.parts->scales);
  rows.screws = all_of(model_.parts->screws);
  rows.stiffness = all_of(model_.parts->stiffness);
  return rows;
}

MatrixXd Response::capacity_of(const mesh::Machine& machine) const {
  MatrixXd capacity = model_.system.capacity;
  if (!model_.parts) return capacity;
  const VectorXd changes = part_changes(model_.machine, machine).capacity;
  for (Index i = 0; i < std::ssize(model_.parts->capacity); ++i)
    if (changes[i] != 0.0) capacity += changes[i] * model_.parts->capacity[i];
  return capacity;
}

std::vector<MatrixXd> Response::run(const MachineInTime& machine, std::vector<Variant>& variants,
                                    const Rows& all_rows) const {
  const PartChanges here = part_changes(model_.machine, machine);
  const MatrixXd rows = rows_of(all_rows, here), capacity = capacity_of(machine);
  // What differs in the matrices themselves, by variant; mostly nothing.
  for (Variant& variant : variants) {
    if (!model_.parts) break;
    const PartChanges there = part_changes(model_.machine, variant.machine);
    if ((there.capacity.array() != here.capacity.array()).any())
      variant.capacity_change = capacity_of(variant.machine) - capacity;
    if (there.differs_in_rows(here)) variant.row_change = rows_of(all_rows, there) - rows;
  }
  return propagate({model_, observations_, machine, rows, capacity}, variants);
}

MatrixXd Response::to_heat(const MachineInTime& machine, const MatrixXd& loads, const MatrixXd& series) const {
  if (!each_.empty()) {
    return below(each_, [&](const Response& one) {
      const Observations& record = one.observations_;
      return one.to_heat(machine, loads, series.middleRows(record.offset.step, record.rows.rows()));
    });
  }
  const MatrixXd rows = rows_of(rows_, part_changes(model_.machine, machine)), capacity = capacity_of(machine);
  const std::vector<MatrixXd> values = propagate_heat({model_, observations_, machine, rows, capacity}, loads, series);
  // Of differences: what a reading adds drops out, what it delays does not.
  const MatrixXd none = records(machine, MatrixXd::Zero(observations_.points.size(), rows.rows()));
  MatrixXd columns(observations_.size(), std::ssize(values));
  core::parallel_for(0, values.size(),
                     [&](std::size_t i) { columns.col(i) = stack(records(machine, values[i]) - none); });
  return columns;
}

MatrixXd Response::records(const mesh::Machine& machine, const MatrixXd& states) const {
  MatrixXd result(states.rows(), std::ssize(observations_.channels));
  for (Index k = 0; k < result.cols(); ++k) {
    const ObservedChannel& observed = observations_.channels[k];
    VectorXd values = states.col(k);
    if (observed.is_temperature()) {
      values.array() += machine.reference_C;
      const int sensor = machine.sensor_index(observed.channel.sensor);
      values = sensor_readings(machine.sensors[sensor], observations_.points, air_beside(sensor, states), values);
    }
    result.col(k) = recorded(
        machine, [&](const std::string& id) { return observed.is_called(id); }, observations_.points,
        std::move(values));
  }
  return result;
}

VectorXd Response::stack(const MatrixXd& at_points) const {
  VectorXd all(observations_.size());
  Index at = 0;
  for (std::size_t k = 0; k < observations_.channels.size(); ++k) {
    const ObservedChannel& channel = observations_.channels[k];
    all.segment(at, channel.size()) = channel.means(at_points.col(k));
    at += channel.size();
  }
  return all;
}

MatrixXd Response::at_points(const MachineInTime& machine) const { return records(machine, states(machine)); }

MatrixXd Response::states(const MachineInTime& machine) const {
  if (!each_.empty()) return below(each_, [&](const Response& one) { return one.states(machine); });
  std::vector<Variant> none;
  return run(machine, none, rows_).front();
}

VectorXd Response::read(const mesh::Machine& machine, const MatrixXd& states) const {
  if (!each_.empty()) {
    Index row = 0;
    return below(each_, [&](const Response& one) {
      const Index points = one.observations_.points.size(), columns = one.rows_.base.rows();
      row += points;
      return MatrixXd(one.read(machine, states.block(row - points, 0, points, columns)));
    });
  }
  return stack(records(machine, states));
}

VectorXd Response::predict(const MachineInTime& machine) const { return read(machine, states(machine)); }

Response::Linear Response::linearise_each(const MachineInTime& base, const std::vector<Parameter>& parameters,
                                          const VectorXd& values, bool with_record,
                                          const std::vector<Disturbance>& disturbances, bool with_spread) const {
  std::vector<Linear> linear;
  std::vector<MatrixXd> start, held, disturbed;
  Linear all;
  for (const Response& one : each_) {
    std::vector<Disturbance> own;
    for (const Disturbance& disturbance : disturbances)
      if (disturbance.record == std::ssize(linear)) own.push_back(disturbance);
    linear.push_back(one.linearise(base, parameters, values, with_record, own, with_spread));
    start.push_back(std::move(linear.back().start));
    held.push_back(std::move(linear.back().held));
    disturbed.push_back(std::move(linear.back().disturbed));
    all.start_std.conservativeResize(all.start_std.size() + start.back().cols());
    all.start_std.tail(start.back().cols()) = linear.back().start_std;
  }
  all.predicted = below(linear, [](const Linear& one) { return MatrixXd(one.predicted); });
  all.sensitivity = below(linear, [](const Linear& one) { return one.sensitivity; });
  if (with_spread) all.spread = below(linear, [](const Linear& one) { return one.spread; });
  all.start = blocks(start);
  all.held = blocks(held);
  all.disturbed = blocks(disturbed);
  return all;
}

Response::Linear Response::linearise(const MachineInTime& base, const std::vector<Parameter>& parameters,
                                     const VectorXd& values, bool with_record,
                                     const std::vector<Disturbance>& disturbances, bool with_spread) const {
  const Index count = std::ssize(parameters);
  assert(values.size() == count);
  if (!each_.empty()) return linearise_each(base, parameters, values, with_record, disturbances, with_spread);
  const MachineInTime machine = with_parameters(base, parameters, values);
  std::vector<Variant> variants;
  struct Reading {
    mesh::Machine above, below;
    double width;
  };
  std::vector<Reading> of_readings;
  std::vector<Index> place, place_of_readings;  // column of each
  for (Index at = 0; at < count; ++at) {
    const Parameter& parameter = parameters[at];
    const double step = parameter.step;
    VectorXd moved = values;
    if (acts_on_readings(parameter.kind)) {
      // Both sides: the straight lines between the points of a late series have corners.
      moved[at] = std::min(values[at] + step, parameter.high);
      const mesh::Machine above = with_parameters(base, parameters, moved);
      const double high = moved[at];
      moved[at] = std::max(values[at] - step, parameter.low);
      of_readings.push_back({above, with_parameters(base, parameters, moved), high - moved[at]});
      place_of_readings.push_back(at);
      continue;
    }
    moved[at] += step;
    variants.push_back({with_parameters(base, parameters, moved), 0.0, step, std::nullopt});
    place.push_back(at);
  }
  for (const Disturbance& disturbance : disturbances) variants.push_back({machine, 0.0, 1.0, disturbance});
  const MatrixXd modes = with_record ? start_modes(machine) : MatrixXd(),
                 earlier = with_record
                               ? earlier_operation({model_, observations_, machine, rows_.base, capacity_of(machine)})
                               : MatrixXd();
  const Index starts = with_record ? 1 + modes.cols() + earlier.cols() : 0,
              held = with_record ? std::ssize(observations_.may_hold) : 0;
  if (with_record) variants.push_back({machine, 1.0, 1.0, std::nullopt});
  for (const MatrixXd& fields : {modes, earlier})
    for (Index i = 0; i < fields.cols(); ++i) variants.push_back({.machine = machine, .start = fields.col(i)});
  for (Index i = 0; i < held; ++i) variants.push_back({.machine = machine, .held = &observations_.may_hold[i]});
  const auto total = count + std::ssize(disturbances) + starts + held;
  for (Index i = count; i < total; ++i) place.push_back(i);
  MatrixXd elsewhere;  // less where it was
  if (with_spread) {
    elsewhere = spread_heat();
    elsewhere.diagonal().array() -= 1.0;
    for (std::size_t v = 0, own = variants.size(); v < own; ++v) {
      if (place[v] < count && adds_heat(parameters[place[v]].kind)) {
        variants.push_back(variants[v]);
        variants.back().heat_map = &elsewhere;
        place.push_back(total + place[v]);
      }
    }
  }

  Linear result;
  MatrixXd columns = MatrixXd::Zero(observations_.size(), total + (with_spread ? count : 0));
  const std::vector<MatrixXd> out = run(machine, variants, rows_);
  const MatrixXd &states = out.front(), here = records(machine, states);
  core::parallel_for(0, variants.size(), [&](std::size_t i) {
    columns.col(place[i]) = stack((records(variants[i].machine, states + out[i + 1]) - here) / variants[i].step);
  });
  core::parallel_for(0, of_readings.size(), [&](std::size_t i) {
    columns.col(place_of_readings[i]) =
        stack((records(of_readings[i].above, states) - records(of_readings[i].below, states)) / of_readings[i].width);
  });
  result.predicted = stack(here);
  result.sensitivity = columns.leftCols(count);
  result.disturbed = columns.middleCols(count, std::ssize(disturbances));
  result.start = columns.middleCols(total - held - starts, starts);
  result.start_std.setConstant(starts, start_std(observations_));
  for (Index i = 0; i < earlier.cols(); ++i)
    result.start_std[starts - earlier.cols() + i] = observations_.before[i].std;
  result.held = columns.middleCols(total - held, held);
  if (with_spread) result.spread = columns.rightCols(count);
  return result;
}

MatrixXd Response::start_modes(const mesh::Machine& machine) const {
  return diagnosis::start_modes(model_, machine, observations_);
}

MatrixXd Response::spread_heat() const {
  const reduction::ReducedSystem& system = model_.system;
  return system.capacity * Eigen::PartialPivLU<MatrixXd>(system.capacity + spread_s * system.conduction).inverse();
}

MatrixXd Response::deviations(const MachineInTime& machine, int record, const std::vector<mesh::Pose>& poses) const {
  if (!each_.empty()) return each_[record].deviations(machine, 0, poses);
  const auto seen = [](const auto& error_at, const mesh::Pose& pose) {
    return Eigen::VectorXd(error_at(pose).error.template head<3>() / core::units::um);
  };
  MatrixXd rows(3 * std::ssize(poses), model_.system.order());
  for (Index k = 0; k < std::ssize(poses); ++k) {
    rows.middleRows(3 * k, 3) =
        sides_at(model_.machine, poses[k], 3, seen) * reduction::side_rows(model_.machine, model_.outputs, poses[k]);
  }
  std::vector<Variant> none;
  return run(machine, none, Rows{rows, {}, {}, {}, {}}).front();
}

MatrixXd Response::elsewhere(const MachineInTime& machine, const std::vector<mesh::Pose>& poses) const {
  if (!each_.empty()) return below(each_, [&](const Response& one) { return one.elsewhere(machine, poses); });
  const Index r = model_.system.order(), sensors = std::ssize(model_.machine.sensors);
  // Expansions and stiffnesses act on the output rows alone.
  std::optional<reduction::ReducedModel> changed;
  if (has_parts() &&
      part_changes(model_.machine, machine).differs_in_rows(part_changes(model_.machine, model_.machine)))
    changed = model_of_changed(model_, machine);
  const reduction::ReducedModel& outputs = changed ? *changed : model_;
  MatrixXd rows(sensors + 3 * std::ssize(poses), r);
  rows.topRows(sensors) = model_.system.sensors.topRows(sensors);
  for (Index k = 0; k < std::ssize(poses); ++k) {
    for (Index i = 0; i < r; ++i)
      rows.block(sensors + 3 * k, i, 3, 1) = 1e6 * outputs.tcp(VectorXd::Unit(r, i), poses[k]).error.head<3>();
  }
  std::vector<Variant> none;
  MatrixXd values = run(machine, none, Rows{rows, {}, {}, {}, {}}).front();
  for (Index s = 0; s < sensors; ++s) values.col(s).array() += machine.reference_C + machine.sensors[s].offset;
  return values;
}

}  // namespace thermotwin::diagnosis
