// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/online_arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/error.h"
#include "reduction/model/output_grid.h"

namespace thermotwin::compensation {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr Index largest_order = 10000;
constexpr Index error_numbers = 5;

MatrixXd columns_of(const std::vector<mesh::Pose>& poses, std::size_t axes) {
  MatrixXd columns(axes, poses.size());
  for (Index i = 0; i < columns.cols(); ++i) columns.col(i) = poses[i];
  return columns;
}

bool is_unit(const MatrixXd& matrix) { return matrix == MatrixXd::Identity(matrix.rows(), matrix.cols()); }

/// What a block has to agree with.
class Check {
public:
  explicit Check(const std::string& name) : name_(name) {}
  void require(bool good, const char* what) const {
    if (!good) refuse_online_data(name_, fmt::format("{} other than those of its machine", what));
  }

private:
  const std::string& name_;
};

/// Terms and inputs follow from the machine and the grids.
solver::Layout layout_of(const Check& check, const OnlineArrays& arrays, const mesh::Machine& machine) {
  check.require(arrays.grids.size() == 3 * machine.joints.size(), "grids of joints");
  std::vector<solver::JointGrid> grids;
  std::size_t next = 0;
  for (std::size_t j = 0; j < machine.joints.size(); ++j) {
    const std::int32_t *given = &arrays.grids[3 * j], axis = given[0], nodes = given[2];
    check.require(axis >= -1 && axis < std::ssize(machine.axes) && nodes >= 1 &&
                      std::cmp_less_equal(nodes, arrays.positions.size() - next),
                  "grids of joints");
    const auto from = arrays.positions.begin() + next;
    grids.push_back({axis, given[1] != 0, {from, from + nodes}});
    next += nodes;
  }
  check.require(next == arrays.positions.size(), "grids of joints");
  return solver::make_layout(machine, std::move(grids));
}

std::vector<mesh::Pose> poses_of(const MatrixXd& columns) {
  std::vector<mesh::Pose> poses;
  for (Index i = 0; i < columns.cols(); ++i) poses.emplace_back(columns.col(i));
  return poses;
}

bool is_of_size(const MatrixXd& matrix, Index rows, Index columns) {
  return rows * columns == 0 ? matrix.size() == 0 : matrix.rows() == rows && matrix.cols() == columns;
}

bool all_of_size(const std::vector<MatrixXd>& matrices, std::size_t count, Index rows, Index columns) {
  return matrices.size() == count && std::all_of(matrices.begin(), matrices.end(), [&](const MatrixXd& matrix) {
           return is_of_size(matrix, rows, columns);
         });
}

/// A matrix without rows or columns has lost the other extent in the block.
MatrixXd sized(MatrixXd matrix, Index rows, Index columns) {
  return matrix.size() > 0 ? std::move(matrix) : MatrixXd(rows, columns);
}

void fill_system(const Check& check, OnlineArrays& arrays, const mesh::Machine& machine,
                 reduction::ReducedSystem& system) {
  std::vector<MatrixXd>& m = arrays.matrices;
  const Index order = m[OnlineBlock::conduction].rows(), loads = std::ssize(system.layout.inputs),
              readings = std::ssize(machine.sensors) + std::ssize(system.layout.observed);
  check.require(order >= 1 && order <= largest_order && is_of_size(m[OnlineBlock::conduction], order, order),
                "the conduction");
  check.require(m[OnlineBlock::capacity].size() == 0 || is_of_size(m[OnlineBlock::capacity], order, order),
                "the capacity");
  check.require(is_of_size(m[OnlineBlock::inputs], order, loads), "inputs");
  check.require(is_of_size(m[OnlineBlock::sensors], readings, order), "sensors");
  check.require(is_of_size(m[OnlineBlock::one_kelvin], order, 1), "the state of one kelvin");
  system.capacity =
      m[OnlineBlock::capacity].size() > 0 ? std::move(m[OnlineBlock::capacity]) : MatrixXd::Identity(order, order);
  system.conduction = std::move(m[OnlineBlock::conduction]);
  system.inputs = sized(std::move(m[OnlineBlock::inputs]), order, loads);
  system.sensors = sized(std::move(m[OnlineBlock::sensors]), readings, order);
  system.one_kelvin = m[OnlineBlock::one_kelvin].col(0);
}

void fill_outputs(const Check& check, OnlineArrays& arrays, reduction::ReducedModel& model) {
  const mesh::Machine& machine = model.machine;
  const std::vector<MatrixXd>& m = arrays.matrices;
  reduction::ReducedOutputs& outputs = model.outputs;
  const Index order = model.system.order(), axes = std::ssize(machine.axes);
  const std::size_t tools = arrays.tool.size(), tables = arrays.table_axis.size();
  check.require(machine.has_tcp() && reduction::OutputGrid::can_store(machine, tools) &&
                    tables == reduction::OutputGrid(machine, tools).table_count(),
                "poses");
  check.require(is_of_size(m[OnlineBlock::tool_poses], axes, std::ssize(arrays.tool)) &&
                    is_of_size(m[OnlineBlock::table_poses], axes, std::ssize(arrays.table_axis)),
                "poses");
  check.require(all_of_size(arrays.tool, tools, 6, order) && all_of_size(arrays.table_axis, tables, 6, order) &&
                    all_of_size(arrays.table_own, tables, 7, order),
                "outputs");
  outputs.tool_poses = poses_of(sized(m[OnlineBlock::tool_poses], axes, std::ssize(arrays.tool)));
  outputs.table_poses = poses_of(sized(m[OnlineBlock::table_poses], axes, std::ssize(arrays.table_axis)));
  outputs.tool = std::move(arrays.tool);
  outputs.table_axis = std::move(arrays.table_axis);
  outputs.table_own = std::move(arrays.table_own);
  check.require(is_of_size(m[OnlineBlock::errors], error_numbers, std::ssize(arrays.loads)), "errors");
  for (Index i = 0; i < std::ssize(arrays.loads); ++i) {
    const auto error = m[OnlineBlock::errors].col(i);
    model.errors.push_back({arrays.loads[i], error[0], error[1], error[2], error[3], error[4]});
  }
}

void check_terms(const Check& check, const reduction::ReducedModel& model, const DerivedData& derived) {
  const std::size_t terms = model.system.layout.terms.size(), order = model.system.order();
  const std::vector<std::int32_t>& first = derived.term_first;
  check.require(first.size() == terms + 1 && first.front() == 0 && std::is_sorted(first.begin(), first.end()) &&
                    derived.term_right_first.size() == terms,
                "terms");
  std::size_t right = 0;
  for (std::size_t j = 0; j < terms; ++j) {
    if (derived.term_right_first[j] == -1) continue;
    check.require(std::cmp_equal(derived.term_right_first[j], right), "terms");
    right += first[j + 1] - first[j];
  }
  const std::size_t columns = first.back();
  check.require(derived.term_weight.size() == columns && derived.term_left.size() == columns * order &&
                    derived.term_right.size() == right * order,
                "terms");
}

void fill_limits(const Check& check, const std::vector<MatrixXd>& m, std::size_t axes, OffsetLimits& limits) {
  const Index rows = axes;
  check.require(is_of_size(m[OnlineBlock::guard], 2, 1) && is_of_size(m[OnlineBlock::of_axes], rows, 2) &&
                    m[OnlineBlock::guard].minCoeff() > 0.0 && (m[OnlineBlock::of_axes].array() >= 0.0).all(),
                "limits of offsets");
  const MatrixXd each = sized(m[OnlineBlock::of_axes], rows, 2);
  limits.largest_um = m[OnlineBlock::guard](0);
  limits.rate_um_s = m[OnlineBlock::guard](1);
  limits.slope_um = each.col(0);
  limits.rapid = each.col(1);
}

}  // namespace

