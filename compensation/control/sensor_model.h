// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Fills the data of the online core's estimation by sensors (sensitivities.h) from a reduced model. Terms are stored by
// their eigenvectors, K_j = sum_c w_c u_c u_c^T with w = 1 or -1, those of a coolant's flow by their singular vectors.

#include <cstdint>
#include <vector>

#include "compensation/control/sensitivities.h"
#include "compensation/online/uncertain_quantities.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

class SensorModel {
public:
  /// @param model  of capacity 1, may be gone afterwards  @param drives  that have a heat of their own (drive_heats.h)
  /// @param rank_tolerance  parts of a term below this share of its largest are left out
  /// @throws InputError if the capacity is not 1
  SensorModel(const reduction::ReducedModel& model, int drives, double rank_tolerance = 1e-14);
  SensorModel(const SensorModel&) = delete;
  SensorModel& operator=(const SensorModel&) = delete;

  /// @return valid as long as this
  const tt_sensor_model& data() const { return data_; }
  const std::vector<UncertainQuantity>& quantities() const { return quantities_; }

private:
  void add_terms(const reduction::ReducedSystem& system, double tolerance);
  void add_quantities();
  void add_machine(const reduction::ReducedModel& model);

  using Doubles = std::vector<double>;
  using Ints = std::vector<std::int32_t>;
  std::vector<UncertainQuantity> quantities_;
  Eigen::VectorXd one_kelvin_;
  Eigen::MatrixXd sensor_rows_, input_columns_;
  Doubles sensor_std_, term_left_, term_right_, term_weight_, quantity_std_, quantity_memory_;
  Ints term_first_, term_right_first_, input_term_, quantity_ambient_;
  Ints quantity_term_first_, quantity_term_, quantity_input_first_, quantity_input_, quantity_warm_first_,
      quantity_warm_;
  tt_sensor_model data_{};
};

}  // namespace thermotwin::compensation
