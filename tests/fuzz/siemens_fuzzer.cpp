// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes are lines of a Siemens program or an InputError. What comes out is a line without control characters, and
// its only comments are the markers of tool centre point control.
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>

#include "core/error.h"
#include "nc/dialect/siemens_reader.h"
#include "nc/dialect/tcp_marker.h"
#include "tests/fuzz/require.h"

using namespace thermotwin;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nc::ControlProfile control;
  nc::SiemensReader reader(control, 0x37, "fuzz.mpf");
  std::istringstream lines(std::string(reinterpret_cast<const char*>(data), size));
  std::size_t number = 0;
  try {
    for (std::string line; std::getline(lines, line);) {
      std::string text = reader.translate(line, ++number);
      for (const char* marker : {nc::tcp_on_marker, nc::tcp_off_marker})
        if (const auto at = text.find(nc::marker_comment(marker)); at != std::string::npos)
          text.erase(at, nc::marker_comment(marker).size());
      require(text.find_first_of("();\n\r%#[\"") == std::string::npos, "words alone");
      require(text.size() <= 254, "a line that the interpreter reads");
    }
  } catch (const core::InputError&) {}
  return 0;
}
