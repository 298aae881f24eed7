// SPDX-License-Identifier: GPL-3.0-or-later
#include "specimen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "compensation/measurement/channel.h"
#include "compensation/measurement/virtual_measurement.h"
#include "core/range.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/machine_value.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/record/diagnose_options.h"
#include "faulty_readings.h"
#include "mesh/machine/finer_pads.h"
#include "mesh/machine/kinematics.h"
#include "own_footprint.h"
#include "solver/campaign/case.h"
#include "solver/campaign/simulation.h"
#include "solver/elastic/tcp.h"
#include "solver/operation/layout.h"
#include "solver/thermal/adaptive.h"
#include "solver/thermal/fluid_assembly.h"
#include "wrong_parts.h"

namespace thermotwin::hidden {

using compensation::ChannelKind;
using diagnosis::Kind;
using compensation::MeasuredChannel;
using compensation::Measurement;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double hour = 3600.0;
constexpr const char* quantities[] = {"dx", "dy", "dz"};

/// Materials of the specimen; what a coefficient is comes anew with every set.
mesh::Machine with_own_materials(const mesh::Machine& machine, std::uint64_t seed) {
  const mesh::Machine other = compensation::perturbed(machine, seed);
  mesh::Machine result = machine;
  result.materials = other.materials;
  for (std::size_t i = 0; i < result.joints.size(); ++i) {
    result.joints[i].stiffness_normal = other.joints[i].stiffness_normal;
    result.joints[i].stiffness_tangential = other.joints[i].stiffness_tangential;
  }
  result.scales = other.scales;
  result.screws = other.screws;
  return result;
}

/// What the model of the machine simplifies is not simplified in what is measured.
solver::Case measured_case(solver::Case machine_case, const SpecimenOptions& options) {
  machine_case.machine = mesh::with_finer_pads(std::move(machine_case.machine), options.finer_pads);
  if (options.exact_radiation)
    for (mesh::FilmSpec& film : machine_case.machine.films) film.exact_radiation = film.emissivity.value > 0.0;
  return machine_case;
}

/// A control knows speeds, positions, states, the air; of the other surroundings, and of powers, what the load sets is
/// recorded: heat of the cut that nobody records would be a hidden effect.
bool is_sent(const std::string& name, const mesh::Machine& machine, const solver::Channels& channels,
             const std::vector<VectorXd>& rows) {
  const auto surroundings = [&](const auto& items) {
    return std::any_of(items.begin(), items.end(), [&](const auto& item) { return name == item.id + ".T_C"; });
  };
  if (surroundings(machine.ambients) || surroundings(machine.volumes)) {
    const int index = channels.index(name);
    const double unset = channels.defaults()[index];
    return name == "air.T_C" || std::any_of(rows.begin(), rows.end(), [&](const VectorXd& row) {
             return std::isfinite(row[index]) && row[index] != unset;
           });
  }
  using compensation::Quantity;
  // Of the surroundings' temperatures that are left, those of coolant inlets.
  const Quantity quantity = compensation::channel_named(name).quantity;
  if (quantity == Quantity::power) {
    const int index = channels.index(name);
    return std::any_of(rows.begin(), rows.end(), [&](const VectorXd& row) { return std::isfinite(row[index]); });
  }
  return quantity != Quantity::temperature && quantity != Quantity::gradient;
}

std::vector<VectorXd> rows_of(const solver::LoadProgram& program, double refine) {
  std::vector<VectorXd> rows;
  double from = 0.0;
  for (const double to : program.step_ends(refine)) rows.push_back(program.row(from, to)), from = to;
  return rows;
}

/// Steps of a record's row with error control: shorter by halves until the estimate, which falls with their cube, is
/// below the tolerance.
/// Where it was far below and no coefficient or input has changed by 5 % since, only every fourth step takes one.
class Steps {
public:
  Steps(const solver::ThermalSystem& system, double longest, const SpecimenOptions& options)
      : integrator_(system, {.tolerance = options.solved_to, .single_precision = options.solved_to > 1e-6}),
        size_(longest),
        tolerance_K_(options.tolerance_K) {}

