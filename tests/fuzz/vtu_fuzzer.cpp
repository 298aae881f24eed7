// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/import_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  import_bytes(".vtu", data, size);
  return 0;
}
