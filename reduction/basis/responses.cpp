// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/responses.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/progress.h"
#include "core/range.h"
#include "core/units.h"
#include "reduction/basis/basis.h"
#include "reduction/linear/lapack.h"
#include "solver/operation/layout.h"
#include "solver/thermal/direct.h"

namespace thermotwin::reduction {
namespace {

constexpr double ambient_step_K = 5.0;
constexpr double gradient_step_K_m = 1.0;
constexpr double unknown_drive_W = 500.0;  ///< a source without laws: only measured power drives it
constexpr double rotation_lever_m = 0.3;
constexpr double sensor_length_m = 5e-6;  ///< a sensor's 1 K counts as much as 5 um at the TCP
constexpr Eigen::Index most_output_directions = 30;
constexpr double least_output_direction = 1e-3;

using solver::InputKind;
using solver::TermKind;

/// Of each axis between its ends; or all of it evenly.
struct Travel {
  double at = 0;
  bool whole = false;
};

struct AxisNames {
  std::string position, feed, low, high;
  double unit;  ///< SI length or angle of one
};

AxisNames names_of(const mesh::Axis& axis) {
  const bool linear = axis.kind == mesh::AxisKind::linear;
  const std::string unit = linear ? "mm" : "deg", stem = "axis." + axis.id + ".";
  return {stem + "position_" + unit, stem + "feed_" + unit + "_min", stem + "low_" + unit, stem + "high_" + unit,
          linear ? core::units::mm : core::units::deg};
}

void set(const solver::OperatingModel& model, Eigen::VectorXd& row, const std::string& name, double value) {
  if (const int index = model.channels().index(name); index >= 0) row(index) = value;
}

/// Axes that move only within limits; a table that turns on spends its time evenly anyway.
void set_travel(const solver::OperatingModel& model, Eigen::VectorXd& row, Travel travel) {
  for (const mesh::Axis& axis : model.machine().axes) {
    const AxisNames names = names_of(axis);
    const double low = axis.endless ? 0.0 : axis.low / names.unit;
    const double high = axis.endless ? 360.0 : axis.high / names.unit;
    const bool whole = travel.whole;
    set(model, row, names.low, whole ? low : solver::not_given);
    set(model, row, names.high, whole ? high : solver::not_given);
    set(model, row, names.position, low + (whole ? 0.5 : travel.at) * (high - low));
  }
}

/// @param share  of the largest speeds
void set_speeds(const solver::OperatingModel& model, Eigen::VectorXd& row, double share) {
  set(model, row, "spindle.speed_rpm", share * model.machine().spindle_max_rpm);
  for (const mesh::Axis& axis : model.machine().axes) {
    const AxisNames names = names_of(axis);
    set(model, row, names.feed, share * axis.rapid * core::units::minute / names.unit);
  }
}

void set_states(const solver::OperatingModel& model, Eigen::VectorXd& row, bool on) {
  const double value = on ? 1.0 : 0.0;
  set(model, row, "cutting_fluid.on", value);
  for (const mesh::FilmSpec& film : model.machine().films) {
    if (!film.state.empty()) set(model, row, film.state, value);
  }
  for (const std::string& door : model.machine().doors) set(model, row, "door." + door + ".open", value);
  for (const mesh::CoolantSpec& coolant : model.machine().coolants)
    set(model, row, "coolant." + coolant.id + ".on", value);
}

Eigen::VectorXd no_inlets(const solver::OperatingModel& model) {
  return Eigen::VectorXd::Zero(std::ssize(model.machine().coolants));
}

OperatingPoint make_point(const solver::OperatingModel& model, std::string name, Eigen::VectorXd row) {
  OperatingPoint point{std::move(name), std::move(row), {}};
  point.c = model.coefficients(point.row, no_inlets(model));
  return point;
}

/// Columns of the block that hold anything.
Eigen::MatrixXd without_empty_columns(const Eigen::MatrixXd& block) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index j = 0; j < block.cols(); ++j) {
    if (block.col(j).cwiseAbs().maxCoeff() > 0.0) kept.push_back(j);
  }
  return block(Eigen::all, kept);
}

