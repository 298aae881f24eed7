// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/control_fmu.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>

#include "compensation/control/control_bytes.h"
#include "compensation/control/control_source.h"
#include "compensation/control/fmu_variables.h"
#include "core/character.h"
#include "core/file.h"

namespace thermotwin::compensation {
namespace {

constexpr const char* identifier = "thermotwin";

/// Its name as in fmu_twin.h.
const std::string log_categories =
    "  <LogCategories>\n    <Category name=\"logStatusError\" description=\"why a call is refused\"/>\n"
    "  </LogCategories>\n";

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
  for (const char c : bytes) crc = table[(crc ^ core::byte_of(c)) & 0xFFU] ^ (crc >> 8U);
  return ~crc;
}

/// The lowest bytes of a number, the lowest first.
std::string little(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xFFU);
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

std::string fmu2_description(const ControlData& data, const std::vector<std::string>& sources) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{}\" "
      "guid=\"{{{:016x}}}\" generationTool=\"thermotwin\" license=\"GPL-3.0-or-later\" "
      "variableNamingConvention=\"flat\" description=\"{}\">\n"
      "  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" "
      "canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\">\n    <SourceFiles>\n",
      fmu_escaped(data.name), data.hash, fmu_purpose(data), identifier);
  for (const std::string& name : sources) {
    if (name.ends_with(".c")) text += fmt::format("      <File name=\"{}\"/>\n", name);
  }
  text += "    </SourceFiles>\n  </CoSimulation>\n  <UnitDefinitions>\n" + fmu_unit_definitions();
  text += "  </UnitDefinitions>\n" + log_categories +
          "  <DefaultExperiment startTime=\"0\" stepSize=\"1\"/>\n  <ModelVariables>\n";
  std::string outputs;
  int real = 0, integer = 0, index = 0;
  for (const FmuVariable& one : fmu_variables(data)) {
    const bool in = one.kind == FmuVariable::Kind::input, whole = one.kind == FmuVariable::Kind::integer_output;
    const std::string type = whole ? std::string("<Integer/>")
                             : in  ? fmt::format("<Real unit=\"{}\" start=\"{}\"/>", one.unit, one.start)
                                   : fmt::format("<Real unit=\"{}\"/>", one.unit);
    text += fmt::format(
        "    <ScalarVariable name=\"{}\" valueReference=\"{}\" causality=\"{}\" variability=\"{}\"{}>{}"
        "</ScalarVariable>\n",
        fmu_escaped(one.name), whole ? integer++ : real++, in ? "input" : "output", whole ? "discrete" : "continuous",
        one.meaning.empty() ? "" : " description=\"" + one.meaning + "\"", type);
    ++index;
    if (!in) outputs += fmt::format("      <Unknown index=\"{}\"/>\n", index);
  }
  text += "  </ModelVariables>\n  <ModelStructure>\n";
  for (const char* list : {"Outputs", "InitialUnknowns"})
    text += fmt::format("    <{}>\n{}    </{}>\n", list, outputs, list);
  return text + "  </ModelStructure>\n</fmiModelDescription>\n";
}

