// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Rows and heats of a day of work, as work_before.h has them.

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "compensation/online/drive_heats.h"
#include "compensation/online/uncertain_quantities.h"
#include "compensation/online/work_before.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::compensation::test {

inline std::vector<WorkBefore::Ambient> ambients_of(const reduction::ReducedModel& model) {
  std::vector<WorkBefore::Ambient> all;
  for (const UncertainQuantity& quantity : uncertain_quantities(model)) {
    if (quantity.ambient >= 0) all.push_back({quantity.ambient, quantity.ambient_inputs});
  }
  return all;
}

class Day {
public:
  /// @param row  where the axes stand
  Day(const reduction::ReducedModel& model, const Eigen::VectorXd& row)
      : model_(model),
        operating_(model.machine, model.system.layout),
        rest_(operating_.channels().defaults()) {
    std::vector<std::string> ends;
    for (const mesh::Axis& axis : model.machine.axes) {
      const int position =
          operating_.channels().index("axis." + axis.id + (is_linear(axis) ? ".position_mm" : ".position_deg"));
      if (std::isfinite(row[position])) rest_[position] = row[position];
    }
    swept_ = off_ = rest_;
    for (const mesh::Axis& axis : model.machine.axes) {
      const std::string id = "axis." + axis.id + ".", unit = is_linear(axis) ? "mm" : "deg";
      const double to_unit = is_linear(axis) ? 1e3 : 180.0 / std::numbers::pi;
      set(swept_, id + "low_" + unit, axis.low * to_unit);
      set(swept_, id + "high_" + unit, axis.high * to_unit);
    }
    set(off_, "machine.on", 0.0);
    for (const mesh::CoolantSpec& coolant : model.machine.coolants) set(off_, "coolant." + coolant.id + ".on", 0.0);
  }
  explicit Day(const reduction::ReducedModel& model)
      : Day(model, solver::OperatingModel(model.machine, model.system.layout).channels().defaults()) {}

  const Eigen::VectorXd& rest() const { return rest_; }
  const Eigen::VectorXd& swept() const { return swept_; }
  const Eigen::VectorXd& off() const { return off_; }

  Eigen::MatrixXd operator_at(const Eigen::VectorXd& row) const {
    const Eigen::VectorXd p = at(row).p;
    Eigen::MatrixXd matrix = model_.system.conduction;
    for (Eigen::Index j = 0; j < p.size(); ++j) matrix += p[j] * model_.system.terms[j];
    return matrix;
  }

  /// (order x heats)
  Eigen::MatrixXd heats() const {
    std::vector<Eigen::VectorXd> all{model_.system.inputs * at(rest_).q - source_heat(model_.system, operating_, off_)};
    for (const DriveHeat& drive : drive_heats(model_, operating_, rest_)) all.push_back(drive.heat);
    Eigen::VectorXd wet = rest_;
    set(wet, "cutting_fluid.on", 1.0);
    const Eigen::VectorXd p = at(wet).p;
    for (const WorkBefore::Ambient& ambient : ambients_of(model_)) {
      Eigen::VectorXd heat = Eigen::VectorXd::Zero(model_.system.order());
      for (const int input : ambient.inputs)
        heat += 2.0 * p[model_.system.layout.inputs[input].term] * model_.system.inputs.col(input);
      all.push_back(heat);
    }
    Eigen::MatrixXd columns(model_.system.order(), std::ssize(all));
    for (Eigen::Index i = 0; i < columns.cols(); ++i) columns.col(i) = all[i];
    return columns;
  }

private:
  static bool is_linear(const mesh::Axis& axis) { return axis.kind == mesh::AxisKind::linear; }
  void set(Eigen::VectorXd& row, const std::string& name, double value) const {
    if (const int channel = operating_.channels().index(name); channel >= 0) row[channel] = value;
  }
  solver::Coefficients at(const Eigen::VectorXd& row) const {
    return operating_.coefficients(row, Eigen::VectorXd::Zero(std::ssize(model_.machine.coolants)));
  }

  const reduction::ReducedModel& model_;
  solver::OperatingModel operating_;
  Eigen::VectorXd rest_, swept_, off_;
};

}  // namespace thermotwin::compensation::test
