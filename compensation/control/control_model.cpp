// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/control_model.h"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

#include "compensation/control/low_rank.h"
#include "compensation/control/machine_arrays.h"
#include "compensation/control/observer_arrays.h"
#include "compensation/control/output_weights.h"
#include "compensation/online/offset_guard.h"
#include "core/dense_algebra.h"
#include "core/error.h"
#include "core/range.h"
#include "core/thread_pool.h"
#include "reduction/model/output_grid.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void append(std::vector<double>& values, const MatrixXd& matrix) {
  values.insert(values.end(), matrix.data(), matrix.data() + matrix.size());
}

/// Coordinates in which the capacity is 1: x' = L^T x with E = L L^T.
class UnitCapacity {
public:
  explicit UnitCapacity(const MatrixXd& capacity) {
    if (capacity == MatrixXd::Identity(capacity.rows(), capacity.cols())) return;
    lower_ = capacity.llt().matrixL();
    if (!lower_.allFinite()) throw core::InputError("reduced model", "its capacity", "a positive definite matrix");
  }
  MatrixXd inputs(const MatrixXd& columns) const {
    return lower_.size() == 0 ? columns : MatrixXd(lower_.triangularView<Eigen::Lower>().solve(columns));
  }
  /// @return the outputs of the new states, transposed
  MatrixXd outputs(const MatrixXd& rows) const { return inputs(rows.transpose()); }
  MatrixXd term(const MatrixXd& matrix) const {
    if (lower_.size() == 0) return matrix;
    MatrixXd result = inputs(MatrixXd(inputs(matrix).transpose())).transpose();
    if (matrix == matrix.transpose()) result = (0.5 * (result + result.transpose())).eval();
    return result;
  }
  MatrixXd state(const VectorXd& x) const {
    return lower_.size() == 0 ? MatrixXd(x) : MatrixXd(lower_.transpose() * x);
  }

private:
  MatrixXd lower_;
};

void add_system(const reduction::ReducedSystem& system, ControlData& data) {
  const UnitCapacity unit(system.capacity);
  data.order = system.order();
  append(data.conduction, unit.term(system.conduction));
  append(data.input_columns, unit.inputs(system.inputs));
  append(data.sensor_rows, unit.outputs(system.sensors));
  append(data.one_kelvin, unit.state(system.one_kelvin));
}

void add_terms(const reduction::ReducedSystem& system, double tolerance, DerivedData& data) {
  const UnitCapacity unit(system.capacity);
  std::vector<LowRank> terms(system.terms.size());
  core::parallel_for(0, terms.size(),
                     [&](std::size_t j) { terms[j] = low_rank(unit.term(system.terms[j]), tolerance); });
  data.term_first = {0};
  int right = 0;
  for (const LowRank& term : terms) {
    append(data.term_left, term.left);
    append(data.term_right, term.right);
    append(data.term_weight, term.weight);
    data.term_first.push_back(std::ssize(data.term_weight));
    data.term_right_first.push_back(term.right.size() > 0 ? right : -1);
    right += term.right.cols();
  }
}

void add_grid(const std::vector<reduction::OutputGrid::GridAxis>& axes, std::vector<std::int32_t>& axis,
              std::vector<std::int32_t>& linear, std::vector<std::int32_t>& endless, std::vector<std::int32_t>& first,
              std::vector<double>& positions) {
  first = {0};
  for (const reduction::OutputGrid::GridAxis& on : axes) {
    const auto count = std::ssize(on.positions);
    constexpr double most = TT_MOST_POSITIONS;
    core::require_within("online core: positions of an axis of the workspace", count, {1.0, most});
    axis.push_back(on.axis);
    linear.push_back(on.linear);
    endless.push_back(on.endless);
    positions.insert(positions.end(), on.positions.begin(), on.positions.end());
    first.push_back(std::ssize(positions));
  }
}

void add_outputs(const reduction::ReducedModel& model, ControlData& data) {
  const UnitCapacity unit(model.system.capacity);
  const reduction::OutputGrid grid(model.machine, model.outputs.tool.size());
  for (const MatrixXd& rows : model.outputs.tool) append(data.tool_rows, unit.outputs(rows));
  for (const MatrixXd& rows : model.outputs.table_axis) append(data.axis_rows, unit.outputs(rows));
  for (const MatrixXd& rows : model.outputs.table_own) append(data.own_rows, unit.outputs(rows));
  data.tool_poses = std::ssize(model.outputs.tool);
  data.table_poses = std::ssize(model.outputs.table_axis);
  data.tool_grid = std::ssize(grid.tool_axes());
  data.table_grid = std::ssize(grid.stored_table_axes());
  data.has_middle = grid.has_middle();
  add_grid(grid.tool_axes(), data.tool_axis, data.tool_linear, data.tool_endless, data.tool_first, data.tool_positions);
  add_grid(grid.stored_table_axes(), data.table_axis, data.table_linear, data.table_endless, data.table_first,
           data.table_positions);
  data.fine_first = {0};
  for (const std::vector<double>& positions : grid.line_positions()) {
    data.fine_positions.insert(data.fine_positions.end(), positions.begin(), positions.end());
    data.fine_first.push_back(std::ssize(data.fine_positions));
  }
  data.lines = std::ssize(grid.lines());
  for (const reduction::OutputGrid::Line& line : grid.lines()) {
    data.line_axis.push_back(line.axis);
    data.line_at.insert(data.line_at.end(), line.at.begin(), line.at.end());
    data.line_on_grid.insert(data.line_on_grid.end(), line.on_grid.begin(), line.on_grid.end());
  }
}

