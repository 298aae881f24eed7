// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/twin_learned.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "compensation/online/drive_heats.h"
#include "compensation/online/error_states.h"
#include "compensation/online/uncertain_quantities.h"
#include "core/error.h"

namespace thermotwin::compensation {

using Eigen::Index;
using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

ErrorModel::State filled(const tt_errors& e, ErrorModel::State state, int k) {
  const int all = tt_errors_count(e.sensitivities.model);
  state.value = e.theta[k];
  state.std = std::sqrt(std::max(0.0, e.sigma[k + static_cast<long>(k) * all]));
  state.prior_std = e.prior[k];
  state.memory_s = e.memory[k];
  return state;
}

}  // namespace

void TwinMeans::add(double seconds, const VectorXd& sensors_C, const tt_twin& twin) {
  if (!(twin.now->last_step > 0.0)) return;
  duration += seconds;
  sum_p += seconds * Map<const VectorXd>(twin.p, sum_p.size());
  sum_q += seconds * Map<const VectorXd>(twin.q, sum_q.size());
  sum_state += seconds * Map<const VectorXd>(twin.state, sum_state.size());
  for (Index s = 0; s < sensors_C.size(); ++s)
    readings[s] += std::isfinite(sensors_C[s]) && tt_trusted(&twin.observer.trust, s) != 0;
}

std::vector<ErrorModel::State> learned_states(const RunningTwin& of) {
  std::vector<ErrorModel::State> all;
  if (of.data().observer == 0 || of.twin.now->started == 0) return all;
  const tt_errors& e = of.errors();
  const tt_sensor_model& sensors = *e.sensitivities.model;
  int k = 0;
  for (const UncertainQuantity& quantity : uncertain_quantities(of.model)) {
    ErrorModel::State state;
    state.name = quantity.name;
    state.unit = quantity.unit;
    all.push_back(filled(e, std::move(state), k++));
  }
  const std::vector<DriveHeat> drives = drive_heats(of.model, of.operating, of.operating.channels().defaults());
  for (int d = 0; d < sensors.drives; ++d) {
    if (e.sensitivities.drive_known[d] != 0)
      all.push_back(
          filled(e, unrecorded_state(drives[of.control.data().heating_drive[d]].name), sensors.quantities + d));
  }
  for (int mode = 0; mode <= tt_errors_shapes(&e); ++mode)
    all.push_back(filled(e, start_state(mode), tt_first_start(&sensors) + mode));
  for (int s = 0; s < of.data().sensors; ++s)
    all.push_back(filled(e, sensor_offset_state(of.model.machine, s), tt_errors_first_bias(&sensors) + s));
  for (int i = 0; tt_errors_learns(&e) != 0 && i < tt_outputs; ++i)
    all.push_back(filled(e, output_state(i), tt_errors_first_output(&sensors) + i));
  return all;
}

Detectability detectability(const RunningTwin& of, const TwinMeans& means) {
  if (of.data().observer == 0)
    throw core::InputError("detectability", "a twin without observer", "ControlOptions::observer = true");
  if (of.model.system.terms.size() != of.model.system.layout.terms.size())
    throw core::InputError("detectability", "a model without its terms", "the whole model, as read_model gives it");
  if (!(means.duration > 0.0))
    throw core::InputError("detectability", "no step of the thermal state has ended", "a run of some minutes");
  const reduction::ReducedSystem& system = of.model.system;
  const VectorXd p = means.sum_p / means.duration, q = means.sum_q / means.duration;
  // The true state is nearer to the corrected one than to the nominal one.
  const tt_sensitivities& columns = of.errors().sensitivities;
  const Index order = of.data().order, quantities_and_start = tt_columns(columns.model);
  const VectorXd corrected =
      means.sum_state / means.duration + Map<const MatrixXd>(columns.directions, order, quantities_and_start) *
                                             Map<const VectorXd>(of.errors().theta, quantities_and_start);
  // The core's states have capacity 1: x' = L^T x.
  const VectorXd state = system.capacity.llt().matrixU().solve(corrected);
  MatrixXd matrix = system.conduction;
  for (Index j = 0; j < p.size(); ++j) matrix += p[j] * system.terms[j];
  std::vector<UncertainQuantity> quantities = uncertain_quantities(of.model);
  MatrixXd rates = quantity_rates(of.model, quantities, inputs_of_terms(of.model), p, q, state);
  const std::vector<ErrorModel::State> known = learned_states(of);
  std::vector<ErrorModel::State> constants(known.begin(), known.begin() + std::ssize(quantities));
  for (int d = 0, at = 0; d < columns.model->drives; ++d) {
    if (columns.drive_known[d] == 0) continue;
    constants.push_back(known[quantities.size() + at++]);
    rates.conservativeResize(Eigen::NoChange, rates.cols() + 1);
    const VectorXd heat = Map<const VectorXd>(columns.heat + d * order, order);
    rates.rightCols(1) =
        columns.unrecorded[d] != 0 ? VectorXd(system.capacity.llt().matrixL() * heat) : VectorXd(VectorXd::Zero(order));
  }
  const auto sensors = std::ssize(of.model.machine.sensors);
  VectorXd deviations(sensors);
  for (Index s = 0; s < sensors; ++s) {
    constants.push_back(
        filled(of.errors(), sensor_offset_state(of.model.machine, s), tt_errors_first_bias(columns.model) + s));
    deviations[s] = means.readings[s] > 0 && of.twin.observer.trust.drift.drifts[s] == 0
                        ? tt_reading_std(of.model.machine.sensors[s].uncertainty, 0.0)
                        : solver::not_given;
  }
  return compensation::detectability(system.capacity, matrix, rates, system.sensors.topRows(sensors), constants,
                                     deviations);
}

}  // namespace thermotwin::compensation