  void advance(VectorXd& state, const solver::Coefficients& c, double span) {
    constexpr double shortest_s = 1.0;
    const std::array<VectorXd, 3> heat{c.q, c.q, c.q};
    solver::AdaptiveIntegrator::Step step;
    for (double left = span; left > 1e-9 * span;) {
      // Whole shares of the row, so that factors come again.
      const double parts = std::exp2(std::ceil(std::log2(span / std::min(size_, span)) - 1e-9)),
                   size = std::min(span / parts, left);
      if (integrator_.is_nonlinear()) integrator_.linearise(state, state, c);
      const bool estimated = !known_good(c, size);
      integrator_.attempt(state, c.p, heat, size, true, step, estimated);
      if (estimated && step.error_K > tolerance_K_ && size > shortest_s) {
        const double halvings = std::clamp(std::ceil(std::log2(step.error_K / tolerance_K_) / 3.0), 1.0, 4.0);
        size_ = std::max(size * std::exp2(-halvings), shortest_s);
        seen_.reset();
        continue;
      }
      state = step.end;
      left -= size;
      if (!estimated) {
        ++seen_->steps;
        continue;
      }
      seen_ = {c, size, step.error_K, 0};
      if (step.error_K < tolerance_K_ / 10.0) size_ = 2.0 * size;
    }
  }

private:
  struct Estimate {
    solver::Coefficients c;
    double size, error_K;
    int steps;
  };

  bool known_good(const solver::Coefficients& c, double size) const {
    const auto alike = [](const VectorXd& now, const VectorXd& then) {
      return ((now - then).array().abs() <= 0.05 * now.array().abs().max(then.array().abs())).all();
    };
    return seen_ && seen_->steps < 3 && seen_->error_K < 0.25 * tolerance_K_ && size <= seen_->size * (1.0 + 1e-9) &&
           alike(c.p, seen_->c.p) && alike(c.q, seen_->c.q);
  }

  solver::AdaptiveIntegrator integrator_;
  double size_, tolerance_K_;
  std::optional<Estimate> seen_;  ///< the last one, and the steps since
};

}  // namespace

double Random::normal() { return std::sqrt(-2.0 * std::log(uniform())) * std::cos(2.0 * std::numbers::pi * uniform()); }

void SpecimenOptions::validate() const {
  for (const auto& [name, value] : {std::pair{"size_factor", size_factor},
                                    {"refine", refine},
                                    {"tolerance_K", tolerance_K},
                                    {"solved_to", solved_to}})
    core::require_option(value > 0, std::string("specimen ") + name, value, "a positive number");
  for (const auto& [name, value] : {std::pair{"noise_K", noise_K}, {"noise_um", noise_um}})
    core::require_option(value >= 0, std::string("specimen ") + name, value, "a number, not negative");
  core::require_option(finer_pads >= 1, "specimen finer_pads", finer_pads, "a whole number from 1");
  core::require_option(missing_share >= 0 && missing_share < 1, "specimen missing_share", missing_share,
                       "0 to less than 1");
}

Specimen::Specimen(const solver::Case& machine_case, const SpecimenOptions& options)
    : case_(measured_case(machine_case, options)),
      options_((options.validate(), options)),
      full_(solver::build_full_model(with_own_materials(case_.machine, options.seed),
                                     {options.size_factor, options.cache})) {
  poses_.push_back(mesh::home_pose(case_.machine));
  for (const mesh::Pose& pose : case_.check_points)
    if (poses_.size() < 4) poses_.push_back(pose);
  measured_poses_ = poses_.size();
  // Two more within the workspace, those of the machine's seed.
  Random random(options.seed * 31 + 7);
  for (int i = 0; i < 2; ++i) {
    mesh::Pose pose = mesh::home_pose(case_.machine);
    for (std::size_t a = 0; a < case_.machine.axes.size(); ++a) {
      if (const mesh::Axis& axis = case_.machine.axes[a]; !axis.endless)
        pose[a] = axis.low + (axis.high - axis.low) * random.uniform(0.1, 0.9);
    }
    poses_.push_back(pose);
  }
  for (const mesh::Pose& pose : poses_) rows_.push_back(full_.elastic.output_rows(pose));
}

