// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as a measurement folder: the first line break that follows "---" ends channels.toml and
// begins data.csv. Either a measurement or an InputError.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "compensation/evaluate.h"
#include "core/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("thermotwin_fuzz_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::size_t mark = text.find("---\n");
  const auto write = [](const std::filesystem::path& path, const std::string& content) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
  };
  write(folder / "channels.toml", text.substr(0, mark));
  write(folder / "data.csv", mark == std::string::npos ? std::string() : text.substr(mark + 4));
  try {
    const auto measurement = thermotwin::compensation::read_measurement(folder);
    thermotwin::compensation::evaluate(measurement, nullptr, {});
  } catch (const thermotwin::core::InputError&) {
  }
  return 0;
}
