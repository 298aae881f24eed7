// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/axis_files.h"

#include <fmt/format.h>

#include "core/file.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::tools {

std::string lines_csv(const std::vector<std::string>& axes, const std::vector<compensation::AxisLine>& lines,
                      double time) {
  std::string text = "time_s,axis,reference_mm,offset_um,slope_um_per_m,left_travel_um,left_across_um\n";
  for (std::size_t a = 0; a < lines.size(); ++a) {
    const compensation::AxisLine& line = lines[a];
    text += fmt::format("{},{},{:.4f},{:.3f},{:.4f},{:.3f},{:.3f}\n", time, axes[a], line.reference / core::units::mm,
                        line.offset_um, line.slope_um_m, line.left_travel_um, line.left_across_um);
  }
  return text;
}

std::string write_axis_errors(const std::filesystem::path& folder, const compensation::ErrorTables& tables) {
  core::write_files_by(folder, [&](const std::filesystem::path& staged) {
    std::vector<std::filesystem::path> names;
    for (const compensation::AxisErrors& table : tables.axes) {
      const std::string of = core::lower(table.axis);
      std::string text =
          fmt::format("position_mm,ex{0}_um,ey{0}_um,ez{0}_um,ea{0}_um_per_m,eb{0}_um_per_m,ec{0}_um_per_m\n", of);
      for (Eigen::Index i = 0; i < table.position.size(); ++i) {
        text += fmt::format("{:.4f}", table.position[i] / core::units::mm);
        for (const double value : table.errors.col(i)) text += fmt::format(",{:.4f}", value);
        text += '\n';
      }
      names.emplace_back("axis_" + table.axis + ".csv");
      core::write_file(staged / names.back(), text);
    }
    return names;
  });
  const auto left = [](const Eigen::Vector3d& um) {
    return fmt::format("x {:.2f}, y {:.2f}, z {:.2f} um", um[0], um[1], um[2]);
  };
  std::string text = fmt::format("tables along the axes leave {} over the workspace", left(tables.left_um));
  for (const compensation::AxisErrors& table : tables.axes) {
    const char direction = "xyz"[table.along];
    const std::string of = core::lower(table.axis);
    if (!of.starts_with(direction))
      text += fmt::format("; axis {} moves along {}: its positioning error is e{}{}_um", table.axis, direction,
                          direction, of);
  }
  if (tables.rotary.empty()) return text;
  std::vector<std::string> at, between;
  for (const compensation::RotaryRange& axis : tables.rotary) {
    at.push_back(fmt::format("{} {:.4g}", axis.axis, axis.middle / core::units::deg));
    between.push_back(
        fmt::format("{} {:.4g} to {:.4g}", axis.axis, axis.low / core::units::deg, axis.high / core::units::deg));
  }
  return fmt::format("{} with {} deg, and {} with {} deg as in the tables", text, core::join(between),
                     left(tables.left_at_rotary_middle_um), core::join(at));
}

}  // namespace thermotwin::tools
