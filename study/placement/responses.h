// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Responses of a reduced model to its uncertain parameters: powers, films, contacts, coolants and surroundings, by
// central differences of whole runs at one standard deviation. They are the sensitivities of the observer
// (compensation/online/error_model.h) along a load program.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "diagnosis/causes/parameter.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/load_program.h"

namespace thermotwin::study {

/// An uncertain parameter with its prior.
struct UncertainParameter {
  diagnosis::Parameter parameter;
  double std = 0;     ///< of the prior: relative to nominal, or K for an ambient
  double memory = 0;  ///< s, time constant of the return to the prior
};

/// @return the powers, films, contacts, coolants and exchanges of machine.toml with a std_percent, and the ambients
///   with the prior of the observer
std::vector<UncertainParameter> uncertain_parameters(const reduction::ReducedModel& model);

/// One load program.
struct LoadResponses {
  std::string load;
  /// (parameters) standard deviation of the prior over UncertainParameter::std; empty: 1. A control is told the air
  /// only. Where the load starts at another temperature than the default of another ambient, that ambient may be at
  /// either, as in the observer: the deviation then is half the gap.
  Eigen::VectorXd prior;
  std::vector<double> times;            ///< s, at equal intervals, except the last one
  std::vector<Eigen::MatrixXd> states;  ///< (order x parameters) K per standard deviation, for each time
};

/// @param every_s  interval of the times, s, rounded to a multiple of the output interval
LoadResponses responses(const reduction::ReducedModel& model, const std::vector<UncertainParameter>& parameters,
                        const solver::LoadProgram& load, double every_s);

}  // namespace thermotwin::study
