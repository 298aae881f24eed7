// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as a measurement folder: the first line break that follows "---" ends channels.toml and
// begins data.csv. Either a measurement that every data model can be judged on, or an InputError.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include "compensation/evaluation/evaluate.h"
#include "compensation/evaluation/result.h"
#include "core/error.h"
#include "tests/fuzz/require.h"

using namespace thermotwin;

namespace {

struct Folder {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("thermotwin_fuzz_" + std::to_string(::getpid()));
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  void write(const char* name, const std::string& content) const {
    std::ofstream(path / name, std::ios::binary | std::ios::trunc) << content;
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder folder;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::size_t mark = text.find("---\n");
  folder.write("channels.toml", text.substr(0, mark));
  folder.write("data.csv", mark == std::string::npos ? std::string() : text.substr(mark + 4));
  try {
    const compensation::Measurement measurement = compensation::read_measurement(folder.path);
    const compensation::Evaluation evaluation = compensation::evaluate(measurement, nullptr, {});
    require(!evaluation.predictions.values.array().isInf().any(), "predictions are finite or missing");
  } catch (const core::InputError&) {}
  return 0;
}