VectorXd Specimen::air_beside(const mesh::SensorSpec& sensor, const mesh::Machine& machine, const Run& run) const {
  std::string id = "air";
  double nearest = 1e300;
  for (const mesh::FilmSpec& film : machine.films) {
    for (const std::string& name : film.surfaces) {
      const int surface = machine.surface_index(name);
      if (machine.surfaces[surface].body != sensor.body) continue;
      const mesh::TetMesh& body = full_.mesh.body_of_surface(surface);
      for (const int face : full_.mesh.surfaces[surface]) {
        const double distance = (body.face_centre(face) - sensor.point).norm();
        if (distance < nearest) nearest = distance, id = film.ambient;
      }
    }
  }
  if (const int volume = machine.volume_index(id); volume >= 0) return run.volumes.col(volume);
  const int index = solver::Channels(machine).index(id + ".T_C");
  return index >= 0 ? VectorXd(run.rows.col(index)) : VectorXd::Constant(run.time.size(), machine.reference_C);
}

Measurement Specimen::described(const std::string& load, std::size_t poses) const {
  Measurement m;
  const std::vector<VectorXd> rows = rows_of(case_.load(load), options_.refine);
  const auto add = [&](MeasuredChannel channel) {
    channel.column = std::ssize(m.channels) + 1;
    m.channels.push_back(std::move(channel));
  };
  const solver::Channels channels(case_.machine);
  for (const std::string& name : channels.names()) {
    if (!is_sent(name, case_.machine, channels, rows)) continue;
    MeasuredChannel channel;
    channel.id = channel.input = name;
    const compensation::Channel input = compensation::channel_named(name);
    channel.kind = input.kind;
    channel.unit = input.unit;
    if (channel.kind == ChannelKind::temperature) channel.uncertainty = options_.noise_K;
    add(std::move(channel));
  }
  for (const mesh::SensorSpec& sensor : case_.machine.sensors) {
    MeasuredChannel channel;
    channel.id = channel.sensor = sensor.id;
    channel.kind = ChannelKind::temperature;
    channel.unit = "degC";
    channel.uncertainty = options_.noise_K;
    add(std::move(channel));
  }
  for (std::size_t p = 0; p < poses; ++p) {
    for (const char* quantity : quantities) {
      MeasuredChannel channel;
      channel.id = quantity + std::string("@") + std::to_string(p + 1);
      channel.kind = ChannelKind::displacement;
      channel.unit = "um";
      channel.uncertainty = options_.noise_um;
      channel.quantity = quantity;
      channel.pose_text = mesh::format_pose(case_.machine, poses_[p]);
      channel.zero = compensation::Zero::first;
      add(std::move(channel));
    }
  }
  m.data.source = "data.csv";
  m.data.columns = {"time_s"};
  for (const MeasuredChannel& channel : m.channels) m.data.columns.push_back(channel.id);
  m.folder = "hidden";
  return m;
}

Measurement Specimen::blank(const std::string& load) const {
  Measurement m = described(load, measured_poses_);
  m.data.values.setZero(1, std::ssize(m.data.columns));
  return m;
}

VectorXd Specimen::warmth_at(const std::string& body, const Eigen::Vector3d& centre) const {
  return warm_spot(full_, body, centre);
}

double Specimen::diagonal() const {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
  for (const mesh::TetMesh& body : full_.mesh.bodies) {
    low = low.cwiseMin(body.points.rowwise().minCoeff());
    high = high.cwiseMax(body.points.rowwise().maxCoeff());
  }
  return (high - low).norm();
}

std::vector<Followable> Specimen::followable(const std::string& load) const {
  const std::vector<VectorXd> rows = rows_of(case_.load(load), 1.0);
  const solver::Channels channels(case_.machine);
  std::vector<Followable> found{{"machine.on", 1.0}};
  for (const MeasuredChannel& channel : described(load, 0).channels) {
    if (channel.input == "machine.on" || (channel.kind != ChannelKind::speed && channel.kind != ChannelKind::state))
      continue;
    double low = 1e300, high = 0.0;
    for (const VectorXd& row : rows) {
      const double value = row[channels.index(channel.input)], size = std::isfinite(value) ? std::abs(value) : 0.0;
      low = std::min(low, size), high = std::max(high, size);
    }
    if (high > 0.0 && high - low > 0.01 * high) found.push_back({channel.input, high});
  }
  return found;
}

/// A machine of the type: coefficients drawn anew, materials those of the specimen.
mesh::Machine Specimen::machine_of(std::uint64_t seed) const {
  mesh::Machine machine = compensation::perturbed(case_.machine, seed);
  const mesh::Machine& own = full_.mesh.machine;
  machine.materials = own.materials;
  machine.scales = own.scales;
  machine.screws = own.screws;
  for (std::size_t i = 0; i < machine.joints.size(); ++i) {
    machine.joints[i].stiffness_normal = own.joints[i].stiffness_normal;
    machine.joints[i].stiffness_tangential = own.joints[i].stiffness_tangential;
  }
  return machine;
}

