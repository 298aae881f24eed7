// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response.h"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <list>
#include <memory>
#include <optional>

#include "compensation/evaluate.h"
#include "core/error.h"
#include "core/thread_pool.h"
#include "diagnosis/readings.h"
#include "solver/simulation.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t tangents_in_block = 48;  ///< fixed, so that results do not depend on threads

/// One machine's way from channels to coefficients, with its chillers.
struct Drive {
  solver::OperatingModel model;
  VectorXd sensor_offsets;
  std::optional<solver::Chiller> chiller;
  solver::Coefficients c;

  Drive(const mesh::Machine& machine, const solver::Layout& layout) : model(machine, layout) {
    sensor_offsets = solver::sensor_offsets(machine, layout);
  }
  /// The row with one ambient's temperature moved.
  VectorXd disturbed(const VectorXd& row, int ambient, double by_K) const {
    VectorXd moved = row;
    const mesh::AmbientSpec& spec = model.machine().ambients[static_cast<std::size_t>(ambient)];
    double& channel = moved[model.channels().index(spec.id + ".T_C")];
    // One that follows gets a temperature of its own.
    if (!std::isfinite(channel)) channel = model.ambient_K(ambient, row) + model.machine().reference_C;
    channel += by_K;
    return moved;
  }
  /// @param sensors_K (sensors) temperatures at the sensors, without their offsets
  void update(const VectorXd& row, const VectorXd& sensors_K, double step) {
    const VectorXd readings = sensors_K + sensor_offsets, guide = model.guide_K(row);
    if (!chiller)
      chiller.emplace(model.machine(), model.layout(), model.channels(),
                      solver::chiller_set_points(model.machine(), model.layout(), readings, guide));
    model.coefficients(row, chiller->advance(row, readings, guide, step), readings, c);
  }
};

/// The last few factors of E + gamma h A: programs alternate between a few states.
class Factors {
 public:
  Factors(const reduction::ReducedSystem& system, const MatrixXd& capacity) : system_(system), capacity_(capacity) {}

  struct Entry {
    VectorXd p;
    double step = 0;
    MatrixXd shifted_inverse;  ///< (E + gamma h A)^-1; products with it are faster than solves
  };
  const Entry& get(const VectorXd& p, double step) {
    for (auto at = kept_.begin(); at != kept_.end(); ++at)
      if (at->step == step && at->p == p) {
        kept_.splice(kept_.begin(), kept_, at);
        return kept_.front();
      }
    if (kept_.size() >= 6) kept_.pop_back();
    Entry& entry = kept_.emplace_front();
    entry.p = p;
    entry.step = step;
    MatrixXd shifted = system_.conduction;
    for (Index j = 0; j < p.size(); ++j)
      if (p[j] != 0.0) shifted += p[j] * system_.terms[static_cast<std::size_t>(j)];
    shifted = capacity_ + solver::sdirk_gamma * step * shifted;
    entry.shifted_inverse = Eigen::PartialPivLU<MatrixXd>(shifted).inverse();
    return entry;
  }

 private:
  const reduction::ReducedSystem& system_;
  const MatrixXd& capacity_;
  std::list<Entry> kept_;
};

/// Rows of the observed channels for one set of outputs. The error is linear in the state: its row is
/// what it says to each unit state. The zero is the observation's affair.
MatrixXd rows_of(const reduction::ReducedModel& model, const std::vector<ObservedChannel>& channels, bool with_sensors) {
  const Index r = model.system.order();
  MatrixXd rows = MatrixXd::Zero(static_cast<Index>(channels.size()), r);
  for (Index k = 0; k < rows.rows(); ++k) {
    compensation::MeasuredChannel channel = channels[static_cast<std::size_t>(k)].channel;
    if (channel.kind == compensation::ChannelKind::temperature) {
      if (with_sensors) rows.row(k) = model.system.sensors.row(model.machine.sensor_index(channel.sensor));
      continue;
    }
    channel.zero = compensation::Zero::absolute;
    const mesh::Pose pose = channel.pose_text.empty()
                                ? mesh::home_pose(model.machine)
                                : mesh::parse_pose(model.machine, channel.pose_text, "channel " + channel.id);
    std::vector<solver::TcpError> errors;
    for (Index i = 0; i < r; ++i) errors.push_back(model.tcp(VectorXd::Unit(r, i), pose));
    rows.row(k) = compensation::quantity_series(errors, channel).transpose();
  }
  return rows;
}

}  // namespace

