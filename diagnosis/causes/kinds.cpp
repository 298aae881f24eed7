// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/kinds.h"

#include <algorithm>
#include <cassert>
#include <iterator>

#include "core/error.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::diagnosis {

namespace {

constexpr const char* channel = "id of a measured channel";
constexpr const char* of_material = "id of a [[body]], or of a [[material]] of several bodies";
constexpr double per_hour = 1.0 / core::units::hour;

using enum Target;
using enum Sense;
using enum Effect;

/// In the order of Kind; README.md shows the same table.
const std::vector<KindRow> table = {
    // kind, name, where, target, key, per unit, amount, unit, sense, low, high, step, effect
    {Kind::source_power, "source_power", "id of a [[source]]", source, "scale", 1, "factor", "1", ratio, 0, 8, 0.01,
     heat},
    {Kind::source_missing, "source_missing", "body and place in its home frame", source, "scale", 1, "power", "W",
     absolute, 0, 5000, 1, heat},
    {Kind::source_speed_law, "source_speed_law", "id of a [[source]] with a law over a speed", source, "speed_exponent",
     1, "exponent", "1", absolute, -2, 3, 0.01, heat},
    {Kind::standstill_power, "standstill_power", "id of a [[source]]", source, "standstill_W", 1, "power", "W",
     absolute, -2000, 5000, 1, heat},
    {Kind::process_heat, "process_heat", "id of a [[source]] that only a measured power drives", source, "scale", 1,
     "factor", "1", ratio, 0, 8, 0.01, heat},
    {Kind::source_step, "source_step", "id of a [[source]]", source, "scale", 1, "factor", "1", ratio, 0, 8, 0.01,
     heat},
    {Kind::film_coefficient, "film_coefficient", "id of a [[film]]", film, "film_coefficient_W_m2K", 1, "factor", "1",
     ratio, 0, 8, 0.01, coefficient},
    {Kind::film_speed_law, "film_speed_law", "id of a [[film]] with a law over a speed", film, "speed_factor", 1,
     "factor", "1", ratio, 0, 8, 0.01, coefficient},
    {Kind::film_emissivity, "film_emissivity", "id of a [[film]] that radiates", film, "emissivity", 1, "factor", "1",
     ratio, 0, 3, 0.01, coefficient},
    {Kind::radiation_load, "radiation_load", "id of a [[film]]", film, "radiation_load_W_m2", 1, "flux", "W/m2",
     absolute, -300, 1500, 1, coefficient},
    {Kind::ambient_offset, "ambient_offset", "id of an [[ambient]] of air", ambient, "offset_K", 1, "offset", "K",
     absolute, -30, 30, 0.1, coefficient},
    {Kind::ambient_gradient, "ambient_gradient", "id of an [[ambient]] with a gradient", ambient, "gradient_K_m", 1,
     "gradient", "K/m", absolute, -10, 10, 0.05, coefficient},
    {Kind::foundation_temperature, "foundation_temperature", "id of an [[ambient]] that a mount stands on", ambient,
     "offset_K", 1, "offset", "K", absolute, -30, 30, 0.1, coefficient},
    {Kind::cutting_fluid, "cutting_fluid", "id of an [[ambient]] of films that cutting_fluid.on switches", ambient,
     "offset_K", 1, "offset", "K", absolute, -30, 30, 0.1, coefficient},
    {Kind::contact_conductance, "contact_conductance", "id of a [[joint]]", joint, "conductance_W_m2K", 1, "factor",
     "1", ratio, 0, 8, 0.01, coefficient},
    {Kind::contact_stiffness, "contact_stiffness", "id of a [[joint]]", joint, "stiffness_normal_N_mm3", 1e9, "factor",
     "1", ratio, 0.05, 20, 0.01, part},
    {Kind::contact_pressure, "contact_pressure", "id of a [[joint]] with a law of pressure", joint, "pressure_MPa", 1e6,
     "factor", "1", ratio, 0.02, 20, 0.01, coefficient},
    {Kind::contact_step, "contact_step", "id of a [[joint]]", joint, "conductance_W_m2K", 1, "factor", "1", ratio, 0, 8,
     0.01, coefficient},
    {Kind::coolant_flow, "coolant_flow", "id of a [[coolant]]", coolant, "flow_kg_s", 1, "factor", "1", ratio, 0, 8,
     0.01, coefficient},
    {Kind::coolant_coupling, "coolant_coupling", "<coolant>.<segment> of a [[coolant.segment]]", segment,
     "film_coefficient_W_m2K", 1, "factor", "1", ratio, 0, 8, 0.01, coefficient},
    {Kind::coolant_inlet, "coolant_inlet", "id of a [[coolant]] whose inlet is measured", coolant, "inlet_offset_K", 1,
     "offset", "K", absolute, -30, 30, 0.1, coefficient},
    {Kind::control_sensor_offset, "control_sensor_offset", "id of a [[coolant]]", coolant, "guide_offset_K", 1,
     "offset", "K", absolute, -30, 30, 0.1, coefficient},
    {Kind::volume_exchange, "volume_exchange",
     "<volume>.<with> of a [[volume.exchange]], of several with the same partner <volume>.<with>.<state>", exchange,
     "conductance_W_K", 1, "factor", "1", ratio, 0, 50, 0.01, coefficient},
    {Kind::volume_capacity, "volume_capacity", "id of a [[volume]]", volume, "content_l", 1, "factor", "1", ratio, 0.1,
     6, 0.01, part},
    {Kind::expansion_coefficient, "expansion_coefficient", of_material, body, "expansion_1_K", 1, "factor", "1", ratio,
     0, 4, 0.01, part},
    {Kind::heat_capacity, "heat_capacity", of_material, body, "specific_heat_J_kgK", 1, "factor", "1", ratio, 0.1, 6,
     0.01, part},
    {Kind::scale_expansion, "scale_expansion", "axis of a [[scale]]", scale, "expansion_1_K", 1, "factor", "1", ratio,
     0, 4, 0.01, part},
    {Kind::screw_expansion, "screw_expansion", "axis of a [[screw]]", screw, "expansion_1_K", 1, "factor", "1", ratio,
     0, 4, 0.01, part},
    {Kind::sensor_offset, "sensor_offset", channel, sensor, "offset_K", 1, "offset", "K", absolute, -30, 30, 0.1,
     readings},
    {Kind::sensor_drift, "sensor_drift", channel, sensor, "drift_K_h", per_hour, "drift", "K/h", absolute, -3, 3, 0.01,
     readings},
    {Kind::sensor_lag, "sensor_lag", channel, sensor, "time_constant_s", 1, "time_constant", "s", absolute, 0, 14400,
     10, timing},
    {Kind::sensor_detached, "sensor_detached", channel, sensor, "air_share", 1, "air_share", "1", absolute, 0, 1, 0.01,
     readings},
    {Kind::probe_drift, "probe_drift", "id of a measured channel, or \"displacement.\" and a quantity", reading,
     "drift_1_h", per_hour, "drift", "um/h", absolute, -200, 200, 0.1, readings},
    {Kind::clock_shift, "clock_shift", "id of a measured channel, \"temperature\" or \"displacement\"", reading,
     "shift_s", 1, "shift", "s", absolute, -14400, 14400, 150, timing},
    {Kind::unmeasured_temperature, "unmeasured_temperature", "", nothing, "", 1, "", "", absolute, 0, 0, 0,
     coefficient},
    {Kind::time_constant, "time_constant", "", nothing, "", 1, "", "", absolute, 0, 0, 0, coefficient},
    {Kind::other_law, "other_law", "", nothing, "", 1, "", "", absolute, 0, 0, 0, coefficient},
    {Kind::none, "none", "", nothing, "", 1, "", "", absolute, 0, 0, 0, coefficient},
    {Kind::unknown, "unknown", "", nothing, "", 1, "", "", absolute, 0, 0, 0, coefficient},
};

}  // namespace

const KindRow& row_of(Kind kind) {
  const KindRow& row = table[static_cast<std::size_t>(kind)];
  assert(row.kind == kind);
  return row;
}

const std::vector<KindRow>& known_kinds() {
  static const std::vector<KindRow> known = [] {
    std::vector<KindRow> rows;
    std::copy_if(table.begin(), table.end(), std::back_inserter(rows),
                 [](const KindRow& row) { return row.target != Target::nothing; });
    return rows;
  }();
  return known;
}

std::optional<Kind> find_kind(const std::string& name) {
  for (const KindRow& row : known_kinds())
    if (row.name == name) return row.kind;
  return std::nullopt;
}

Kind kind_named(const std::string& name) {
  if (const std::optional<Kind> kind = find_kind(name)) return *kind;
  std::vector<std::string> known;
  for (const KindRow& row : known_kinds()) known.push_back(row.name);
  throw core::InputError("diagnosis", "kind '" + name + "'", "one of: " + core::join(known));
}

}  // namespace thermotwin::diagnosis