Specimen::Run Specimen::run(const Draw& draw, const mesh::Machine& machine, const std::vector<mesh::Pose>& poses,
                            Random& random, OutsideEffect& outside) const {
  const solver::LoadProgram load = case_.load(draw.load);
  mesh::Machine wrong = machine;
  std::vector<const Truth*> spots;
  for (const Truth& truth : draw.truths) {
    if (truth.parameter.missing)
      spots.push_back(&truth);
    else if (!diagnosis::needs_parts(truth.parameter.kind) && !diagnosis::acts_on_readings(truth.parameter.kind))
      wrong = diagnosis::with_parameter(wrong, truth.parameter, truth.value);
  }
  const solver::Layout& layout = full_.thermal.layout;
  const solver::OperatingModel right_model(machine, layout), wrong_model(wrong, layout);
  const solver::Channels& channels = right_model.channels();

  const VectorXd uneven = unevenness(full_, random.uniform(0.0, 6.28));
  const double phase = random.uniform(0.0, 6.28), period = random.uniform(5.0, 11.0) * hour;
  const auto size_at = [&](double time) {
    return 1.0 + 0.15 * std::sin(2.0 * std::numbers::pi * time / period + phase);
  };
  const double bend = random.uniform(0.85, 1.15);  // heat follows a power of its input
  // Rows between those of the run are interpolated: the run is finer then.
  const std::vector<double> ends =
      load.step_ends(options_.rows == Rows::sparse ? 0.25 * options_.refine : options_.refine);
  std::vector<VectorXd> some_rows;
  for (std::size_t s = 0; s < ends.size(); s += 3) some_rows.push_back(load.row(s > 0 ? ends[s - 1] : 0.0, ends[s]));
  OwnFootprint footprint(full_, right_model, wrong_model, some_rows, spots, uneven);
  const WrongParts parts = wrong_parts(full_, draw.truths, poses, rows_, uneven);
  if (parts.capacity.size() > 0) footprint.add_capacity(parts.capacity);
  const solver::ThermalSystem& thermal = footprint.system();

  Steps stepper(thermal, ends.front(), options_);
  VectorXd state = VectorXd::Constant(thermal.size, load.initial_C() - machine.reference_C);
  const VectorXd offsets = solver::sensor_offsets(machine, layout);
  const auto readings = [&] { return VectorXd(thermal.sensors * state + offsets); };
  const VectorXd first_row = load.row(0.0, ends.front());
  solver::Chiller right_chiller(
      machine, layout, channels,
      solver::chiller_set_points(machine, layout, readings(), right_model.guide_K(first_row)));
  solver::Chiller wrong_chiller(wrong, layout, channels,
                                solver::chiller_set_points(wrong, layout, readings(), wrong_model.guide_K(first_row)));

  const auto steps = std::ssize(ends);
  const auto sensors = std::ssize(machine.sensors);
  Run run;
  run.time.resize(steps + 1);
  run.time << 0.0, Eigen::Map<const VectorXd>(ends.data(), steps);
  run.rows.resize(steps + 1, channels.size());
  run.temperatures.resize(steps + 1, sensors);
  run.errors.resize(steps + 1, 3 * std::ssize(poses));
  run.volumes.resize(steps + 1, std::ssize(machine.volumes));
  const solver::FluidNodes fluids(machine, thermal.nodes);
  const auto record = [&](Index i) {
    const double size = size_at(run.time[i]);
    run.temperatures.row(i) = ((thermal.sensors * state).head(sensors).array() + machine.reference_C).transpose();
    for (Index s = 0; s < sensors; ++s) run.temperatures(i, s) += machine.sensors[s].offset;
    for (Index v = 0; v < run.volumes.cols(); ++v) run.volumes(i, v) = state[fluids.volume(v)] + machine.reference_C;
    for (std::size_t p = 0; p < poses.size(); ++p) {
      const solver::OutputRows& r = rows_[p];
      VectorXd tool = r.tool * state, axis = r.table_axis * state, own = r.table_own * state;
      if (!parts.rows.empty()) {
        tool += size * (parts.rows[p].tool * state);
        axis += size * (parts.rows[p].table_axis * state);
        own += size * (parts.rows[p].table_own * state);
      }
      const solver::TcpError error = solver::tcp_error(machine, poses[p], tool, axis, own);
      run.errors.row(i).segment(3 * static_cast<Index>(p), 3) = 1e6 * error.error.head<3>().transpose();
    }
  };
  record(0);
  double sizes = 0.0, weights = 0.0;
  for (Index s = 0; s < steps; ++s) {
    const double from = run.time[s], to = run.time[s + 1], step = to - from;
    const VectorXd row = load.row(from, to), read = readings();
    run.rows.row(s) = row.transpose();
    const solver::Coefficients right =
        right_model.coefficients(row, right_chiller.advance(row, read, right_model.guide_K(row), step), read);
    const solver::Coefficients other =
        wrong_model.coefficients(row, wrong_chiller.advance(row, read, wrong_model.guide_K(row), step), read);
    const double size = size_at(0.5 * (from + to));
    double weight = step * ((other.q - right.q).cwiseAbs().sum() + (other.p - right.p).cwiseAbs().sum()),
           seen_size = size;
    VectorXd spot_W(std::ssize(spots));
    for (std::size_t i = 0; i < spots.size(); ++i) {
      const diagnosis::MissingSource& missing = *spots[i]->parameter.missing;
      const double value = row[channels.index(missing.follows)],
                   share = std::isfinite(value) ? std::abs(value) / missing.at : 0.0;
      spot_W[i] = spots[i]->value * size * std::pow(share, bend);
      if (spots[i] == &draw.truths.front())
        weight = step * share, seen_size = share > 0.0 ? size * std::pow(share, bend) / share : 1.0;
    }
    if (!draw.truths.empty() && diagnosis::needs_parts(draw.truths.front().parameter.kind))
      weight = step, seen_size = draw.truths.front().parameter.kind == Kind::heat_capacity ? 1.0 : size;
    sizes += weight * seen_size;
    weights += weight;
    solver::Coefficients c = footprint.coefficients(right, other, size, spot_W);
    outside.act(c, row, from, step);
    stepper.advance(state, c, step);
    record(s + 1);
  }
  run.rows.row(steps) = run.rows.row(steps - 1);
  if (weights > 0.0) run.mean_size = sizes / weights;
  return run;
}

