// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Any bytes as a body's file: a mesh of consistent elements, or an InputError that names the file.

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include "core/error.h"
#include "mesh/import/import.h"
#include "tests/fuzz/require.h"

inline void import_bytes(const std::string& extension, const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("thermotwin_fuzz_" + std::to_string(::getpid()) + extension);
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  thermotwin::mesh::ImportOptions options;
  options.body = "fuzz";
  options.element_size_m = 0.05;
  try {
    const thermotwin::mesh::TetMesh mesh = thermotwin::mesh::import_body(file, options);
    for (Eigen::Index e = 0; e < mesh.elements(); ++e) require(mesh.volume(e) > 0.0, "elements have a volume");
  } catch (const thermotwin::core::InputError& error) {
    require(std::string(error.what()).find("fuzz") != std::string::npos, "the message names body or file");
  }
}