struct Response::Variant {
  mesh::Machine machine;
  double start_K = 0;  ///< added to the uniform start
  double step = 1;     ///< of the parameter, divides the result
  std::optional<Disturbance> disturbance;
};

namespace {

double height(const Disturbance& d, double time) {
  if (time <= d.from || time >= d.to) return time == d.peak ? 1.0 : 0.0;
  return time < d.peak ? (time - d.from) / (d.peak - d.from) : (d.to - time) / (d.to - d.peak);
}

}  // namespace

mesh::Machine with_parameters(const mesh::Machine& base, const std::vector<Parameter>& parameters,
                              const VectorXd& values) {
  mesh::Machine machine = base;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (values[static_cast<Index>(i)] != parameters[i].nominal)
      machine = with_parameter(machine, parameters[i], values[static_cast<Index>(i)]);
  return machine;
}

MatrixXd Response::Rows::of(const PartChanges& changes) const {
  MatrixXd rows = base;
  const auto add = [&](const std::vector<MatrixXd>& parts, const VectorXd& amounts) {
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (const double amount = amounts[static_cast<Index>(i)]; amount != 0.0) rows += amount * parts[i];
  };
  add(bodies, changes.bodies);
  add(scales, changes.scales);
  add(screws, changes.screws);
  add(stiffness, changes.stiffness);
  return rows;
}

Response::Response(const reduction::ReducedModel& model, const Observations& observations, const Parts* parts)
    : model_(model), observations_(observations), parts_(parts), rows_(observed_rows()) {
  const mesh::Machine& machine = model.machine;
  air_.setConstant(observations.points.size(), machine.reference_C);
  const int air = machine.ambient_index("air");
  if (air < 0) return;
  const solver::OperatingModel operating(machine, model.system.layout);
  for (Index i = 0; i < air_.size(); ++i)
    air_[i] += operating.ambient_K(air, observations.rows.row(std::min(i, observations.rows.rows() - 1)).transpose());
}

Response::Rows Response::observed_rows() const {
  Rows rows;
  rows.base = rows_of(model_, observations_.channels, true);
  if (!parts_) return rows;
  reduction::ReducedModel part = model_;
  const auto all_of = [&](const std::vector<reduction::ReducedOutputs>& outputs) {
    std::vector<MatrixXd> all;
    for (const reduction::ReducedOutputs& output : outputs) {
      part.outputs = output;
      all.push_back(rows_of(part, observations_.channels, false));
    }
    return all;
  };
  rows.bodies = all_of(parts_->bodies);
  rows.scales = all_of(parts_->scales);
  rows.screws = all_of(parts_->screws);
  rows.stiffness = all_of(parts_->stiffness);
  return rows;
}

MatrixXd Response::capacity_of(const mesh::Machine& machine) const {
  MatrixXd capacity = model_.system.capacity;
  if (!parts_) return capacity;
  const VectorXd changes = part_changes(model_.machine, machine).capacity;
  for (std::size_t b = 0; b < parts_->capacity.size(); ++b)
    if (const double change = changes[static_cast<Index>(b)]; change != 0.0) capacity += change * parts_->capacity[b];
  return capacity;
}

