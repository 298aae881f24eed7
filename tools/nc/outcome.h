// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What `nc` has found along a program: times, travels, loads in numbers, errors and offsets.

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

#include "nc/program/program.h"
#include "nc/report/beyond_limits.h"
#include "nc/report/imprint.h"
#include "nc/report/location_errors.h"
#include "nc/report/operations.h"
#include "nc/report/parts.h"
#include "tools/nc/corrected_program.h"
#include "tools/nc/nc.h"
#include "tools/nc/twin.h"
#include "tools/nc/uncorrected.h"

namespace thermotwin::tools {

struct Outcome {
  /// Both must outlive this.
  Outcome(const NcOptions& asked, const Twin& with) : options(asked), twin(with), uncorrected(with.machine) {}

  const NcOptions& options;
  const Twin& twin;
  nc::ProgramSummary program;
  double duration_s = 0, cutting_s = 0, rapid_s = 0, pause_s = 0;
  nc::Positions travel, rows_travel;  ///< (axes) m or rad, of the program and of rows.csv
  long rows = 0;
  nc::Operations operations;
  nc::Parts parts;

  // With a model only.
  long predicted = 0, outside = 0;     ///< moves; those that end outside of the workspace
  std::vector<std::string> axes;       ///< those with offsets
  Eigen::VectorXd largest_um, std_um;  ///< (axes) of cutting moves; empty: there is none
  Uncorrected uncorrected;
  std::unique_ptr<nc::BeyondLimits> beyond;
  std::unique_ptr<nc::LocationErrors> locations;
  std::unique_ptr<nc::Imprint> imprint;         ///< none: not asked for
  std::unique_ptr<CorrectedProgram> corrected;  ///< none: not asked for

  bool has_model() const { return beyond != nullptr; }
};

}  // namespace thermotwin::tools