/// Bounds of the workspace as OutputMap::outside() has them.
void add_travels(const mesh::Machine& machine, ControlData& data) {
  const auto add = [&](const std::vector<std::string>& axes, const std::vector<std::vector<double>>& positions) {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const int axis = machine.axis_index(axes[i]);
      if (axis < 0 || positions[i].size() < 2 || machine.axes[axis].endless) continue;
      const double low = positions[i].front(), high = positions[i].back(), slack = 1e-6 * (high - low);
      data.travel_axis.push_back(axis);
      data.travel_low.push_back(low - slack);
      data.travel_high.push_back(high + slack);
    }
  };
  add(machine.workspace.axes, machine.workspace.positions);
  add(machine.workspace.table_axes, machine.workspace.table_positions);
  data.travels = std::ssize(data.travel_axis);
}

void add_guard(OffsetLimits limits, const OutputMap& map, const CompensatorOptions& options, ControlData& data) {
  if (options.largest_um > 0.0) limits.largest_um = options.largest_um;
  if (options.rate_um_s > 0.0) {
    limits.rate_um_s = options.rate_um_s;
    limits.slope_um.setZero();
  }
  data.largest_um = std::min(limits.largest_um, largest_offset_um);
  data.rate_um_s = std::clamp(limits.rate_um_s, least_rate_um_s, largest_rate_um_s);
  data.hold_s = GuardOptions().hold_s;
  append(data.axis_slope_um, limits.slope_um);
  append(data.axis_rapid, limits.rapid);
  for (int i = 0; i < 3; ++i) {
    solver::TcpError unit{solver::Vector6::Zero(), solver::Vector6::Zero(), solver::Vector6::Zero()};
    unit.error[i] = 1.0;
    append(data.to_axes, map.offsets(unit));
  }
}

/// FNV-1a on whole numbers, so that 20 MB take 10 ms.
class Hash {
public:
  void add(std::uint64_t value) { hash_ = (hash_ ^ value) * 0x100000001B3ULL; }
  void add(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    add(bits);
    hash_ ^= hash_ >> 29U;
  }
  void add(std::int32_t value) { add(static_cast<double>(value)); }
  void add(const std::string& text) {
    for (const std::int32_t c : text) add(c);
  }
  template <class Value>
  void add(const std::vector<Value>& values) {
    add(static_cast<std::int32_t>(values.size()));
    for (const Value& value : values) add(value);
  }
  std::uint64_t value() const { return hash_; }

private:
  std::uint64_t hash_ = 0xCBF29CE484222325ULL;
};

std::uint64_t hash_of(const ControlData& data) {
  Hash hash;
#define TT_FIELD(x) hash.add(data.x);
  TT_MODEL_COUNTS(TT_FIELD)
  TT_MODEL_NUMBERS(TT_FIELD)
  TT_MODEL_DOUBLES(TT_FIELD)
  TT_MODEL_INTS(TT_FIELD)
  TT_MODEL_TEXTS(TT_FIELD)
#undef TT_FIELD
  return hash.value();
}

}  // namespace

void ControlOptions::validate() const {
  compensator.validate();
  core::require_option(tolerance >= 0.0 && tolerance <= 0.1, "online core: tolerance", tolerance, "0 to 0.1");
  core::require_within("online core: start_over_s", start_over_s, {0.0, 3600.0});
}

namespace {

void require_tcp(const reduction::ReducedModel& model) {
  if (!model.machine.has_tcp())
    throw core::InputError("online core", "a machine without [tcp]", "one with a TCP error");
}

}  // namespace

DerivedData derived_data(const reduction::ReducedModel& model, double tolerance) {
  require_tcp(model);
  DerivedData derived;
  add_terms(model.system, tolerance, derived);
  derived.limits = offset_limits(model, OutputMap(model));
  return derived;
}

ControlData control_data(const reduction::ReducedModel& model, const ControlOptions& options) {
  options.validate();
  return control_data(model, derived_data(model, options.tolerance), options);
}

ControlData control_data(const reduction::ReducedModel& model, DerivedData derived, const ControlOptions& options) {
  options.validate();
  require_tcp(model);
  ControlData data;
  const solver::OperatingModel operating(model.machine, model.system.layout);
  fill_machine(model.machine, model.system.layout, operating.channels(), data);
  data.step_s = options.compensator.step_s;
  data.start_C = options.compensator.start_C;
  add_system(model.system, data);
  data.term_first = std::move(derived.term_first);
  data.term_right_first = std::move(derived.term_right_first);
  data.term_left = std::move(derived.term_left);
  data.term_right = std::move(derived.term_right);
  data.term_weight = std::move(derived.term_weight);
  add_outputs(model, data);
  add_travels(model.machine, data);
  const OutputMap map(model);
  add_guard(std::move(derived.limits), map, options.compensator, data);
  data.correction_s = options.compensator.correction_s;
  data.start_over_s = options.start_over_s;
  if (options.observer) fill_observer(model, operating, map, options.compensator, data);
  data.hash = hash_of(data);
  return data;
}

ControlModel::ControlModel(ControlData given) : data_(std::make_unique<const ControlData>(std::move(given))) {
  const ControlData& data = *data_;
  model_.name = data.name.c_str();
  model_.hash = data.hash;
#define TT_FIELD(x) model_.x = data.x;
  TT_MODEL_COUNTS(TT_FIELD)
  TT_MODEL_NUMBERS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x) model_.x = data.x.data();
  TT_MODEL_DOUBLES(TT_FIELD)
  TT_MODEL_INTS(TT_FIELD)
#undef TT_FIELD
#define TT_FIELD(x)                                                    \
  for (const std::string& text : data.x) x##_.push_back(text.c_str()); \
  model_.x = x##_.data();
  TT_MODEL_TEXTS(TT_FIELD)
#undef TT_FIELD
}

}  // namespace thermotwin::compensation