Eigen::MatrixXd joined(const std::vector<Eigen::MatrixXd>& blocks, Eigen::Index rows) {
  Eigen::Index columns = 0;
  for (const Eigen::MatrixXd& block : blocks) columns += block.cols();
  Eigen::MatrixXd all(rows, columns);
  Eigen::Index at = 0;
  for (const Eigen::MatrixXd& block : blocks) {
    all.middleCols(at, block.cols()) = block;
    at += block.cols();
  }
  return all;
}

Eigen::MatrixXd columns_of(const std::vector<Eigen::VectorXd>& vectors, Eigen::Index rows) {
  Eigen::MatrixXd block(rows, std::ssize(vectors));
  for (std::size_t i = 0; i < vectors.size(); ++i) block.col(i) = vectors[i];
  return block;
}

/// q of one source when its laws give their most, at the axes' travel in the row.
Eigen::VectorXd hottest(const solver::OperatingModel& model, const solver::Layout& layout, int source,
                        Eigen::VectorXd row) {
  const mesh::SourceSpec& spec = model.machine().sources[source];
  for (const mesh::PowerLaw& law : spec.laws) {
    const auto most = std::max_element(law.power.begin(), law.power.end(),
                                       [](double a, double b) { return std::abs(a) < std::abs(b); });
    if (most != law.power.end()) set(model, row, law.input, law.at[most - law.power.begin()]);
  }
  for (const mesh::LossLaw& loss : spec.losses)
    solver::LossInput(model.machine(), model.channels(), loss).set_hottest(loss, model.machine(), row);
  if (spec.laws.empty() && spec.losses.empty()) set(model, row, spec.drive + ".power_W", unknown_drive_W);
  Eigen::VectorXd q = model.coefficients(row, no_inlets(model)).q;
  for (std::size_t k = 0; k < layout.inputs.size(); ++k) {
    const bool own = layout.inputs[k].kind == InputKind::source && layout.inputs[k].item == source;
    if (!own) q(k) = 0.0;
  }
  return q;
}

bool moves(const solver::Layout& layout, int source) {
  return std::any_of(layout.inputs.begin(), layout.inputs.end(), [&](const solver::Input& input) {
    return input.kind == InputKind::source && input.item == source && input.node > 0;
  });
}

bool has_flow(const solver::ThermalSystem& thermal, const solver::Coefficients& c) {
  for (std::size_t j = 0; j < thermal.layout.terms.size(); ++j) {
    if (thermal.layout.terms[j].kind == TermKind::coolant_flow && c.p(j) != 0.0) return true;
  }
  return false;
}

}  // namespace

solver::SparseMatrix symmetric_conduction(const solver::ThermalSystem& thermal, const Eigen::VectorXd& p) {
  solver::SparseMatrix sum = thermal.conduction;
  for (std::size_t j = 0; j < thermal.terms.size(); ++j) {
    const double factor = p(j);
    if (factor != 0.0 && thermal.layout.terms[j].kind != TermKind::coolant_flow) sum += factor * thermal.terms[j];
  }
  return sum;
}

void remove_mean(const solver::ThermalSystem& thermal, Eigen::MatrixXd& block) {
  const Eigen::VectorXd lumped = thermal.capacity * Eigen::VectorXd::Ones(thermal.size);
  const Eigen::RowVectorXd mean = lumped.transpose() * block / lumped.sum();
  block.rowwise() -= mean;
}

std::vector<OperatingPoint> operating_points(const solver::OperatingModel& model) {
  std::vector<OperatingPoint> points;
  const Eigen::VectorXd standing = model.channels().defaults();
  points.push_back(make_point(model, "standing", standing));

  const auto add = [&](const char* name, Travel travel, double speed, bool on) {
    Eigen::VectorXd row = standing;
    set_travel(model, row, travel);
    if (speed > 0.0) set_speeds(model, row, speed);
    set_states(model, row, on);
    points.push_back(make_point(model, name, row));
  };
  add("all on, low end", {0.0}, 1.0, true);
  add("all off, high end", {1.0}, 0.0, false);
  add("a quarter of the travel", {0.25}, 0.2, false);
  add("middle of the travel", {0.5}, 0.6, true);
  add("three quarters of the travel", {0.75}, 1.0, false);

  Eigen::VectorXd row = standing;
  set_travel(model, row, {0.5, true});
  set_speeds(model, row, 0.5);
  points.push_back(make_point(model, "half speed, whole travel", row));
  return points;
}