std::string fmu3_description(const ControlData& data) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{}\" "
      "instantiationToken=\"{{{:016x}}}\" generationTool=\"thermotwin\" license=\"GPL-3.0-or-later\" "
      "variableNamingConvention=\"flat\" description=\"{}\">\n"
      "  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" "
      "canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"/>\n  <UnitDefinitions>\n",
      fmu_escaped(data.name), data.hash, fmu_purpose(data), identifier);
  text += fmu_unit_definitions() + "  </UnitDefinitions>\n" + log_categories +
          "  <DefaultExperiment startTime=\"0\" stepSize=\"1\"/>\n";
  text += "  <ModelVariables>\n";
  std::string outputs;
  int reference = 0;
  for (const FmuVariable& one : fmu_variables(data)) {
    const bool in = one.kind == FmuVariable::Kind::input, whole = one.kind == FmuVariable::Kind::integer_output;
    text += fmt::format("    <{} name=\"{}\" valueReference=\"{}\" causality=\"{}\" variability=\"{}\"{}{}{}/>\n",
                        whole ? "Int32" : "Float64", fmu_escaped(one.name), reference, in ? "input" : "output",
                        whole ? "discrete" : "continuous",
                        one.meaning.empty() ? "" : " description=\"" + one.meaning + "\"",
                        whole ? "" : " unit=\"" + one.unit + "\"", in ? fmt::format(" start=\"{}\"", one.start) : "");
    if (!in) outputs += fmt::format("valueReference=\"{}\"/>\n", reference);
    ++reference;
  }
  text += fmt::format(
      "    <Float64 name=\"time\" valueReference=\"{}\" causality=\"independent\" "
      "variability=\"continuous\"/>\n  </ModelVariables>\n  <ModelStructure>\n",
      reference);
  for (const char* list : {"Output", "InitialUnknown"}) {
    for (std::size_t at = 0, end = 0; (end = outputs.find('\n', at)) != std::string::npos; at = end + 1)
      text += fmt::format("    <{} {}\n", list, outputs.substr(at, end - at));
  }
  return text + "  </ModelStructure>\n</fmiModelDescription>\n";
}

namespace {

/// Names that the core shares between its files begin with that of the FMU, so that a program may hold others, too.
std::string prefixed(const std::string& text) {
  const auto is_word = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
  };
  std::string result;
  bool is_include = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins_line = i == 0 || text[i - 1] == '\n';
    if (begins_line) is_include = text.compare(i, 8, "#include") == 0;
    const bool is_shared = text.compare(i, 3, "tt_") == 0 || text.compare(i, 4, "fmu_") == 0;
    if (is_shared && !is_include && (i == 0 || !is_word(text[i - 1]))) result += fmt::format("{}_", identifier);
    result += text[i];
  }
  return result;
}

/// Sources of the library of this version of FMI.
std::vector<ArchiveFile> sources_of(int version) {
  const std::string other = version == 2 ? "fmi3" : "fmi2";
  std::vector<ArchiveFile> files;
  for (const EmbeddedFile& file : control_files()) {
    const std::string name = file.name;
    if (name != "main.c" && name != "README.md" && !name.starts_with(other))
      files.push_back({"sources/" + name, prefixed(flat_includes(file.text))});
  }
  return files;
}

/// sources/buildDescription.xml of FMI 3.0
std::string build_description(const std::vector<ArchiveFile>& sources) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n"
      "  <BuildConfiguration modelIdentifier=\"{}\">\n"
      "    <SourceFileSet language=\"C99\" compilerOptions=\"-ffp-contract=off\">\n",
      identifier);
  for (const ArchiveFile& file : sources) {
    const std::string name = file.name.substr(file.name.find('/') + 1);
    if (name.ends_with(".c")) text += fmt::format("      <SourceFile name=\"{}\"/>\n", name);
  }
  return text + "    </SourceFileSet>\n    <Library name=\"m\"/>\n  </BuildConfiguration>\n</fmiBuildDescription>\n";
}

}  // namespace

void write_fmu(const std::filesystem::path& path, const ControlData& data, int version) {
  const std::vector<ArchiveFile> sources = sources_of(version);
  std::vector<std::string> names;
  for (const ArchiveFile& file : sources) names.push_back(file.name.substr(file.name.find('/') + 1));
  std::vector<ArchiveFile> files;
  files.push_back({"modelDescription.xml", version == 2 ? fmu2_description(data, names) : fmu3_description(data)});
  files.push_back({fmt::format("binaries/{}/{}.so", version == 2 ? "linux64" : "x86_64-linux", identifier),
                   std::string(version == 2 ? fmu2_library() : fmu3_library())});
  files.push_back({"resources/model.bin", control_bytes(data)});
  if (version == 3) files.push_back({"sources/buildDescription.xml", build_description(sources)});
  files.insert(files.end(), sources.begin(), sources.end());
  core::write_file(path, stored_zip(files));
}

}  // namespace thermotwin::compensation
