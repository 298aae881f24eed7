// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as a record of a volumetric grid, a mandrel or a surface: lines "---" divide its name, its .toml and its
// table. Either estimates that are finite or missing, or an InputError.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/table.h"
#include "metrology/mandrel/mandrel.h"
#include "metrology/rtest/analysis.h"
#include "metrology/rtest/grid.h"
#include "metrology/rtest/result_folder.h"
#include "metrology/surface/surface.h"
#include "tests/fuzz/require.h"

using namespace thermotwin;

namespace {

void require_sound(const metrology::Estimates& estimates, std::size_t cycles) {
  require(estimates.cycles.size() == cycles, "a result for each cycle");
  for (const metrology::CycleResult& cycle : estimates.cycles) {
    require(!cycle.value.array().isInf().any(), "values are finite or missing");
    require((cycle.std.array() >= 0.0 || cycle.std.array().isNaN()).all(), "no negative uncertainty");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::vector<std::string> parts{""};
  for (std::size_t from = 0, mark = 0; mark != std::string::npos; from = mark + 4) {
    mark = text.find("---\n", from);
    parts.push_back(text.substr(from, mark == std::string::npos ? mark : mark - from));
  }
  if (parts.size() < 4 || size > 20000) return 0;
  try {
    const core::Table table = core::parse_csv(parts[3], "fuzz.csv");
    if (parts[1] == "grid\n") {
      const metrology::RTestRecord record = metrology::parse_grid(parts[2], table, "fuzz.toml");
      const metrology::Estimates estimates = metrology::analyse(record);
      require_sound(estimates, record.cycles.size());
      metrology::residual_table(record, estimates);
      metrology::points_measurement_of(record, std::nullopt);
    } else if (parts[1] == "mandrel\n") {
      const auto record = metrology::MandrelRecord::parse(parts[2], table, "fuzz.toml");
      const metrology::Estimates estimates = metrology::analyse(record);
      require_sound(estimates, static_cast<std::size_t>(table.rows()));
      metrology::measurement_of(estimates, record.pose, record.against_first, std::nullopt);
    } else if (parts[1] == "surface\n") {
      const auto record = metrology::SurfaceRecord::parse(parts[2], table, "fuzz.toml");
      const metrology::Estimates estimates = metrology::analyse(record);
      require_sound(estimates, record.cycles.size());
      metrology::surface_map(record, estimates, 5);
      metrology::surface_points(record, estimates);
    }
  } catch (const core::InputError&) {}
  return 0;
}
