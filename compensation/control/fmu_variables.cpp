// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/fmu_variables.h"

#include <fmt/format.h>

#include <cmath>

#include "core/text.h"

namespace thermotwin::compensation {
namespace {

int sensors_of(const ControlData& data) { return data.observer != 0 ? data.sensors : 0; }

void add_inputs(const ControlData& data, std::vector<FmuVariable>& all) {
  for (int k = 0; k < data.channels; ++k) {
    const double usual = data.channel_default[k];
    const bool law = std::isnan(usual);
    all.push_back({FmuVariable::Kind::input, data.channel_names[k],
                   law ? "-1e30: not given, the model's own law holds" : "", fmu_unit(data.channel_names[k]).name,
                   law ? fmu_not_given : usual});
  }
  for (int s = 0; s < sensors_of(data); ++s)
    all.push_back({FmuVariable::Kind::input, data.sensor_names[s] + "_C", "-1e30: no reading", "degC", fmu_not_given});
}

void add_outputs(const ControlData& data, std::vector<FmuVariable>& all) {
  const auto add = [&](const char* kind, const char* meaning) {
    for (const std::int32_t axis : data.linear_axis)
      all.push_back(
          {FmuVariable::Kind::output, fmt::format("{}_{}_um", kind, data.axis_names[axis]), meaning, "um", 0.0});
  };
  add("offset", "to be applied to the axis");
  if (data.observer != 0) add("std", "one standard deviation of the offset");
  const auto add_integer = [&](const std::string& name, const char* meaning) {
    all.push_back({FmuVariable::Kind::integer_output, name, meaning, "", 0.0});
  };
  add_integer("status",
              "0 ok, 1 limited, 2 sensor_failed, 3 no_sensors, 4 outside_workspace, 5 input_missing, 6 starting, "
              "7 failed");
  add_integer("guard", "0 following, 1 limited, 2 holding, 3 returning to 0");
  for (int s = 0; s < sensors_of(data); ++s) {
    add_integer(data.sensor_names[s] + "_fault",
                "0 none, 1 implausible, 2 kelvin, 3 fahrenheit, 4 absent, 5 stuck, 6 offset, 7 noise, 8 drift");
  }
}

}  // namespace

const std::array<FmuUnit, 11>& fmu_units() {
  static constexpr std::array<FmuUnit, 11> units = {
      {{"_mm_min", "mm/min", R"(m="1" s="-1" factor="1.6666666666666667e-05")"},
       {"_deg_min", "deg/min", R"(rad="1" s="-1" factor="2.908882086657216e-04")"},
       {"_rpm", "rpm", R"(rad="1" s="-1" factor="0.10471975511965977")"},
       {"_mm", "mm", R"(m="1" factor="1e-3")"},
       {"_deg", "deg", R"(rad="1" factor="0.017453292519943295")"},
       {"power_W", "W", R"(kg="1" m="2" s="-3")"},
       {"T_C", "degC", R"(K="1" offset="273.15")"},
       {"_K_m", "K/m", R"(K="1" m="-1")"},
       {"time_h", "h", R"(s="1" factor="3600")"},
       {"_um", "um", R"(m="1" factor="1e-6")"},
       {"", "1", ""}}};
  return units;
}

const FmuUnit& fmu_unit(const std::string& channel) {
  for (const FmuUnit& unit : fmu_units()) {
    if (channel.ends_with(unit.ending)) return unit;
  }
  return fmu_units().back();
}

std::vector<FmuVariable> fmu_variables(const ControlData& data) {
  std::vector<FmuVariable> all;
  add_inputs(data, all);
  add_outputs(data, all);
  return all;
}

std::string fmu_escaped(const std::string& text) {
  std::string line = text;
  for (char& c : line) c = c >= 0 && c < ' ' ? ' ' : c;
  return core::xml_text(line);
}

std::string fmu_unit_definitions() {
  std::string text;
  for (const FmuUnit& unit : fmu_units())
    text +=
        fmt::format("    <Unit name=\"{}\"><BaseUnit{}{}/></Unit>\n", unit.name, *unit.base != 0 ? " " : "", unit.base);
  return text;
}

std::string fmu_purpose(const ControlData& data) {
  return std::string("Thermal twin of a machine tool: channels of a control in, axis offsets out. ") +
         (data.observer != 0 ? "Temperature sensors correct it." : "Open loop.");
}

}  // namespace thermotwin::compensation
