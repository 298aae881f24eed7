// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The lumped machine with outputs on all lines of its workspace, and the core's twin of it with its memory.

#include <algorithm>
#include <cstring>
#include <vector>

#include "compensation/control/control_model.h"
#include "compensation/control/twin.h"
#include "tests/compensation/control/rich_machine.h"

namespace thermotwin::compensation::test {

/// Output rows that differ from pose to pose, also on the lines.
inline reduction::ReducedModel lumps_with_lines() {
  reduction::ReducedModel model = lumped_model();
  const reduction::OutputGrid grid(model.machine);
  Uniform number(3);
  const Eigen::MatrixXd first = model.outputs.tool.front();
  model.outputs.tool_poses = grid.tool_poses();
  model.outputs.tool.clear();
  for (std::size_t i = 0; i < grid.tool_count(); ++i) {
    const Eigen::MatrixXd change = first.unaryExpr([&](double value) { return value * number(-0.2, 0.2); });
    model.outputs.tool.push_back(first + change);
  }
  return model;
}

/// Blocks of memory and the twin in them.
class Twin {
public:
  explicit Twin(const tt_model& model)
      : state_((tt_twin_state_bytes(&model) + 7) / 8),
        work_((tt_twin_work_bytes(&model) + 7) / 8) {
    tt_twin_begin(&twin_, &model, state_.data(), work_.data());
  }
  Twin(const Twin&) = delete;
  Twin& operator=(const Twin&) = delete;

  int row(double time, const Eigen::VectorXd& channels) { return tt_twin_row(&twin_, time, channels.data(), nullptr); }
  int row(double time, const Eigen::VectorXd& channels, const Eigen::VectorXd& sensors_C) {
    return tt_twin_row(&twin_, time, channels.data(), sensors_C.data());
  }
  Eigen::VectorXd offset_um() const { return of_axes(twin_.offset_um); }
  Eigen::VectorXd std_um() const { return of_axes(twin_.std_um); }
  std::vector<unsigned char> saved() const {
    std::vector<unsigned char> bytes(tt_twin_saved_bytes(twin_.model));
    tt_twin_save(&twin_, bytes.data());
    return bytes;
  }
  int load(const std::vector<unsigned char>& bytes) { return tt_twin_load(&twin_, bytes.data(), bytes.size()); }
  tt_twin& get() { return twin_; }
  const tt_twin& get() const { return twin_; }

private:
  Eigen::VectorXd of_axes(const double* values) const {
    return Eigen::Map<const Eigen::VectorXd>(values, twin_.model->linear_axes);
  }

  std::vector<double> state_, work_;
  tt_twin twin_{};
};

/// Rows of a day's work: the shift of shift.h with axes that move from row to row.
inline Eigen::VectorXd working_row(const mesh::Machine& machine, const solver::Channels& channels,
                                   const Eigen::VectorXd& shift, double time) {
  Eigen::VectorXd row = shift;
  for (std::size_t a = 0; a < machine.axes.size(); ++a) {
    const mesh::Axis& axis = machine.axes[a];
    const double low = axis.endless ? -3.0 : axis.low, high = axis.endless ? 3.0 : axis.high;
    const double place =
        0.5 + 0.5 * std::sin(time / (1900.0 + 300.0 * static_cast<double>(a)) + static_cast<double>(a));
    row[channels.of_axis(a).position] = (low + place * (high - low)) / channels.of_axis(a).unit;
  }
  return row;
}

}  // namespace thermotwin::compensation::test
