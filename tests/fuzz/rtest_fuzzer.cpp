// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as the record of an R-Test: lines "---" divide rtest.toml, points.csv and, where the points have no
// deviations, raw.csv and calibration.csv. Either location
// errors that are finite or missing, or an InputError.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/table.h"
#include "metrology/rtest/analysis.h"
#include "metrology/rtest/continuous.h"
#include "metrology/rtest/result_folder.h"
#include "tests/fuzz/require.h"

using namespace thermotwin;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::vector<std::string> parts{""};
  for (std::size_t from = 0, mark = 0; mark != std::string::npos; from = mark + 4) {
    mark = text.find("---\n", from);
    parts.push_back(text.substr(from, mark == std::string::npos ? mark : mark - from));
  }
  if (parts.size() < 3 || size > 20000) return 0;
  try {
    std::optional<metrology::RawSignals> signals;
    if (parts.size() > 4)
      signals = {core::parse_csv(parts[3], "raw.csv"), core::parse_csv(parts[4], "calibration.csv")};
    const metrology::RTestRecord record = metrology::RTestRecord::parse(parts[1], core::parse_csv(parts[2], "fuzz.csv"),
                                                                        "fuzz.toml", signals ? &*signals : nullptr);
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