/// What an effect amounts to against the nominal machine, where its size in the mean over the record was so much.
double Specimen::effective_value(const Truth& truth, const mesh::Machine& machine,
                                 const std::optional<double>& mean_size) const {
  if (truth.parameter.missing) return truth.value * mean_size.value_or(0.0);
  if (!mean_size || diagnosis::acts_on_readings(truth.parameter.kind)) return truth.value;
  mesh::Machine nominal = case_.machine, own = machine;
  const auto before = diagnosis::machine_values(nominal, truth.parameter).front(),
             here = diagnosis::machine_values(own, truth.parameter).front();
  const double changed = truth.parameter.nominal + (truth.value - truth.parameter.nominal) * *mean_size;
  return truth.parameter.ratio ? changed * *here.value / *before.value
                               : changed + (*here.value - *before.value) / here.per_unit;
}

Specimen::Run Specimen::logged(Run run, Rows rows, Random& random) {
  const Index all = run.time.size();
  const double end = run.time[all - 1];
  std::vector<double> times;
  if (rows == Rows::sparse) {
    for (double time = 0.0; time < end; time += random.uniform(240.0, 360.0)) times.push_back(time);
    times.push_back(end);
  } else if (rows == Rows::pauses) {
    // One in each half, so that they never meet.
    std::array<std::pair<double, double>, 2> pauses;
    for (std::size_t i = 0; i < pauses.size(); ++i) {
      const double length = std::min(random.uniform(1.5, 4.0) * hour, 0.3 * end),
                   from = 0.5 * end * i + random.uniform(0.05, 0.95) * (0.5 * end - length);
      pauses[i] = {from, from + length};
    }
    for (const double time : run.time) {
      if (std::none_of(pauses.begin(), pauses.end(), [&](const auto& p) { return time > p.first && time < p.second; }))
        times.push_back(time);
    }
  } else {
    return run;
  }
  Run kept = run;
  const auto count = std::ssize(times);
  kept.time = Eigen::Map<const VectorXd>(times.data(), count);
  for (MatrixXd Run::*values : {&Run::rows, &Run::temperatures, &Run::errors, &Run::volumes})
    (kept.*values).resize(count, (run.*values).cols());
  for (Index i = 0; i < count; ++i) {
    const double* next = std::upper_bound(run.time.data() + 1, run.time.data() + all - 1, times[i]);
    const Index right = next - run.time.data(), left = right - 1;
    const double share = std::min(1.0, (times[i] - run.time[left]) / (run.time[right] - run.time[left]));
    kept.rows.row(i) = run.rows.row(share < 1.0 ? left : right);  // inputs hold over a step
    for (MatrixXd Run::*values : {&Run::temperatures, &Run::errors, &Run::volumes})
      (kept.*values).row(i) = (1.0 - share) * (run.*values).row(left) + share * (run.*values).row(right);
  }
  return kept;
}