std::vector<MatrixXd> Response::run(const mesh::Machine& machine, const std::vector<Variant>& variants,
                                    const Rows& all_rows) const {
  const reduction::ReducedSystem& system = model_.system;
  const MatrixXd rows = all_rows.of(part_changes(model_.machine, machine)), capacity = capacity_of(machine);
  const Observations& obs = observations_;
  const Index r = system.order(), points = obs.points.size(), m = static_cast<Index>(variants.size());
  Drive nominal(machine, system.layout);
  std::vector<std::unique_ptr<Drive>> drives;
  for (const Variant& variant : variants)
    drives.push_back(std::make_unique<Drive>(variant.machine, system.layout));

  VectorXd state = system.one_kelvin * (obs.start_C - machine.reference_C);
  MatrixXd tangent = MatrixXd::Zero(r, m);  // in units of each variant's step
  for (Index v = 0; v < m; ++v)
    tangent.col(v) = system.one_kelvin * variants[static_cast<std::size_t>(v)].start_K;

  // What differs in the matrices themselves, by variant; mostly nothing.
  std::vector<MatrixXd> row_change(static_cast<std::size_t>(m)), capacity_change(static_cast<std::size_t>(m));
  for (std::size_t v = 0; parts_ && v < variants.size(); ++v) {
    const PartChanges there = part_changes(model_.machine, variants[v].machine), here = part_changes(model_.machine, machine);
    if ((there.capacity.array() != here.capacity.array()).any()) capacity_change[v] = capacity_of(variants[v].machine) - capacity;
    if (there.any_rows() || here.any_rows()) {
      MatrixXd change = all_rows.of(there) - rows;
      if ((change.array() != 0.0).any()) row_change[v] = std::move(change);
    }
  }

  std::vector<MatrixXd> out(static_cast<std::size_t>(m) + 1, MatrixXd(points, rows.rows()));
  const auto record = [&](Index point) {
    out[0].row(point) = (rows * state).transpose();
    const MatrixXd all = rows * tangent;
    for (Index v = 0; v < m; ++v) {
      const auto at = static_cast<std::size_t>(v);
      out[at + 1].row(point) = all.col(v).transpose();
      if (row_change[at].size() > 0) out[at + 1].row(point) += (row_change[at] * state).transpose();
    }
  };
  record(0);

  Factors factors(system, capacity);
  const std::size_t terms = system.terms.size();
  MatrixXd forcing(r, m), heat_change(r, m), right(r, m + 1), stage(r, m + 1);
  std::vector<VectorXd> image(terms);  // K_j x of the present stage, where a variant asks for it
  std::vector<char> known(terms);
  constexpr double gamma = solver::sdirk_gamma, share = (1.0 - gamma) / gamma;

  for (Index s = 0; s + 1 < points; ++s) {
    const double step = obs.points[s + 1] - obs.points[s];
    const VectorXd row = obs.rows.row(s).transpose();
    const VectorXd sensors = system.sensors * state;
    nominal.update(row, sensors, step);
    for (Index v = 0; v < m; ++v) {
      Drive& drive = *drives[static_cast<std::size_t>(v)];
      const auto& disturbance = variants[static_cast<std::size_t>(v)].disturbance;
      const double by_K = disturbance ? height(*disturbance, 0.5 * (obs.points[s] + obs.points[s + 1])) : 0.0;
      drive.update(by_K != 0.0 ? drive.disturbed(row, disturbance->ambient, by_K) : row,
                   sensors + system.sensors * tangent.col(v), step);
      heat_change.col(v).setZero();
      for (Index k = 0; k < drive.c.q.size(); ++k)
        if (const double change = drive.c.q[k] - nominal.c.q[k]; change != 0.0)
          heat_change.col(v) += change * system.inputs.col(k);
    }
    const VectorXd heat = system.inputs * nominal.c.q;
    const Factors::Entry& factor = factors.get(nominal.c.p, step);
    const double scale = gamma * step;
    // A' x of a stage, for all variants; each K_j x once.
    const auto forcing_at = [&](const VectorXd& x, const VectorXd& before) {
      std::fill(known.begin(), known.end(), 0);
      forcing = heat_change;
      for (Index v = 0; v < m; ++v) {
        const VectorXd& p = drives[static_cast<std::size_t>(v)]->c.p;
        for (Index j = 0; j < p.size(); ++j) {
          const double change = p[j] - nominal.c.p[j];
          if (change == 0.0) continue;
          const auto term = static_cast<std::size_t>(j);
          if (!known[term]) image[term].noalias() = system.terms[term] * x, known[term] = 1;
          forcing.col(v) -= change * image[term];
        }
        if (const MatrixXd& change = capacity_change[static_cast<std::size_t>(v)]; change.size() > 0)
          forcing.col(v) -= change * (x - before) / scale;
      }
    };
    const auto solve_stage = [&](const VectorXd& x, const MatrixXd& x_tangent) {
      right.col(0) = capacity * x + scale * heat;
      stage.col(0).noalias() = factor.shifted_inverse * right.col(0);
      if (m == 0) return;
      forcing_at(stage.col(0), x);
      right.rightCols(m).noalias() = capacity * x_tangent;
      right.rightCols(m) += scale * forcing;
      stage.rightCols(m).noalias() = factor.shifted_inverse * right.rightCols(m);
    };
    solve_stage(state, tangent);
    const VectorXd next = state + share * (stage.col(0) - state);
    const MatrixXd next_tangent = tangent + share * (stage.rightCols(m) - tangent);
    solve_stage(next, next_tangent);
    state = stage.col(0);
    tangent = stage.rightCols(m);
    record(s + 1);
  }
  if (!state.allFinite() || !tangent.allFinite())
    throw core::SolverError(
        "diagnosis: the reduced model's state is no longer finite; look for NaN in the measured inputs");
  return out;
}

