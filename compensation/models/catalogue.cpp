// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/catalogue.h"

#include "compensation/models/composite.h"
#include "compensation/models/grey_box.h"
#include "compensation/models/network.h"
#include "compensation/models/phenomenological.h"
#include "compensation/models/regression.h"
#include "compensation/models/rotary_unit.h"
#include "compensation/models/three_modules.h"
#include "compensation/models/transfer.h"
#include "core/error.h"
#include "core/text.h"

namespace thermotwin::compensation {

using core::InputError;

const std::vector<ModelSpec>& model_specs() {
  using enum InputChoice;
  const auto transfer = [](TransferMethod method) { return [method] { return make_transfer_model(method); }; };
  const auto phenomenological = [](SwitchBy by) {
    return [by] { return make_phenomenological({by, Search::simplex}); };
  };
  static const std::vector<ModelSpec> specs = {
      {"static_regression", "least squares on all temperatures with an intercept", temperatures, Spatial::each_channel,
       make_static_regression},
      {"ridge_regression", "ridge regression on all temperatures; ridge chosen on held-out training blocks",
       temperatures, Spatial::each_channel, make_ridge_regression},
      {"selected_regression", "forward selection of temperatures", temperatures, Spatial::each_channel,
       make_selected_regression},
      {"first_order", "regression behind one first-order lag for all temperatures", temperatures, Spatial::each_channel,
       make_first_order},
      {"grey_box", "spectrum of time constants, with drift and initial state", temperatures, Spatial::each_channel,
       make_grey_box},
      {"grey_box_all", "grey_box from temperatures, speeds, powers and states", InputChoice::all, Spatial::each_channel,
       make_grey_box},
      {"arx", "ARX transfer functions by least squares (Mares et al. 2020)", temperatures, Spatial::each_channel,
       transfer(TransferMethod::arx)},
      {"armax", "ARMAX transfer functions with a noise model (Mares et al. 2019)", temperatures, Spatial::each_channel,
       transfer(TransferMethod::armax)},
      {"output_error", "transfer functions fitted to their simulated output (Mares et al. 2020)", temperatures,
       Spatial::each_channel, transfer(TransferMethod::output_error)},
      {"output_error_activity", "output_error from speeds, powers, states and ambient", activity, Spatial::each_channel,
       transfer(TransferMethod::output_error)},
      {"heating_cooling", "one lag, with separate parameters for heating and cooling (Mares et al. 2019)", temperatures,
       Spatial::each_channel, phenomenological(SwitchBy::warming)},
      {"phenomenological", "differential equation in speeds and powers (Gebhardt 2014, eq. 5.26)", activity,
       Spatial::each_channel, phenomenological(SwitchBy::nothing)},
      {"phenomenological_switched", "phenomenological, switched by motion (Gebhardt 2014, eq. 5.27)", activity,
       Spatial::each_channel, phenomenological(SwitchBy::motion)},
      {"rotary_unit", "lumped bodies of a rotary and swivel unit (Gebhardt 2014, eqs. 5.1 to 5.25)", InputChoice::all,
       Spatial::together, make_rotary_unit},
      {"one_point", "one transfer function, scaled by b_j over the workspace (Okenka et al.)", temperatures,
       Spatial::one_point, transfer(TransferMethod::output_error)},
      {"transfer_grid", "a transfer function at each pose (Okenka et al.)", temperatures, Spatial::grid,
       transfer(TransferMethod::output_error)},
      {"static_grid", "static_regression at each pose, interpolated between them", temperatures, Spatial::grid,
       make_static_regression},
      {"composite", "baseline, ambient with modes, internal part (Naumann et al. 2023)", temperatures,
       Spatial::each_channel, make_composite},
      {"composite_grid", "composite at each pose, interpolated between them (Naumann et al. 2023)", temperatures,
       Spatial::grid, make_composite},
      {"composite_modules", "composite, its three modules fitted one after the other (Naumann et al. 2023)",
       InputChoice::all, Spatial::each_channel, [] { return make_three_modules({}); }},
      {"composite_modules_grid", "composite_modules at each pose and side, interpolated between them", InputChoice::all,
       Spatial::grid, [] { return make_three_modules({}); }},
      {"feed_forward", "neural network without memory (Naumann et al. 2023)", temperatures, Spatial::each_channel,
       [] { return make_network(false); }},
      {"memory_network", "neural network with first-order memories (Naumann et al. 2023)", temperatures,
       Spatial::each_channel, [] { return make_network(true); }},
  };
  return specs;
}

namespace {

/// Departures from a model of the catalogue, one cause at a time: "<model>:<departure>".
const std::vector<ModelSpec>& ablations() {
  const auto variant = [](const char* departure, const char* about, ThreeModulesOptions options) {
    return ModelSpec{std::string("composite_modules_grid:") + departure, about, InputChoice::all, Spatial::grid,
                     [options] { return make_three_modules(options); }};
  };
  static const std::vector<ModelSpec> specs = {
      variant("together", "modules 2 and 3 in one fit", {.together = true}),
      variant("no_delays", "no filter and no first-order element", {.delays = false}),
      variant("air", "the air in place of the ambient sensors", {.bed_sensors = false}),
      variant("no_baseline", "no module 1", {.baseline = false}),
  };
  return specs;
}

}  // namespace

const ModelSpec& model_spec(const std::string& name) {
  for (const ModelSpec& spec : ablations()) {
    if (spec.name == name) return spec;
  }
  std::vector<std::string> names;
  for (const ModelSpec& spec : model_specs()) {
    if (spec.name == name) return spec;
    names.push_back(spec.name);
  }
  throw InputError("model", "'" + name + "'",
                   "one of: " + core::join(names) + " (nearest: " + core::nearest(name, names) + ")");
}

}  // namespace thermotwin::compensation
