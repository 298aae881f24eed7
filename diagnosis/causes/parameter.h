// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The parameter that a hypothesis changes.

#include <Eigen/Core>

#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "diagnosis/causes/daily_window.h"
#include "diagnosis/causes/kinds.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// A heat source proportional to an input, on a surface that machine.toml does not have (missing_source.h).
struct MissingSource {
  mesh::SurfaceSpec surface;
  std::string follows;             ///< channel
  std::vector<std::string> alike;  ///< channels that changed as this one did in the record: it may follow them instead
  double at = 1, most = 1;         ///< value of the input at which the power is stated; its largest value
  std::string body;                ///< most probable body
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m, home frame
  double region95 = 0;               ///< m, radius about the centre that contains it with 95 % probability
  std::optional<DailyWindow> daily;  ///< where it follows the time of day
};

struct Parameter {
  Kind kind = Kind::none;
  std::string where;         ///< id in machine.toml, or channel id of a sensor, probe or clock
  std::string name;          ///< "factor", "offset", ...
  std::string unit;          ///< "1", "K", "W", ...
  bool ratio = true;         ///< the value multiplies the nominal one; else it is added
  double nominal = 1;        ///< 1 for ratios, 0 for added values
  double nominal_std = 0;    ///< stated uncertainty, which a machine without faults may have
  double cause_std = 0.5;    ///< prior width as a cause
  double low = 0, high = 5;  ///< bounds
  double step = 0.01;        ///< of the finite difference
  std::string item;          ///< id in machine.toml that carries the value if `where` is a channel
  bool of_record = false;    ///< in one of several records alone: a [[reading]] carries it
  /// Of a step: since when, in the time of the record, with its standard deviation; else since ever.
  double from_s = -std::numeric_limits<double>::infinity(), from_std_s = 0;
  double prior_share = 0;                        ///< share of its kind's prior; 0: equal shares of all places
  std::shared_ptr<const MissingSource> missing;  ///< of a source_missing
};

/// Prior standard deviation of a cause of about this size. A cause has no scale of its own, a door stands open by a
/// factor of two or of ten: what the data say is large costs the logarithm of its size, not its square, and is not
/// drawn to nominal.
double cause_std_at(const Parameter& parameter, double value);

/// @return the parameter of a kind at an item, with the kind's name, unit, bounds and nominal value
Parameter make_parameter(Kind kind, const std::string& where);

/// @return when a step came, with its uncertainty: "5.20 +- 0.3 h of the record"
std::string step_in_words(const Parameter& parameter);

/// @return kind and place, e.g. "source_power of motor"
std::string name_of(const Parameter& parameter);

}  // namespace thermotwin::diagnosis