MatrixXd Response::records(const mesh::Machine& machine, const MatrixXd& states) const {
  MatrixXd result(states.rows(), states.cols());
  for (Index k = 0; k < states.cols(); ++k) {
    const ObservedChannel& observed = observations_.channels[static_cast<std::size_t>(k)];
    VectorXd values = states.col(k);
    if (observed.is_temperature()) {
      values.array() += machine.reference_C;
      values = sensor_readings(machine.sensors[static_cast<std::size_t>(machine.sensor_index(observed.channel.sensor))],
                               observations_.points, air_, values);
    }
    result.col(k) = recorded(machine, observed.channel.id, observed.is_temperature() ? "temperature" : "displacement",
                             observations_.points, std::move(values));
  }
  return result;
}

VectorXd Response::stack(const MatrixXd& at_points) const {
  VectorXd all(observations_.size());
  Index at = 0;
  for (std::size_t k = 0; k < observations_.channels.size(); ++k) {
    const ObservedChannel& channel = observations_.channels[k];
    all.segment(at, channel.size()) = channel.means(at_points.col(static_cast<Index>(k)));
    at += channel.size();
  }
  return all;
}

MatrixXd Response::at_points(const mesh::Machine& machine) const {
  return records(machine, run(machine, {}, rows_).front());
}

MatrixXd Response::states(const mesh::Machine& machine) const { return run(machine, {}, rows_).front(); }

VectorXd Response::read(const mesh::Machine& machine, const MatrixXd& states) const { return stack(records(machine, states)); }

VectorXd Response::predict(const mesh::Machine& machine) const { return stack(at_points(machine)); }

