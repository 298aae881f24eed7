// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/error_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "core/units.h"

namespace thermotwin::tools {

std::vector<std::vector<std::string>> heldout_rows(const ReducedCase& made) {
  std::vector<std::vector<std::string>> table{
      {"held-out load", "peak um", "max error um", "rms um", "of peak %", "estimated um", "estimated/true, median"}};
  for (const auto& e : made.model.errors) {
    table.push_back({e.load, fmt::format("{:.2f}", e.peak_um), fmt::format("{:.3f}", e.max_um),
                     fmt::format("{:.3f}", e.rms_um), fmt::format("{:.2f}", 100 * e.max_um / e.peak_um),
                     e.estimate_max_um > 0 ? fmt::format("{:.3f}", e.estimate_max_um) : "-",
                     e.estimate_max_um > 0 ? fmt::format("{:.2f}", e.effectivity) : "-"});
  }
  return table;
}

std::vector<std::vector<std::string>> off_grid_rows(const ReducedCase& made) {
  std::vector<std::vector<std::string>> table{
      {fmt::format("at {} poses between the stored ones", made.off_grid_poses.size()), "peak um", "max error um",
       "rms um", "of peak %", "with these poses' own rows um"}};
  for (const auto& e : made.off_grid) {
    table.push_back({e.load, fmt::format("{:.2f}", e.peak_um()), fmt::format("{:.3f}", e.max_um()),
                     fmt::format("{:.3f}", std::sqrt(e.rms.squaredNorm() / e.rms.size())),
                     fmt::format("{:.2f}", 100 * e.max_um() / e.peak_um()), fmt::format("{:.3f}", e.own_rows_um())});
  }
  return table;
}

std::vector<std::vector<std::string>> sensor_rows(const ReducedCase& made) {
  std::vector<std::vector<std::string>> table{
      {"sensors, held-out load", "max error K", "of sensor", "at h", "its range K", "rms K, all sensors"}};
  for (auto from = made.sensors.begin(); from != made.sensors.end();) {
    const auto to = std::find_if(from, made.sensors.end(), [&](const auto& e) { return e.load != from->load; });
    const auto worst = std::max_element(from, to, [](const auto& a, const auto& b) { return a.max_K < b.max_K; });
    const double squares =
        std::accumulate(from, to, 0.0, [](double sum, const auto& e) { return sum + e.rms_K * e.rms_K; });
    table.push_back({from->load, fmt::format("{:.3f}", worst->max_K), worst->sensor,
                     fmt::format("{:.2f}", worst->at_s / core::units::hour), fmt::format("{:.2f}", worst->range_K),
                     fmt::format("{:.3f}", std::sqrt(squares / std::distance(from, to)))});
    from = to;
  }
  return table;
}

std::vector<std::vector<std::string>> mesh_error_rows(const reduction::MeshError& error) {
  std::vector<std::string> head{fmt::format("mesh error, % (against {})", error.second)}, row{""};
  head.insert(head.end(), {"dx", "dy", "dz", "ra", "rb", "rc"});
  for (const double share : error.tcp) row.push_back(fmt::format("{:.2f}", 100 * share));
  head.push_back("sensors");
  row.push_back(error.sensors.size() == 0
                    ? "-"
                    : fmt::format("{:.2f} to {:.2f}", 100 * error.sensors.minCoeff(), 100 * error.sensors.maxCoeff()));
  return {head, row};
}

}  // namespace thermotwin::tools
