// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/catalogue.h"

#include "compensation/models/composite.h"
#include "compensation/models/grey_box.h"
#include "compensation/models/network.h"
#include "compensation/models/phenomenological.h"
#include "compensation/models/regression.h"
#include "compensation/models/rotary_unit.h"
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
      {"static_regression", "least squares on all temperatures, intercept", temperatures, Spatial::each_channel,
       make_static_regression},
      {"ridge_regression", "the same, strength of a ridge from held-out training blocks", temperatures,
       Spatial::each_channel, make_ridge_regression},
      {"selected_regression", "temperatures taken in one by one", temperatures, Spatial::each_channel,
       make_selected_regression},
      {"first_order", "one lag for all temperatures", temperatures, Spatial::each_channel, make_first_order},
      {"grey_box", "spectrum of time constants, drift and start accounted for", temperatures, Spatial::each_channel,
       make_grey_box},
      {"grey_box_all", "the same from temperatures, speeds, powers and states", InputChoice::all, Spatial::each_channel,
       make_grey_box},
      {"arx", "transfer functions, least squares (002)", temperatures, Spatial::each_channel,
       transfer(TransferMethod::arx)},
      {"armax", "transfer functions with modelled noise (004)", temperatures, Spatial::each_channel,
       transfer(TransferMethod::armax)},
      {"output_error", "transfer functions by their simulated output (002)", temperatures, Spatial::each_channel,
       transfer(TransferMethod::output_error)},
      {"output_error_activity", "the same from speeds, powers, states and ambient", activity, Spatial::each_channel,
       transfer(TransferMethod::output_error)},
      {"heating_cooling", "one lag, separate sets for heating and cooling (004)", temperatures, Spatial::each_channel,
       phenomenological(SwitchBy::warming)},
      {"phenomenological", "differential equation of speeds and powers (000, 5.26)", activity, Spatial::each_channel,
       phenomenological(SwitchBy::nothing)},
      {"phenomenological_switched", "switched by motion (000, 5.27)", activity, Spatial::each_channel,
       phenomenological(SwitchBy::motion)},
      {"rotary_unit", "lumped bodies of a rotary and swivel unit (000, 5.1 to 5.25)", InputChoice::all,
       Spatial::together, make_rotary_unit},
      {"one_point", "one transfer function, b_j over the workspace (001)", temperatures, Spatial::one_point,
       transfer(TransferMethod::output_error)},
      {"transfer_grid", "transfer functions at each pose (001)", temperatures, Spatial::grid,
       transfer(TransferMethod::output_error)},
      {"composite", "baseline, ambient with modes, internal part (003)", temperatures, Spatial::each_channel,
       make_composite},
      {"feed_forward", "network without memory (003)", temperatures, Spatial::each_channel,
       [] { return make_network(false); }},
      {"memory_network", "network with first-order memories (003)", temperatures, Spatial::each_channel,
       [] { return make_network(true); }},
  };
  return specs;
}

const ModelSpec& model_spec(const std::string& name) {
  std::vector<std::string> names;
  for (const ModelSpec& spec : model_specs()) {
    if (spec.name == name) return spec;
    names.push_back(spec.name);
  }
  throw InputError("model", "'" + name + "'",
                   "one of: " + core::join(names) + " (nearest: " + core::nearest(name, names) + ")");
}

}  // namespace thermotwin::compensation
