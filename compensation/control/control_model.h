// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Builds the constant data of the online core (model.h) from a reduced model: capacity 1, terms in low rank, machine as
// flat arrays. A symmetric term keeps the eigenvectors whose eigenvalues exceed tolerance times its largest, another
// one the singular vectors alike. docs/howto/control_in_c.md has figures.

#include <cstdint>
#include <memory>
#include <vector>

#include "compensation/control/control_data.h"
#include "compensation/control/model.h"
#include "compensation/online/compensator.h"
#include "compensation/online/offset_limits.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

struct ControlOptions {
  CompensatorOptions compensator;  ///< without use_sensors, the observer has no readings; see observer
  double tolerance = 1e-7;         ///< of the low rank, 0 to 0.1
  bool observer = true;            ///< sensors correct the state and offsets have a deviation; else open loop
  double start_over_s = 0.0;       ///< machine time that the work of the start is spread over, up to an hour; 0: none
  void validate() const;           ///< @throws InputError
};

/// What takes time to derive from a model, since it needs the dense terms.
struct DerivedData {
  std::vector<double> term_left, term_right, term_weight;  ///< as in ControlData
  std::vector<std::int32_t> term_first, term_right_first;  ///< as in ControlData
  OffsetLimits limits;                                     ///< by the model, without options
};
DerivedData derived_data(const reduction::ReducedModel& model, double tolerance);

/// @throws InputError for options out of range, a machine without TCP, or a grid with more positions than the core
///   holds
ControlData control_data(const reduction::ReducedModel& model, const ControlOptions& options = {});
/// The same. @param model  need not have its terms  @param derived  from the whole model
ControlData control_data(const reduction::ReducedModel& model, DerivedData derived, const ControlOptions& options);

/// Data in the form that the core reads.
class ControlModel {
public:
  explicit ControlModel(ControlData data);
  explicit ControlModel(const reduction::ReducedModel& model, const ControlOptions& options = {})
      : ControlModel(control_data(model, options)) {}
  ControlModel(ControlModel&&) = default;
  ControlModel& operator=(ControlModel&&) = default;
  ControlModel(const ControlModel&) = delete;
  ControlModel& operator=(const ControlModel&) = delete;

  const tt_model& model() const { return model_; }
  const ControlData& data() const { return *data_; }

private:
  std::unique_ptr<const ControlData> data_;  // addresses stay where the model moves
#define TT_FIELD(x) std::vector<const char*> x##_;
  TT_MODEL_TEXTS(TT_FIELD)
#undef TT_FIELD
  tt_model model_{};
};

}  // namespace thermotwin::compensation
