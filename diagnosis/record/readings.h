// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// From what there is to what a record shows: a sensor that hangs loose takes a share of the air, its
// time constant delays, its offset and drift add; a probe drifts; a clock is late:
//   tau dy/dt = (1 - s) T + s T_air - y,   z(t) = y(t - shift) + offset + drift (t - start).

#include <Eigen/Core>

#include <functional>
#include <string>

#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// The series as a clock that is late by so much shows it (early if negative); constant beyond its ends.
Eigen::VectorXd shifted(const Eigen::VectorXd& time, const Eigen::VectorXd& values, double shift);

/// What a sensor that hangs loose feels of an air that is itself measured with noise: the level of a random walk
/// beneath white noise, of the variances that the series' own differences show (their mean square and their covariance
/// with the next one).
Eigen::VectorXd without_noise(const Eigen::VectorXd& values);

/// @param values  (n) degC at the sensor  @param air (n) degC  @return readings, degC
Eigen::VectorXd sensor_readings(const mesh::SensorSpec& sensor, const Eigen::VectorXd& time, const Eigen::VectorXd& air,
                                const Eigen::VectorXd& values);

/// Values with the errors of the machine's readings.
/// @param is_called  whether a reading's id is that of the channel, of its device with a clock, or of its quantity
Eigen::VectorXd recorded(const mesh::Machine& machine, const std::function<bool(const std::string&)>& is_called,
                         const Eigen::VectorXd& time, Eigen::VectorXd values);

}  // namespace thermotwin::diagnosis
