// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// How the probes of an R-Test stand and record. The keys are those of [probes] in rtest.toml and plan.toml.

#include <Eigen/Core>

#include "core/config.h"
#include "core/key_table.h"
#include "metrology/probe/probes.h"

namespace thermotwin::metrology {

struct ProbeSetup {
  bool on_table = false;  ///< the probes stand on the table and the sphere in the spindle; else the reverse
  Eigen::Matrix3Xd directions = tripod();  ///< unit columns; frame of the carrier with all axes at 0
  double contact_radius = 0;               ///< m, radii of tip and sphere together; 0: flat tips
  bool directions_stated = false, calibration_stated = false;  ///< in the file
  double noise = 0.1e-6;                                       ///< m, standard deviation of a sample of one probe
  double repeatability = 0.2e-6;  ///< m, standard deviation of a coordinate of the linear axes at a point
  double rate = 100;              ///< samples per second
  double record = 3, cut = 1;     ///< s, recorded at a point, and left out at both ends
  double calibration = 2e-3;      ///< m, calibration travel of each axis to either side

  /// Standard deviation of one coordinate of a point. @param averaged  samples that it is the mean of
  double std_of_point(double averaged) const;
  /// Samples of a discrete point that count.
  double averaged() const;
};

const core::KeyTable& probe_keys();

/// @throws InputError
ProbeSetup read_probes(const core::Node& node);
/// [probes] as read_probes() reads it.
std::string probes_text(const ProbeSetup& setup);

}  // namespace thermotwin::metrology
