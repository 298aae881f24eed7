// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/sensor_model.h"

#include <fmt/format.h>

#include <iterator>

#include "compensation/control/low_rank.h"
#include "core/error.h"
#include "solver/operation/layout.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void append(std::vector<double>& values, const VectorXd& more) {
  values.insert(values.end(), more.begin(), more.end());
}

void append(std::vector<std::int32_t>& first, std::vector<std::int32_t>& items, const std::vector<int>& more) {
  if (first.empty()) first.push_back(0);
  items.insert(items.end(), more.begin(), more.end());
  first.push_back(static_cast<std::int32_t>(items.size()));
}

}  // namespace

SensorModel::SensorModel(const reduction::ReducedModel& model, int drives, double rank_tolerance)
    : quantities_(uncertain_quantities(model)),
      one_kelvin_(model.system.one_kelvin),
      sensor_rows_(model.system.sensors.transpose()),
      input_columns_(model.system.inputs) {
  constexpr double rounding = 1e-9;
  const Index order = model.system.order();
  const double off = (model.system.capacity - MatrixXd::Identity(order, order)).cwiseAbs().maxCoeff();
  if (!(off <= rounding)) {
    throw core::InputError("capacity of the reduced model", fmt::format("{:.2g} off the identity", off),
                           fmt::format("a basis that is orthonormal in the capacity, to {}", rounding));
  }
  add_terms(model.system, rank_tolerance);
  add_quantities();
  add_machine(model);
  data_.drives = drives;
}

void SensorModel::add_terms(const reduction::ReducedSystem& system, double tolerance) {
  std::int32_t right = 0;
  term_first_ = {0};
  for (const MatrixXd& matrix : system.terms) {
    const LowRank term = low_rank(matrix, tolerance);
    append(term_left_, term.left.reshaped());
    append(term_right_, term.right.reshaped());
    append(term_weight_, term.weight);
    term_first_.push_back(static_cast<std::int32_t>(term_weight_.size()));
    term_right_first_.push_back(term.right.size() > 0 ? right : -1);
    right += static_cast<std::int32_t>(term.right.cols());
  }
}

void SensorModel::add_quantities() {
  quantity_term_first_ = quantity_input_first_ = quantity_warm_first_ = {0};
  for (const UncertainQuantity& quantity : quantities_) {
    quantity_std_.push_back(quantity.std);
    quantity_memory_.push_back(quantity.memory);
    quantity_ambient_.push_back(quantity.ambient);
    append(quantity_term_first_, quantity_term_, quantity.terms);
    append(quantity_input_first_, quantity_input_, quantity.inputs);
    append(quantity_warm_first_, quantity_warm_, quantity.ambient_inputs);
  }
}

void SensorModel::add_machine(const reduction::ReducedModel& model) {
  const reduction::ReducedSystem& system = model.system;
  for (const solver::Input& input : system.layout.inputs) input_term_.push_back(input.term);
  for (const mesh::SensorSpec& sensor : model.machine.sensors) sensor_std_.push_back(sensor.uncertainty);
  const auto count = [](auto size) { return static_cast<std::int32_t>(size); };
  data_.order = count(system.order());
  data_.terms = count(system.terms.size());
  data_.inputs = count(system.inputs.cols());
  data_.sensors = count(system.sensors.rows());
  data_.measured = count(sensor_std_.size());
  data_.quantities = count(quantities_.size());
  data_.air = -1;
  for (Index k = 0; k < std::ssize(quantities_); ++k) {
    const int ambient = quantities_[k].ambient;
    if (ambient >= 0 && model.machine.ambients[ambient].id == "air") data_.air = count(k);
  }
  data_.one_kelvin = one_kelvin_.data();
  data_.sensor_rows = sensor_rows_.data();
  data_.sensor_std = sensor_std_.data();
  data_.term_left = term_left_.data();
  data_.term_right = term_right_.data();
  data_.term_weight = term_weight_.data();
  data_.term_first = term_first_.data();
  data_.term_right_first = term_right_first_.data();
  data_.input_columns = input_columns_.data();
  data_.input_term = input_term_.data();
  data_.quantity_std = quantity_std_.data();
  data_.quantity_memory = quantity_memory_.data();
  data_.quantity_ambient = quantity_ambient_.data();
  data_.quantity_term_first = quantity_term_first_.data();
  data_.quantity_term = quantity_term_.data();
  data_.quantity_input_first = quantity_input_first_.data();
  data_.quantity_input = quantity_input_.data();
  data_.quantity_warm_first = quantity_warm_first_.data();
  data_.quantity_warm = quantity_warm_.data();
}

}  // namespace thermotwin::compensation
