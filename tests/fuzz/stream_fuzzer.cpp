// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes a control may send are rows that get finite offsets, one line each, or an InputError.
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>

#include "compensation/online/compensator.h"
#include "compensation/online/stream.h"
#include "core/error.h"
#include "tests/fuzz/require.h"
#include "tests/machines/rods.h"

using namespace thermotwin;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const reduction::ReducedModel model = lumped::model(lumped::machine(), 2);
  std::istringstream in(std::string(reinterpret_cast<const char*>(data), size));
  std::ostringstream out;
  long rows = -1;
  try {
    compensation::Compensator compensator(model);
    compensation::StreamOptions options;
    options.unbuffered = true;
    options.log = options.warn = [](const std::string&) {};
    rows = compensation::compensate_stream(compensator, model.machine, in, "rows.csv", out, options).rows;
  } catch (const core::InputError&) {}
  // What was written before an error counts too: a control has used it.
  std::istringstream lines(out.str());
  long written = 0;
  std::string line;
  if (std::getline(lines, line)) require(line.starts_with("time_s,"), "the header comes first");
  while (std::getline(lines, line)) {
    ++written;
    for (std::size_t cell = 0; cell != std::string::npos; cell = line.find(',', cell + 1)) {
      const std::string word = line.substr(cell + (line[cell] == ',' ? 1 : 0), 4);
      require(word.find("nan") == std::string::npos && word.find("inf") == std::string::npos, "offsets are finite");
    }
  }
  require(rows < 0 || rows == written, "a line for each row");
  return 0;
}
