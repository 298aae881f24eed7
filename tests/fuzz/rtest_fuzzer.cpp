// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as the record of an R-Test: the first line "---" ends rtest.toml and begins points.csv. Either location
// errors that are finite or missing, or an InputError.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/error.h"
#include "core/table.h"
#include "metrology/rtest/analysis.h"
#include "metrology/rtest/continuous.h"
#include "metrology/rtest/result_folder.h"
#include "tests/fuzz/require.h"

using namespace thermotwin;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::size_t mark = text.find("---\n");
  if (mark == std::string::npos || size > 20000) return 0;
  try {
    const metrology::RTestRecord record = metrology::RTestRecord::parse(
        text.substr(0, mark), core::parse_csv(text.substr(mark + 4), "fuzz.csv"), "fuzz.toml");
    const metrology::RTestAnalysis analysis = metrology::analyse(record);
    require(analysis.cycles.size() == record.cycles.size(), "a result for each cycle");
    for (const metrology::CycleResult& cycle : analysis.cycles) {
      require(!cycle.value.array().isInf().any(), "values are finite or missing");
      require((cycle.std.array() >= 0.0 || cycle.std.array().isNaN()).all(), "no negative uncertainty");
    }
    metrology::measurement_of(record, analysis, std::nullopt);
    if (metrology::is_continuous(record)) metrology::fit_cycles(record, metrology::CircleMethod::geometric);
  } catch (const core::InputError&) {}
  return 0;
}