Response::Linear Response::linearise(const mesh::Machine& base, const std::vector<Parameter>& parameters,
                                     const VectorXd& values, bool with_start,
                                     const std::vector<Disturbance>& disturbances) const {
  const auto count = parameters.size();
  assert(static_cast<std::size_t>(values.size()) == count);
  const mesh::Machine machine = with_parameters(base, parameters, values);
  std::vector<Variant> variants;
  struct Reading { mesh::Machine above, below; double width; };
  std::vector<Reading> of_readings;
  std::vector<Index> place, place_of_readings;  // column of each
  for (std::size_t i = 0; i < count; ++i) {
    const double step = parameters[i].step;
    const auto at = static_cast<Index>(i);
    VectorXd moved = values;
    if (acts_on_readings(parameters[i].kind)) {
      // Both sides: the straight lines between the points of a late series have corners.
      moved[at] = std::min(values[at] + step, parameters[i].high);
      const mesh::Machine above = with_parameters(base, parameters, moved);
      const double high = moved[at];
      moved[at] = std::max(values[at] - step, parameters[i].low);
      of_readings.push_back({above, with_parameters(base, parameters, moved), high - moved[at]});
      place_of_readings.push_back(at);
      continue;
    }
    moved[at] += step;
    variants.push_back({with_parameters(base, parameters, moved), 0.0, step, std::nullopt});
    place.push_back(at);
  }
  const auto total = static_cast<Index>(count + disturbances.size() + (with_start ? 1 : 0));
  for (Index i = static_cast<Index>(count); i < total; ++i) place.push_back(i);
  for (const Disturbance& disturbance : disturbances) variants.push_back({machine, 0.0, 1.0, disturbance});
  if (with_start) variants.push_back({machine, 1.0, 1.0, std::nullopt});

  Linear result;
  MatrixXd columns(observations_.size(), total);
  MatrixXd states, here;  // of block 0
  const std::size_t blocks =
      std::max<std::size_t>(1, (variants.size() + tangents_in_block - 1) / tangents_in_block);
  core::parallel_for(0, blocks, [&](std::size_t block) {
    const std::size_t first = block * tangents_in_block,
                      last = std::min(first + tangents_in_block, variants.size());
    const std::vector<Variant> part(variants.begin() + static_cast<std::ptrdiff_t>(first),
                                    variants.begin() + static_cast<std::ptrdiff_t>(last));
    const std::vector<MatrixXd> out = run(machine, part, rows_);
    const MatrixXd read = records(machine, out[0]);
    for (std::size_t i = first; i < last; ++i) {
      const MatrixXd there = records(variants[i].machine, out[0] + out[i - first + 1]);
      columns.col(place[i]) = stack((there - read) / variants[i].step);
    }
    if (block == 0) states = out[0], here = read;
  });
  core::parallel_for(0, of_readings.size(), [&](std::size_t i) {
    columns.col(place_of_readings[i]) =
        stack((records(of_readings[i].above, states) - records(of_readings[i].below, states)) / of_readings[i].width);
  });
  result.predicted = stack(here);
  result.sensitivity = columns.leftCols(static_cast<Index>(count));
  result.disturbed = columns.middleCols(static_cast<Index>(count), static_cast<Index>(disturbances.size()));
  if (with_start) result.start = columns.col(total - 1);
  return result;
}

MatrixXd Response::elsewhere(const mesh::Machine& machine, const std::vector<mesh::Pose>& poses) const {
  const Index r = model_.system.order(), sensors = static_cast<Index>(model_.machine.sensors.size());
  MatrixXd rows(sensors + 3 * static_cast<Index>(poses.size()), r);
  rows.topRows(sensors) = model_.system.sensors.topRows(sensors);
  for (std::size_t k = 0; k < poses.size(); ++k)
    for (Index i = 0; i < r; ++i)
      rows.block(sensors + 3 * static_cast<Index>(k), i, 3, 1) =
          1e6 * model_.tcp(VectorXd::Unit(r, i), poses[k]).error.head<3>();
  MatrixXd values = run(machine, {}, Rows{rows, {}, {}, {}, {}}).front();
  for (Index s = 0; s < sensors; ++s)
    values.col(s).array() += machine.reference_C + machine.sensors[static_cast<std::size_t>(s)].offset;
  return values;
}

}  // namespace thermotwin::diagnosis