void refuse_online_data(const std::string& name, const std::string& found) {
  throw core::InputError(name, found, "online data as they were written");
}

std::vector<MatrixXd> matrices_of(const OnlineData& data) {
  const reduction::ReducedModel& model = data.model;
  const std::size_t axes = model.machine.axes.size();
  std::vector<MatrixXd> all(OnlineBlock::count);
  if (!is_unit(model.system.capacity)) all[OnlineBlock::capacity] = model.system.capacity;
  all[OnlineBlock::conduction] = model.system.conduction;
  all[OnlineBlock::inputs] = model.system.inputs;
  all[OnlineBlock::sensors] = model.system.sensors;
  all[OnlineBlock::one_kelvin] = model.system.one_kelvin;
  all[OnlineBlock::tool_poses] = columns_of(model.outputs.tool_poses, axes);
  all[OnlineBlock::table_poses] = columns_of(model.outputs.table_poses, axes);
  all[OnlineBlock::errors].resize(error_numbers, std::ssize(model.errors));
  for (Index i = 0; i < all[OnlineBlock::errors].cols(); ++i) {
    const reduction::ReductionErrors& error = model.errors[i];
    all[OnlineBlock::errors].col(i) << error.peak_um, error.max_um, error.rms_um, error.estimate_max_um,
        error.effectivity;
  }
  const OffsetLimits& limits = data.derived.limits;
  all[OnlineBlock::guard] = Eigen::Vector2d(limits.largest_um, limits.rate_um_s);
  all[OnlineBlock::of_axes].resize(limits.slope_um.size(), 2);
  all[OnlineBlock::of_axes] << limits.slope_um, limits.rapid;
  return all;
}

void fill_from(OnlineArrays arrays, const std::string& name, OnlineData& data) {
  const Check check(name);
  check.require(arrays.matrices.size() == OnlineBlock::count, "matrices");
  data.model.system.layout = layout_of(check, arrays, data.model.machine);
  fill_system(check, arrays, data.model.machine, data.model.system);
  fill_outputs(check, arrays, data.model);
  fill_limits(check, arrays.matrices, data.model.machine.axes.size(), data.derived.limits);
  check_terms(check, data.model, data.derived);
}

}  // namespace thermotwin::compensation
