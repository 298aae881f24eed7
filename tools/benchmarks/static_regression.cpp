// SPDX-License-Identifier: GPL-3.0-or-later
// The alternative that tools/bench names "static regression": offsets as weighted sums of the
// temperatures of the same row, in the same stream and the same columns out. No state, no observer:
// the least that a compensator can do.
// usage: bench_regression < rows.csv > offsets.csv

#include <fmt/compile.h>
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

int main() {
  std::ios::sync_with_stdio(false);
  std::string line;
  if (!std::getline(std::cin, line)) return 3;
  std::vector<bool> temperature;
  std::size_t sensors = 0;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t comma = std::min(line.find(',', at), line.size());
    temperature.push_back(comma - at > 2 && line.compare(comma - 2, 2, "_C") == 0);
    sensors += temperature.back() ? 1 : 0;
    at = comma + 1;
  }
  // Any weights do: their values cost nothing.
  std::vector<double> weights(3 * sensors);
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = std::sin(1.0 + i);

  fmt::memory_buffer text;
  fmt::format_to(std::back_inserter(text),
                 "time_s,offset_x_um,offset_y_um,offset_z_um,std_x_um,std_y_um,std_z_um,status\n");
  while (std::getline(std::cin, line)) {
    double time = 0, offset[3] = {0, 0, 0};
    const char* at = line.data();
    const char* const end = at + line.size();
    std::size_t sensor = 0;
    for (std::size_t column = 0; column < temperature.size(); ++column) {
      double value = 0;
      const auto [stop, error] = std::from_chars(at, end, value);
      if (error != std::errc()) return 3;
      if (column == 0) time = value;
      if (temperature[column]) {
        for (std::size_t axis = 0; axis < 3; ++axis) offset[axis] += weights[3 * sensor + axis] * value;
        ++sensor;
      }
      at = stop < end ? stop + 1 : end;
    }
    fmt::format_to(std::back_inserter(text), FMT_COMPILE("{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},ok\n"), time,
                   offset[0], offset[1], offset[2], 1.0, 1.0, 1.0);
    if (text.size() > (1U << 16U)) {
      std::cout.write(text.data(), std::ssize(text));
      text.clear();
    }
  }
  std::cout.write(text.data(), std::ssize(text));
  std::cout.flush();
  return std::cout ? 0 : 3;
}