Eigen::MatrixXd effective_inputs(const solver::ThermalSystem& thermal, const solver::OperatingModel& model,
                                 const OperatingPoint& point) {
  const mesh::Machine& machine = model.machine();
  std::vector<Eigen::VectorXd> q;
  for (std::size_t i = 0; i < machine.sources.size(); ++i) {
    const int source = i;
    std::vector<Travel> travels{{0.5, true}};
    if (moves(thermal.layout, source)) travels = {{0.5, true}, {0.0}, {0.5}, {1.0}};
    for (const Travel travel : travels) {
      Eigen::VectorXd row = point.row;
      set_travel(model, row, travel);
      q.push_back(hottest(model, thermal.layout, source, row));
    }
  }
  const Eigen::VectorXd inlets = no_inlets(model);
  for (std::size_t i = 0; i < machine.ambients.size(); ++i) {
    Eigen::VectorXd row = point.row;
    const double here_C = model.ambient_K(i, row) + machine.reference_C;
    set(model, row, machine.ambients[i].id + ".T_C", here_C + ambient_step_K);
    q.push_back(model.coefficients(row, inlets).q - point.c.q);
    if (!machine.ambients[i].has_gradient) continue;
    row = point.row;
    set(model, row, machine.ambients[i].id + ".gradient_K_m", machine.ambients[i].gradient.value + gradient_step_K_m);
    q.push_back(model.coefficients(row, inlets).q - point.c.q);
  }
  for (const mesh::VolumeSpec& volume : machine.volumes) {
    Eigen::VectorXd row = point.row;
    set(model, row, volume.id + ".T_C", machine.reference_C + ambient_step_K);
    q.push_back(model.coefficients(row, inlets).q - point.c.q);
  }
  for (Eigen::Index i = 0; i < inlets.size(); ++i) {
    const Eigen::VectorXd warm = inlets + ambient_step_K * Eigen::VectorXd::Unit(inlets.size(), i);
    q.push_back(model.coefficients(point.row, warm).q - point.c.q);
  }
  const Eigen::MatrixXd amounts = columns_of(q, thermal.inputs.cols());
  return without_empty_columns(thermal.inputs * amounts);
}

Eigen::MatrixXd coefficient_changes(const solver::ThermalSystem& thermal, const OperatingPoint& point,
                                    const Eigen::VectorXd& temperature) {
  std::map<std::pair<TermKind, int>, Eigen::VectorXd> changes;  // all grid nodes of a joint are one
  for (std::size_t j = 0; j < thermal.terms.size(); ++j) {
    const solver::Term& term = thermal.layout.terms[j];
    const double p = point.c.p(j);
    if (p == 0.0) continue;
    Eigen::VectorXd& change = changes[{term.kind, term.item}];
    if (change.size() == 0) change.setZero(thermal.size);
    change += p * (thermal.terms[j] * temperature);
  }
  std::vector<Eigen::VectorXd> columns;
  for (auto& [key, change] : changes) columns.push_back(std::move(change));
  return without_empty_columns(columns_of(columns, thermal.size));
}

Eigen::MatrixXd output_directions(const solver::ThermalSystem& thermal, const std::vector<solver::OutputRows>& rows) {
  std::vector<Eigen::MatrixXd> blocks;
  const auto add = [&](const Eigen::MatrixXd& part) {
    Eigen::MatrixXd columns = part.transpose();
    columns.middleCols(3, 3) *= rotation_lever_m;
    blocks.push_back(std::move(columns));
  };
  for (const solver::OutputRows& row : rows) {
    if (row.tool.rows() > 0) add(row.tool);
    if (row.table_axis.rows() > 0) add(row.table_axis);
    if (row.table_own.rows() > 0) add(row.table_own);
  }
  const Eigen::MatrixXd stack = joined(blocks, thermal.size);
  // Lumped capacities make the result one of the functionals, not of the mesh.
  const Eigen::VectorXd lumped = (thermal.capacity * Eigen::VectorXd::Ones(thermal.size)).cwiseMax(1e-12);
  const Eigen::MatrixXd scaled = lumped.cwiseInverse().cwiseSqrt().asDiagonal() * stack;
  const Eigen::Index count = stack.cols();
  Eigen::MatrixXd gram(count, count);
  lapack::transposed_product(scaled, scaled, gram);
  const lapack::SymmetricPair eigen = lapack::symmetric_eigen(std::move(gram));
  Eigen::Index kept = 0;
  while (kept < std::min(count, most_output_directions) &&
         eigen.values(count - 1 - kept) > least_output_direction * least_output_direction * eigen.values(count - 1))
    ++kept;
  return lapack::product(stack, eigen.vectors.rightCols(kept));
}

