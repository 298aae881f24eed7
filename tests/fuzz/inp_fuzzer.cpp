// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as an Abaqus file: either a mesh or an InputError.
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/error.h"
#include "mesh/import/inp_reader.h"
#include "mesh/import/raw_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const thermotwin::mesh::RawMesh raw = thermotwin::mesh::parse_inp(text, "fuzz.inp");
    thermotwin::mesh::ImportOptions options;
    options.body = "fuzz";
    options.unit_m = 1.0;
    thermotwin::mesh::finish(raw, options);
  } catch (const thermotwin::core::InputError&) {}
  return 0;
}
