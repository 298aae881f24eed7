// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a running twin has learned of uncertain quantities, and what the rows of its run can show of them.

#include <Eigen/Core>

#include <vector>

#include "compensation/control/control_model.h"
#include "compensation/control/twin.h"
#include "compensation/online/detectability.h"
#include "compensation/online/error_model.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::compensation {

/// A twin with what it was built from; all of it outlives this.
struct RunningTwin {
  const reduction::ReducedModel& model;
  const solver::OperatingModel& operating;
  const ControlModel& control;
  const tt_twin& twin;

  const tt_model& data() const { return control.model(); }
  const tt_errors& errors() const { return twin.observer.errors; }
};

/// Sums over the rows of a run.
struct TwinMeans {
  double duration = 0;  ///< s
  Eigen::VectorXd sum_p, sum_q, sum_state;
  std::vector<long> readings;  ///< (sensors) that were trusted

  void add(double seconds, const Eigen::VectorXd& sensors_C, const tt_twin& twin);
};

/// @return none before the first row, or without an observer
std::vector<ErrorModel::State> learned_states(const RunningTwin& of);

/// At the mean operating point of the rows.
/// @throws InputError  without an observer, without the model's terms, before the first step has ended
Detectability detectability(const RunningTwin& of, const TwinMeans& means);

}  // namespace thermotwin::compensation
