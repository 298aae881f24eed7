// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A hypothesis is a change to the machine: one parameter of one item of machine.toml (or of a
// measured channel) with its nominal value and a prior width when it is a cause. The same change
// acts on the full model, the reduced one and machine.toml.

#include <memory>
#include <string>
#include <vector>

#include "compensation/measurement.h"
#include "mesh/machine.h"

namespace thermotwin::diagnosis {

/// Heat in proportion to an input on a surface that machine.toml does not have: missing_source.h.
struct MissingSource {
  mesh::SurfaceSpec surface;
  std::string follows;        ///< channel
  double at = 1, most = 1;    ///< value of the input that the power is stated at; its largest one
  std::string body;           ///< where it probably is
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m, home frame
  double region95 = 0;        ///< m, radius about the centre that holds it with 95 %
};

struct Parameter {
  std::string kind;         ///< "source_power", "film_coefficient", ... (README table)
  std::string where;        ///< id in machine.toml, or channel id of a sensor, probe or clock
  std::string name;         ///< "factor", "offset", ...
  std::string unit;         ///< "1", "K", "W", ...
  bool ratio = true;        ///< multiplies the nominal value; else it is added
  double nominal = 1;       ///< 1 for ratios, 0 for what is added
  double nominal_std = 0;   ///< stated uncertainty: what a clean machine may have
  double cause_std = 0.5;   ///< prior width where it is the cause
  double low = 0, high = 5; ///< bounds
  double step = 0.01;       ///< of the finite difference
  std::string item;         ///< id in machine.toml that carries the value, where `where` is a channel
  double prior_share = 0;   ///< of its kind's prior; 0: that of any place of the kind
  std::shared_ptr<const MissingSource> missing;  ///< of a source_missing
};

/// The kinds that candidate_parameters knows, as README.md lists them.
struct Kind {
  std::string kind, where;        ///< what `where` refers to, in words
  std::string name, unit, sense;  ///< of its one parameter; sense "ratio" or "absolute"
  double low, high, step;         ///< bounds, step of the finite difference
};
const std::vector<Kind>& known_kinds();

/// It changes what is read, not what the machine does: no run of the model is needed.
bool acts_on_readings(const std::string& kind);
/// It changes heat that enters somewhere, and nothing else.
bool adds_heat(const std::string& kind);
/// It changes matrices of single bodies, joints, scales or screws: see parts.h.
bool needs_parts(const std::string& kind);

/// The parameter of a kind at an item, with the kind's name, unit, bounds and nominal value.
/// @throws InputError: unknown kind
Parameter make_parameter(const std::string& kind, const std::string& where);

/// Every parameter of every kind that machine and measurement offer.
/// @param with_parts  those that need the matrices of single parts, too   @param told_row_s  as Observations::told_row_s
std::vector<Parameter> candidate_parameters(const mesh::Machine& machine,
                                            const compensation::Measurement& measurement,
                                            bool with_parts = false, double told_row_s = 0.0);

/// The machine with the parameter at the value. A sensor's offset is that of the sensor that the
/// channel reads. The text of the machine is left as it was. @throws InputError: no such item
mesh::Machine with_parameter(const mesh::Machine& machine, const Parameter& parameter, double value);

/// machine.toml's text with the named value changed and a comment that says why; nothing else
/// differs. @throws InputError if the key cannot be found in the text
std::string extended_text(const mesh::Machine& machine, const Parameter& parameter, double value,
                          double std, const std::string& why);

}  // namespace thermotwin::diagnosis
