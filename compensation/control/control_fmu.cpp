// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/control_fmu.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "compensation/control/control_bytes.h"
#include "compensation/control/control_source.h"
#include "core/file.h"

namespace thermotwin::compensation {
namespace {

constexpr const char* identifier = "thermotwin";

/// Unit of a channel by the end of its name: name, and what it is in SI units.
struct Unit {
  const char *ending, *name, *base;
};
constexpr std::array<Unit, 10> units = {{{"_mm_min", "mm/min", R"(m="1" s="-1" factor="1.6666666666666667e-05")"},
                                         {"_deg_min", "deg/min", R"(rad="1" s="-1" factor="2.908882086657216e-04")"},
                                         {"_rpm", "rpm", R"(rad="1" s="-1" factor="0.10471975511965977")"},
                                         {"_mm", "mm", R"(m="1" factor="1e-3")"},
                                         {"_deg", "deg", R"(rad="1" factor="0.017453292519943295")"},
                                         {"power_W", "W", R"(kg="1" m="2" s="-3")"},
                                         {"T_C", "degC", R"(K="1" offset="273.15")"},
                                         {"_K_m", "K/m", R"(K="1" m="-1")"},
                                         {"_um", "um", R"(m="1" factor="1e-6")"},
                                         {"", "1", ""}}};

const Unit& unit_of(const std::string& channel) {
  for (const Unit& unit : units) {
    if (channel.ends_with(unit.ending)) return unit;
  }
  return units.back();
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  return result;
}

/// CRC-32 of ISO 3309, as zip asks for it.
std::uint32_t crc32(std::string_view bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> made{};
    for (std::uint32_t i = 0; i < made.size(); ++i) {
      std::uint32_t value = i;
      for (int k = 0; k < 8; ++k) value = (value & 1U) != 0 ? 0xEDB88320U ^ (value >> 1U) : value >> 1U;
      made[i] = value;
    }
    return made;
  }();
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char c : bytes) crc = table[(crc ^ static_cast<unsigned char>(c)) & 0xFFU] ^ (crc >> 8U);
  return ~crc;
}

/// The lowest bytes of a number, the lowest first.
std::string little(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8U * static_cast<unsigned>(i)) & 0xFFU);
  return text;
}

}  // namespace

std::string stored_zip(const std::vector<ArchiveFile>& files) {
  std::string archive, directory;
  for (const ArchiveFile& file : files) {
    // Version 1.0, no flags, stored, 1980-01-01: nothing depends on when it was written.
    const std::string common = little(10, 2) + little(0, 2) + little(0, 2) + little(0, 2) + little(0x21, 2) +
                               little(crc32(file.content), 4) + little(file.content.size(), 4) +
                               little(file.content.size(), 4) + little(file.name.size(), 2) + little(0, 2);
    directory += little(0x02014B50, 4) + little(10, 2) + common + little(0, 2) + little(0, 2) + little(0, 2) +
                 little(0, 4) + little(archive.size(), 4) + file.name;
    archive += little(0x04034B50, 4) + common + file.name + file.content;
  }
  const std::size_t start = archive.size();
  return archive + directory + little(0x06054B50, 4) + little(0, 4) + little(files.size(), 2) +
         little(files.size(), 2) + little(directory.size(), 4) + little(start, 4) + little(0, 2);
}

