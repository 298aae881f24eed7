// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/readings.h"

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/first_order_lag.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {
constexpr double most_noise =
    1000.0;  ///< variance over that of a step of the walk: an hour or three at steps of five minutes
constexpr Index fewest_for_noise = 20;
}  // namespace

VectorXd shifted(const VectorXd& time, const VectorXd& values, double shift) {
  if (shift == 0.0 || values.size() < 2) return values;
  VectorXd result(values.size());
  Index right = 1;
  const Index last = values.size() - 1;
  for (Index i = 0; i <= last; ++i) {
    const double at = std::clamp(time[i] - shift, time[0], time[last]);
    while (right < last && time[right] < at) ++right;
    const double share = (at - time[right - 1]) / (time[right] - time[right - 1]);
    result[i] = values[right - 1] + share * (values[right] - values[right - 1]);
  }
  return result;
}

VectorXd without_noise(const VectorXd& values) {
  const Index n = values.size();
  if (n < fewest_for_noise) return values;
  const VectorXd difference = values.tail(n - 1) - values.head(n - 1);
  const double noise = -difference.head(n - 2).dot(difference.tail(n - 2)) / (n - 2);
  if (!(noise > 0.0)) return values;
  const double walk = difference.squaredNorm() / (n - 1) - 2.0 * noise,
               ratio = walk * most_noise > noise ? noise / walk : most_noise;
  std::vector<Eigen::Triplet<double>> entries;
  for (Index i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 1.0 + ratio * ((i > 0) + (i + 1 < n)));
    if (i > 0) entries.emplace_back(i, i - 1, -ratio);
  }
  Eigen::SparseMatrix<double> smoother(n, n);
  smoother.setFromTriplets(entries.begin(), entries.end());
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(smoother).solve(values);
}

VectorXd sensor_readings(const mesh::SensorSpec& sensor, const VectorXd& time, const VectorXd& air,
                         const VectorXd& values) {
  VectorXd seen = values;
  if (sensor.air_share != 0.0) seen += sensor.air_share * (air - values);
  seen = core::lagged_lines(time, seen, sensor.lag);
  seen.array() += sensor.offset + sensor.drift * (time.array() - time[0]);
  return seen;
}

VectorXd recorded(const mesh::Machine& machine, const std::function<bool(const std::string&)>& is_called,
                  const VectorXd& time, VectorXd values) {
  for (const mesh::ReadingSpec& reading : machine.readings) {
    if (!is_called(reading.id)) continue;
    values = shifted(time, values, reading.shift);
    values.array() += reading.offset;
    if (reading.drift != 0.0) values.array() += reading.drift * (time.array() - time[0]);
  }
  return values;
}

}  // namespace thermotwin::diagnosis
