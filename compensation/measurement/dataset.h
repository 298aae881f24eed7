// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A measurement as models see it: inputs that a control knows (temperatures, speeds, powers, flows,
// states), targets that were measured (displacements, location errors), and which rows a fit may
// use. Channels may be sampled at different rates: a temperature is held until its next reading is
// due, a speed, power, flow or state until the next one comes (a row of data.csv holds until the
// next row). Nothing here looks ahead.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"

namespace thermotwin::compensation {

/// What a model may know about an input beside its values.
struct InputInfo {
  std::string id;
  bool temperature = true;  ///< sampled, linear between readings; else held from row to row
  bool activity = false;    ///< speed or power: 0 where the machine rests
  bool ambient = false;     ///< the air around the machine, by `input` or by its name
  bool motion = false;      ///< speed of an axis or the spindle
  std::string input = {};   ///< name of the machine's channel, where the measurement says so
};

/// The first input that is the ambient; -1: none.
Eigen::Index ambient_input(const std::vector<InputInfo>& info);

struct Dataset {
  std::string source;    ///< folder, for messages
  Eigen::VectorXd time;  ///< (n) s, rising
  std::vector<InputInfo> inputs;
  Eigen::MatrixXd input_values;  ///< (n x inputs) NaN where unknown
  std::vector<MeasuredChannel> targets;
  Eigen::MatrixXd target_values;  ///< (n x targets) NaN where missing; zero = "first": at 0 first in each stretch
  /// Rows at which a stretch begins: the first row, and each program that begins after a pause of more than an hour and
  /// more than ten intervals. The machine has been elsewhere meanwhile: models begin anew, from what is measured there.
  std::vector<Eigen::Index> starts{0};

  Eigen::Index rows() const { return time.size(); }
  /// Row behind the last one of a stretch.
  Eigen::Index stretch_end(std::size_t stretch) const {
    return stretch + 1 < starts.size() ? starts[stretch + 1] : rows();
  }
};

Dataset make_dataset(const Measurement& measurement);

/// Measurements of one machine as one, in this order, each two days after the one before: what a fit sees that is given
/// several. Inputs and targets are matched by id; a speed or power that one lacks is 0 there, anything else unknown.
/// @param pieces  in which an id means the same everywhere
Dataset join_datasets(const std::vector<const Dataset*>& pieces);

/// One target with the inputs that a fit of it may use. Rows that it may not use have target NaN,
/// but their inputs drive the states of a dynamic model.
struct TrainingData {
  std::string label;  ///< model and channel, for messages
  std::vector<InputInfo> info;
  Eigen::VectorXd time;                ///< (n) s
  Eigen::MatrixXd inputs;              ///< (n x inputs)
  Eigen::VectorXd target;              ///< (n)
  std::vector<Eigen::Index> breaks{};  ///< rows at which a block of means has to begin: before and behind each pause

  /// s, without pauses
  double measured_time() const;
};

/// Means over blocks of equal duration, at most `most` of them, so that a fit's cost does not depend
/// on the sampling; a record with few rows stays as it is. Blocks end at gaps and breaks.
struct Blocks {
  TrainingData data;
  bool averaged = false;  ///< held inputs then are linear between block centres
};
Blocks make_blocks(const TrainingData& data, Eigen::Index most);

/// First and last index of finite values; {-1, -1} where there is none.
std::pair<Eigen::Index, Eigen::Index> known_range(const Eigen::VectorXd& values);

}  // namespace thermotwin::compensation