namespace {

std::string real_variable(const std::string& name, int reference, const char* causality, const std::string& meaning,
                          const std::string& unit, const std::string& start) {
  return fmt::format(
      "    <ScalarVariable name=\"{}\" valueReference=\"{}\" causality=\"{}\" variability=\"continuous\"{}>"
      "<Real unit=\"{}\"{}/></ScalarVariable>\n",
      escaped(name), reference, causality, meaning.empty() ? "" : " description=\"" + meaning + "\"", unit,
      start.empty() ? "" : " start=\"" + start + "\"");
}

std::string integer_output(const std::string& name, int reference, const char* meaning) {
  return fmt::format(
      "    <ScalarVariable name=\"{}\" valueReference=\"{}\" causality=\"output\" variability=\"discrete\" "
      "description=\"{}\"><Integer/></ScalarVariable>\n",
      escaped(name), reference, meaning);
}

int sensors_of(const ControlData& data) { return data.observer != 0 ? data.sensors : 0; }

std::string inputs_of(const ControlData& data) {
  std::string text;
  int reference = 0;
  for (const std::string& name : data.channel_names) {
    const double usual = data.channel_default[reference];
    const bool law = std::isnan(usual);
    text += real_variable(name, reference, "input", law ? "-1e30: not given, the model's own law holds" : "",
                          unit_of(name).name, fmt::format("{}", law ? -1e30 : usual));
    ++reference;
  }
  for (int s = 0; s < sensors_of(data); ++s)
    text += real_variable(data.sensor_names[s] + "_C", reference++, "input", "-1e30: no reading", "degC", "-1e+30");
  return text;
}

std::string outputs_of(const ControlData& data) {
  std::string text;
  int reference = data.channels + sensors_of(data);
  const auto add = [&](const char* kind, const char* meaning) {
    for (const std::int32_t axis : data.linear_axis)
      text +=
          real_variable(fmt::format("{}_{}_um", kind, data.axis_names[axis]), reference++, "output", meaning, "um", "");
  };
  add("offset", "to be applied to the axis");
  if (data.observer != 0) add("std", "one standard deviation of the offset");
  text += integer_output("status", 0,
                         "0 ok, 1 limited, 2 sensor_failed, 3 no_sensors, 4 outside_workspace, 5 input_missing, 6 "
                         "starting, 7 failed");
  text += integer_output("guard", 1, "0 following, 1 limited, 2 holding, 3 returning to 0");
  for (int s = 0; s < sensors_of(data); ++s) {
    text += integer_output(data.sensor_names[s] + "_fault", s + 2,
                           "0 none, 1 implausible, 2 kelvin, 3 fahrenheit, 4 absent, 5 stuck, 6 offset, 7 noise, 8 "
                           "drift");
  }
  return text;
}

}  // namespace

std::string fmu2_description(const ControlData& data, const std::vector<std::string>& sources) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{}\" "
      "guid=\"{{{:016x}}}\" generationTool=\"thermotwin\" license=\"GPL-3.0-or-later\" "
      "variableNamingConvention=\"flat\" "
      "description=\"Thermal twin of a machine tool: channels of a control in, axis offsets out. {}\">\n"
      "  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" "
      "canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\">\n    <SourceFiles>\n",
      escaped(data.name), data.hash, data.observer != 0 ? "Temperature sensors correct it." : "Open loop.", identifier);
  for (const std::string& name : sources) {
    if (name.ends_with(".c")) text += fmt::format("      <File name=\"{}\"/>\n", name);
  }
  text += "    </SourceFiles>\n  </CoSimulation>\n  <UnitDefinitions>\n";
  for (const Unit& unit : units)
    text +=
        fmt::format("    <Unit name=\"{}\"><BaseUnit{}{}/></Unit>\n", unit.name, *unit.base != 0 ? " " : "", unit.base);
  text += "  </UnitDefinitions>\n  <DefaultExperiment startTime=\"0\" stepSize=\"1\"/>\n  <ModelVariables>\n";
  text += inputs_of(data) + outputs_of(data) + "  </ModelVariables>\n  <ModelStructure>\n";
  const int inputs = data.channels + sensors_of(data);
  const int outputs = (data.observer != 0 ? 2 : 1) * data.linear_axes + 2 + sensors_of(data);
  for (const char* list : {"Outputs", "InitialUnknowns"}) {
    text += fmt::format("    <{}>\n", list);
    for (int k = inputs + 1; k <= inputs + outputs; ++k) text += fmt::format("      <Unknown index=\"{}\"/>\n", k);
    text += fmt::format("    </{}>\n", list);
  }
  return text + "  </ModelStructure>\n</fmiModelDescription>\n";
}

void write_fmu2(const std::filesystem::path& path, const ControlData& data) {
  std::vector<ArchiveFile> files = {{}};
  std::vector<std::string> sources;
  files.push_back({fmt::format("binaries/linux64/{}.so", identifier), std::string(fmu2_library())});
  files.push_back({"resources/model.bin", control_bytes(data)});
  for (const EmbeddedFile& file : control_files()) {
    const std::string name = file.name;
    if (name == "main.c" || name == "README.md") continue;
    sources.push_back(name);
    files.push_back({"sources/" + name, flat_includes(file.text)});
  }
  files.front() = {"modelDescription.xml", fmu2_description(data, sources)};
  core::write_file(path, stored_zip(files));
}

}  // namespace thermotwin::compensation
