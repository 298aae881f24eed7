// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The uncertain quantities of a machine that its thermal state depends on: source powers, films, contact conductances,
// coolant films and flows, temperatures of the surroundings and of coolants. Their standard deviations are those of
// machine.toml, with a least one for what the mesh and the form of a law leave.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

/// s, time constant with which an estimate of the machine itself returns to its prior
constexpr double machine_memory_s = 200.0 * 3600.0;

struct UncertainQuantity {
  std::string name, unit;
  double std = 0;                   ///< of theta: a share, or K for ambient ones
  double memory = 0;                ///< s, time constant of the return to the prior; 0: none
  std::vector<int> terms;           ///< terms (and what they drive) that scale with 1 + theta
  std::vector<int> inputs;          ///< inputs that scale with 1 + theta
  std::vector<int> ambient_inputs;  ///< inputs that get p of their term times theta
  int ambient = -1;                 ///< index of the ambient, for those
  Eigen::Index drive = -1;          ///< index of the drive whose heat it is
  double least = -3.0;              ///< of theta, in deviations from its mean
};

/// @return sources, films, joints, coolants, surroundings, coolant inlets, each in the order of machine.toml
std::vector<UncertainQuantity> uncertain_quantities(const reduction::ReducedModel& model);

/// @return the inputs that belong to each term
std::vector<std::vector<int>> inputs_of_terms(const reduction::ReducedModel& model);

/// @param inputs_of_term  of inputs_of_terms  @param p  (terms) coefficients  @param q  (inputs)  @param state  (order)
/// @return (order x quantities) how fast each moves the state per unit, as E dx/dt; 0 for the heat of a drive
Eigen::MatrixXd quantity_rates(const reduction::ReducedModel& model, const std::vector<UncertainQuantity>& quantities,
                               const std::vector<std::vector<int>>& inputs_of_term, const Eigen::VectorXd& p,
                               const Eigen::VectorXd& q, const Eigen::VectorXd& state);

}  // namespace thermotwin::compensation