Eigen::MatrixXd observed_directions(const solver::ThermalSystem& thermal, const std::vector<solver::OutputRows>& rows) {
  return joined({output_directions(thermal, rows), sensor_length_m * Eigen::MatrixXd(thermal.sensors.transpose())},
                thermal.size);
}

CandidateOptions default_candidates() {
  using core::units::hour, core::units::minute;
  const double slow = 1.0 / (8.0 * hour), fast = 1.0 / (20.0 * minute);
  return {{steady_shift, slow, 1.0 / (100.0 * minute), fast, 1.0 / (2.0 * minute)}, {steady_shift, slow, fast}};
}

void CandidateOptions::validate() const {
  core::require_option(!shifts.empty(), "candidates shifts", 0, "at least one, in 1/s");
  for (const auto* list : {&shifts, &adjoint_shifts}) {
    for (const double shift : *list)
      core::require_option(shift > 0.0 && std::isfinite(shift), "candidates shifts", shift, "above 0, in 1/s");
  }
}

Candidates make_candidates(const solver::ThermalSystem& thermal, const solver::OperatingModel& model,
                           const std::vector<solver::OutputRows>& rows, const CandidateOptions& options) {
  options.validate();
  const std::vector<OperatingPoint> points = operating_points(model);
  const Eigen::MatrixXd outputs = observed_directions(thermal, rows);
  std::vector<double> shifts = options.shifts;
  for (const double shift : options.adjoint_shifts) {
    if (std::find(shifts.begin(), shifts.end(), shift) == shifts.end()) shifts.push_back(shift);
  }
  const auto wants = [](const std::vector<double>& list, double shift) {
    return std::find(list.begin(), list.end(), shift) != list.end();
  };

  const solver::SparseMatrix energy = energy_of(thermal, symmetric_conduction(thermal, points.front().c.p));
  Eigen::Index given = 0;
  struct Group {
    std::vector<Eigen::MatrixXd> of_point, kept;
    void compress(const solver::ThermalSystem& system, const solver::SparseMatrix& h) {
      Eigen::MatrixXd block = joined(of_point, system.size);
      of_point.clear();
      remove_mean(system, block);
      kept.push_back(compressed(h, block, least_direction));
    }
  } responses, adjoints, changes;
  core::Progress progress("basis of the reduced model", points.size() * shifts.size());
  solver::ThermalDirectSolver solver(thermal);
  for (const OperatingPoint& point : points) {
    const Eigen::MatrixXd inputs = effective_inputs(thermal, model, point);
    const bool symmetric = !has_flow(thermal, point.c);
    Eigen::MatrixXd changing;  // at the point's own steady temperature, known after the first shift
    for (const double shift : shifts) {
      const bool direct = wants(options.shifts, shift), adjoint = wants(options.adjoint_shifts, shift);
      solver.factorise(point.c.p, shift);
      if (direct) responses.of_point.push_back(solver.solve(inputs));
      if (adjoint) adjoints.of_point.push_back(solver.solve(outputs, !symmetric));
      if (adjoint && changing.cols() > 0) changes.of_point.push_back(solver.solve(changing));
      if (direct && changing.cols() == 0) {
        changing = coefficient_changes(
            thermal, point,
            responses.of_point.back().rowwise().sum() / std::sqrt(std::max<Eigen::Index>(1, inputs.cols())));
      }
      progress.advance();
    }
    for (Group* group : {&responses, &adjoints, &changes}) {
      for (const Eigen::MatrixXd& block : group->of_point) given += block.cols();
      group->compress(thermal, energy);
    }
  }
  Candidates all{joined(responses.kept, thermal.size), joined(adjoints.kept, thermal.size),
                 joined(changes.kept, thermal.size), given};
  all.responses /= std::sqrt(points.size() * options.shifts.size());
  return all;
}

}  // namespace thermotwin::reduction
