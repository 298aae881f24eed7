// SPDX-License-Identifier: GPL-3.0-or-later
// The kinds of causes, one line each; README.md shows the same table.

#include "diagnosis/causes/kinds.h"

#include <algorithm>

#include "core/error.h"
#include "core/text.h"
#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/parameter.h"

namespace thermotwin::diagnosis {

const std::vector<Kind>& known_kinds() {
  static const char* const channel = "id of a measured channel";
  static const std::vector<Kind> kinds = {
      {"source_power", "id of a [[source]]", "factor", "1", "ratio", 0, 8, 0.01},
      {"source_missing", "body and place in its home frame", "power", "W", "absolute", 0, 5000, 1},
      {"source_speed_law", "id of a [[source]] with a law over a speed", "exponent", "1", "absolute", -2, 3, 0.01},
      {"standstill_power", "id of a [[source]]", "power", "W", "absolute", -2000, 5000, 1},
      {"process_heat", "id of a [[source]] that only a measured power drives", "factor", "1", "ratio", 0, 8, 0.01},
      {"film_coefficient", "id of a [[film]]", "factor", "1", "ratio", 0, 8, 0.01},
      {"film_speed_law", "id of a [[film]] with a law over a speed", "factor", "1", "ratio", 0, 8, 0.01},
      {"radiation_load", "id of a [[film]]", "flux", "W/m2", "absolute", -300, 1500, 1},
      {"ambient_offset", "id of an [[ambient]] of air", "offset", "K", "absolute", -30, 30, 0.1},
      {"ambient_gradient", "id of an [[ambient]] with a gradient", "gradient", "K/m", "absolute", -10, 10, 0.05},
      {"foundation_temperature", "id of an [[ambient]] that a mount stands on", "offset", "K", "absolute", -30, 30,
       0.1},
      {"cutting_fluid", "id of an [[ambient]] of films that cutting_fluid.on switches", "offset", "K", "absolute", -30,
       30, 0.1},
      {"contact_conductance", "id of a [[joint]]", "factor", "1", "ratio", 0, 8, 0.01},
      {"contact_stiffness", "id of a [[joint]]", "factor", "1", "ratio", 0.05, 20, 0.01},
      {"coolant_flow", "id of a [[coolant]]", "factor", "1", "ratio", 0, 8, 0.01},
      {"coolant_coupling", "<coolant>.<segment> of a [[coolant.segment]]", "factor", "1", "ratio", 0, 8, 0.01},
      {"coolant_inlet", "id of a [[coolant]] whose inlet is measured", "offset", "K", "absolute", -30, 30, 0.1},
      {"control_sensor_offset", "id of a [[coolant]]", "offset", "K", "absolute", -30, 30, 0.1},
      {"expansion_coefficient", "id of a [[body]]", "factor", "1", "ratio", 0, 4, 0.01},
      {"heat_capacity", "id of a [[body]]", "factor", "1", "ratio", 0.1, 6, 0.01},
      {"scale_expansion", "axis of a [[scale]]", "factor", "1", "ratio", 0, 4, 0.01},
      {"screw_expansion", "axis of a [[screw]]", "factor", "1", "ratio", 0, 4, 0.01},
      {"sensor_offset", channel, "offset", "K", "absolute", -30, 30, 0.1},
      {"sensor_drift", channel, "drift", "K/h", "absolute", -3, 3, 0.01},
      {"sensor_lag", channel, "time_constant", "s", "absolute", 0, 14400, 10},
      {"sensor_detached", channel, "air_share", "1", "absolute", 0, 1, 0.01},
      {"probe_drift", channel, "drift", "um/h", "absolute", -200, 200, 0.1},
      {"clock_shift", "id of a measured channel, \"temperature\" or \"displacement\"", "shift", "s", "absolute", -14400,
       14400, 150},
  };
  return kinds;
}

bool acts_on_readings(const std::string& kind) {
  static const std::vector<std::string> kinds = {"sensor_offset",   "sensor_drift", "sensor_lag",
                                                 "sensor_detached", "probe_drift",  "clock_shift"};
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

bool adds_heat(const std::string& kind) {
  return kind.starts_with("source_") || kind == "standstill_power" || kind == "process_heat";
}

bool needs_parts(const std::string& kind) {
  static const std::vector<std::string> kinds = {"contact_stiffness", "expansion_coefficient", "heat_capacity",
                                                 "scale_expansion", "screw_expansion"};
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

Parameter make_parameter(const std::string& kind, const std::string& where) {
  std::vector<std::string> known;
  for (const Kind& k : known_kinds()) {
    known.push_back(k.kind);
    if (k.kind != kind) continue;
    Parameter p;
    p.kind = kind;
    p.where = where;
    p.name = k.name;
    p.unit = k.unit;
    p.ratio = k.sense == "ratio";
    p.nominal = p.ratio ? 1.0 : 0.0;
    p.low = k.low;
    p.high = k.high;
    p.step = k.step;
    return p;
  }
  throw core::InputError("diagnosis", "kind '" + kind + "'", "one of: " + core::join(known));
}

}  // namespace thermotwin::diagnosis