Record Specimen::record(const Draw& draw, Recording recording) const {
  const bool exact = recording == Recording::exact;
  const std::vector<mesh::Pose> poses(poses_.begin(), exact ? poses_.end() : poses_.begin() + measured_poses_);
  Random random(draw.seed),
      noise(draw.seed * 7919 + 5);  // of effects, of readings: two runs of a seed differ by the effect alone
  const mesh::Machine machine = machine_of(draw.seed);
  OutsideEffect outside(draw.outside, draw.outside_where, machine, full_.thermal.layout,
                        case_.load(draw.load).duration(), random);
  Random chance(draw.seed * 104729 + 11);
  const Run run = logged(this->run(draw, machine, poses, random, outside), exact ? Rows::own : options_.rows, chance);
  Record result;
  for (std::size_t i = 0; i < draw.truths.size();
       ++i) {  // the second one's size is not followed: it wanders about what was drawn
    result.effective.push_back(
        effective_value(draw.truths[i], machine, i == 0 ? run.mean_size : std::optional<double>(1.0)));
  }

  const VectorXd& time = run.time;
  const solver::Channels channels(machine);
  Measurement m = described(draw.load, poses.size());
  m.data.values.resize(time.size(), std::ssize(m.data.columns));
  m.data.values.col(0) = time;
  MatrixXd noiseless = m.data.values;
  Index pose_column = 0;
  for (const MeasuredChannel& channel : m.channels) {
    auto column = m.data.values.col(channel.column);
    if (!channel.input.empty()) {
      column = run.rows.col(channels.index(channel.input));
      noiseless.col(channel.column) = column;
      if (!exact && channel.kind == ChannelKind::temperature)
        for (double& value : column) value += options_.noise_K * noise.normal();
      continue;
    }
    const bool is_sensor = !channel.sensor.empty();
    VectorXd values = is_sensor ? VectorXd(run.temperatures.col(machine.sensor_index(channel.sensor)))
                                : VectorXd(run.errors.col(pose_column++));
    for (const Truth& truth : draw.truths) {
      if (!diagnosis::acts_on_readings(truth.parameter.kind)) continue;
      if (concerns(truth.parameter.where, channel))
        values =
            spoilt_reading(truth.parameter.kind, truth.value, time,
                           is_sensor ? air_beside(machine.sensors[machine.sensor_index(channel.sensor)], machine, run)
                                     : VectorXd::Zero(time.size()),
                           std::move(values));
    }
    if (is_sensor) values = outside.reading(channel.sensor, time, std::move(values));
    column = values;
    noiseless.col(channel.column) = values;
    if (exact) continue;
    const bool coarse = is_sensor && channel.column % 3 == 0;  // an older module: steps of 0.1 K
    for (double& value : values) {
      value += (is_sensor ? options_.noise_K : options_.noise_um) * noise.normal();
      if (coarse) value = 0.1 * std::round(10.0 * value);
      if (noise.uniform() < options_.missing_share) value = std::nan("");
    }
    column = values;
    noiseless.col(channel.column) = values.array().isNaN().select(values, noiseless.col(channel.column));
  }
  // Rows that a logger lost: sampling is irregular.
  std::vector<Index> kept{0};
  for (Index i = 1; i < time.size(); ++i)
    if (exact || noise.uniform() > 0.5 * options_.missing_share || i + 1 == time.size()) kept.push_back(i);
  m.data.values = m.data.values(kept, Eigen::all).eval();
  result.measurement = m;
  m.data.values = noiseless(kept, Eigen::all);
  result.noiseless = std::move(m);
  return result;
}

}  // namespace thermotwin::hidden
