// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The time loop of response.h: a machine's reduced model over the steps of a measurement, with any number of tangents
// (first-order changes). Every operator of a step is factorised once for all of them. Tangents are computed in blocks
// of fixed width, so that results do not depend on the number of threads.

#include <optional>
#include <vector>

#include "diagnosis/causes/machine_in_time.h"
#include "diagnosis/record/observations.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::diagnosis {

/// A temporary deviation of an ambient temperature: a triangle with a peak of 1 K.
struct Disturbance {
  int ambient = 0;                    ///< index into Machine::ambients
  double from = 0, peak = 0, to = 0;  ///< s
  double std_K = 0;                   ///< how much of it is expected
  int record = 0;                     ///< index of the record; times are those of this record
};

/// A variant of the machine that is run. Matrices of changes are empty if nothing changes.
struct Variant {
  MachineInTime machine;
  double start_K = 0;  ///< added to the uniform start
  double step = 1;     ///< of the parameter, divides the result
  std::optional<Disturbance> disturbance{};
  Eigen::VectorXd start{};                      ///< (r) added to the start; empty: nothing
  const Observations::MayHold* held = nullptr;  ///< inputs for a time span, in place of the recorded ones; null: none
  Eigen::MatrixXd row_change{}, capacity_change{};
  const Eigen::MatrixXd* heat_map = nullptr;  ///< (r x r) multiplies the change of heat; null: identity
};

struct Nominal {
  const reduction::ReducedModel& model;
  const Observations& observations;
  const MachineInTime& machine;
  const Eigen::MatrixXd &rows, &capacity;  ///< (outputs x r), (r x r) of this machine
};

/// Outputs (points x outputs) of the machine, then the difference of each variant, first order.
/// @throws SolverError where the state is no longer finite
std::vector<Eigen::MatrixXd> propagate(const Nominal& nominal, const std::vector<Variant>& variants);

/// Response of the outputs to heat, one (points x outputs) matrix for each load (W) times each series. All loads of the
/// first series come first. Chillers do not respond.
/// @param loads   (r x loads)   @param series  (steps x series)
std::vector<Eigen::MatrixXd> propagate_heat(const Nominal& nominal, const Eigen::MatrixXd& loads,
                                            const Eigen::MatrixXd& series);

}  // namespace thermotwin::diagnosis
