// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Detects sensors that drift slowly. Their readings never jump, but the offset that the other sensors and the model
// attribute to them (ErrorModel::offset) grows steadily, under load and at rest; a model error appears with a load and
// settles. A sensor drifts if, over the last sixteen hours, this offset has changed by more than six of its stated
// standard deviations, is five of its standard deviations from 0, and has changed in each quarter of the time. In any
// sixteen hours the daily temperature cycle of a hall reverses, so it is not taken for a drift. Limits: a drift below
// about 0.02 K/h is taken for an offset, and a model error that grows steadily at one sensor for sixteen hours is taken
// for a drift.

#include <Eigen/Core>

#include <deque>
#include <vector>

namespace thermotwin::compensation {

class DriftWatch {
public:
  /// @param deviation_K  (sensors) stated standard deviation of a reading
  explicit DriftWatch(const Eigen::VectorXd& deviation_K);

  /// @param value, std  (sensors) of the offsets by the other sensors and the model, K; NaN if unknown
  /// @return the sensor that drifts, named for the first time; -1: none. Of several, the one with the largest offset in
  ///   its standard deviations, because it influences the offsets of its neighbours
  Eigen::Index judge(double time, const Eigen::VectorXd& value, const Eigen::VectorXd& std);
  bool drifts(Eigen::Index sensor) const { return sensors_[sensor].drifts; }

private:
  bool grows_steadily(Eigen::Index sensor, double time, double value, double std);

  struct Sample {
    double time, value;
  };
  struct Sensor {
    std::deque<Sample> samples;
    bool drifts = false;
  };
  Eigen::VectorXd deviation_;
  std::vector<Sensor> sensors_;
};

}  // namespace thermotwin::compensation
