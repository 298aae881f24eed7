// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Displacement and rotation of a test mandrel from probes around it, such as the five of ISO 230-3 or the two whose
// difference over their distance is an angle (Mares et al. 2020). A probe at p reads, along its direction u,
//   m = u . (d + w x (p - o)),
// with the displacement d of the functional point o and the rotation w. Each row of readings is solved by weighted
// least squares for those of dx, dy, dz, ra, rb, rc that the probes observe. A probe off its stated place by a standard
// deviation s adds the systematic variance s^2 |u x w|^2 to its readings: two probes at a distance L that is uncertain
// by u(L) give u(w)^2 = 2 u(m)^2 / L^2 + (w u(L) / L)^2.
// A folder has mandrel.toml (docs/reference/mandrel.md) and readings.csv: time_s and a column for each probe, <id>_um.

#include <Eigen/Core>

#include <filesystem>
#include <string>
#include <vector>

#include "core/key_table.h"
#include "core/table.h"
#include "metrology/fit/estimates.h"

namespace thermotwin::metrology {

struct MandrelProbe {
  std::string id;
  Eigen::Vector3d at = Eigen::Vector3d::Zero();         ///< m, frame of the functional point
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit: the reading rises when the mandrel moves along it
  double std = 0, place_std = 0;                        ///< m, of a reading; of the place
};

struct MandrelRecord {
  std::string source;                               ///< mandrel.toml
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< m, where the displacement is stated
  bool in_spindle = true;                           ///< the mandrel; else it is on the table
  bool against_first = true;
  bool alone = false;                   ///< one row: as read, whatever the file says
  std::string pose;                     ///< of the machine, "B=0,C=0"
  std::vector<std::string> quantities;  ///< asked for; empty: all that are observable
  std::string place_of_quantities;
  std::vector<MandrelProbe> probes;
  Eigen::VectorXd time;      ///< (rows) s
  Eigen::MatrixXd readings;  ///< (rows x probes) m

  /// @throws InputError: an unknown key or column, a missing reading, time that runs back, no probes, no rows
  static MandrelRecord load(const std::filesystem::path& folder);
  static MandrelRecord parse(const std::string& toml, const core::Table& readings, const std::string& source);
};

const core::KeyTable& mandrel_keys();

/// One cycle a row, of the tool against the workpiece.
/// @throws InputError: probes that observe nothing, or not a quantity that is asked for
Estimates analyse(const MandrelRecord& record);

/// The residuals against the stated uncertainties of the probes and of their places. With the first row as reference,
/// constant residuals are the zeros of the probes and do not count.
ResidualTest residual_test(const MandrelRecord& record, const Estimates& estimates);

}  // namespace thermotwin::metrology
