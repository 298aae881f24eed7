// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Sensors that drift slowly. Their readings never leap, so what gives them away is the offset that all
// the other sensors and the model see in them (ErrorModel::offset): it grows steadily, through work
// and rest alike, while what a model gets wrong comes with a load and settles. A sensor drifts where,
// over the last sixteen hours (a hall's day turns within them), that offset has moved by more than six of its stated
// deviations and is five of its standard deviations from nought, and each quarter of this time has its share of the
// motion. Limits: below about 0.02 K/h a drift is an offset like any other; a model error that grows
// steadily at one sensor for sixteen hours looks the same.

#include <Eigen/Core>

#include <deque>
#include <vector>

namespace thermotwin::compensation {

class DriftWatch {
public:
  /// @param deviation_K  (sensors) stated standard deviation of a reading
  explicit DriftWatch(const Eigen::VectorXd& deviation_K);

  /// @param value, std  (sensors) of the offsets that the others see, K; NaN where nothing is known
  /// @return the sensor that drifts, named for the first time; -1: none. Of several the one that is
  ///   most of its standard deviations off, since it pulls its neighbours' offsets along.
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
