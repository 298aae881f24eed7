// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as model.rom.h5: an InputError. Only a file whose last line is the hash of all bytes before it is
// opened, so that what the fuzzer makes never reaches HDF5.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include "core/error.h"
#include "reduction/model/model_file.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("thermotwin_fuzz_" + std::to_string(::getpid()) + ".rom.h5");
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    thermotwin::reduction::read_model(file);
    require(false, "bytes that are no model are refused");
  } catch (const thermotwin::core::InputError& error) {
    require(std::string(error.what()).find(file.filename().string()) != std::string::npos,
            "the message names the file");
  }
  return 0;
}
