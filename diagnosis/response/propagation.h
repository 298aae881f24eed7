// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The time loop of response.h: a machine on a reduced model along the steps of a measurement, with any
// number of tangents beside it. Every operator of a step is factorised once for all of them; tangents
// are worked on in blocks of fixed width, so that results do not depend on the threads.

#include <optional>
#include <vector>

#include "diagnosis/causes/machine_in_time.h"
#include "diagnosis/record/observations.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::diagnosis {

/// A temperature of the surroundings that deviates for a while: by 1 K at the peak, falling in
/// straight lines to nothing at both ends.
struct Disturbance {
  int ambient = 0;                    ///< index into Machine::ambients
  double from = 0, peak = 0, to = 0;  ///< s
  double std_K = 0;                   ///< how much of it is expected
  int record = 0;                     ///< in which of several records, in its own time
};

/// A machine beside the one that is run; what differs in matrices, empty where nothing does.
struct Variant {
  MachineInTime machine;
  double start_K = 0;  ///< added to the uniform start
  double step = 1;     ///< of the parameter, divides the result
  std::optional<Disturbance> disturbance{};
  Eigen::VectorXd start{};                      ///< (r) added to the start; empty: nothing
  const Observations::MayHold* held = nullptr;  ///< inputs that hold instead
  Eigen::MatrixXd row_change{}, capacity_change{};
  const Eigen::MatrixXd* heat_map = nullptr;  ///< (r x r) where the change of heat enters instead; null: where it does
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

/// What heat makes of the outputs: each load in W times each series, (points x outputs) one after
/// another, the loads of the first series first. Chillers do not answer it.
/// @param loads   (r x loads)   @param series  (steps x series)
std::vector<Eigen::MatrixXd> propagate_heat(const Nominal& nominal, const Eigen::MatrixXd& loads,
                                            const Eigen::MatrixXd& series);

}  // namespace thermotwin::diagnosis
