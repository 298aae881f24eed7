// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/summary.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <vector>

#include "core/text.h"
#include "core/units.h"
#include "nc/prediction/cycle_drift.h"
#include "tools/nc/offset_excess.h"

namespace thermotwin::tools {

namespace units = core::units;

nlohmann::json summary(const Outcome& found) {
  nlohmann::json travel = nlohmann::json::object(), rows = nlohmann::json::object();
  for (std::size_t i = 0; i < found.twin.machine.axes.size(); ++i) {
    const mesh::Axis& axis = found.twin.machine.axes[i];
    const bool linear = axis.kind == mesh::AxisKind::linear;
    const double unit = linear ? units::mm : units::deg;
    const std::string name = axis.id + (linear ? "_mm" : "_deg");
    travel[name] = found.travel[i] / unit;
    rows[name] = found.rows_travel[i] / unit;
  }
  nlohmann::json json = {{"duration_s", found.duration_s},
                         {"moves", found.program.moves},
                         {"lines", found.program.blocks},
                         {"feeds", found.program.feeds},
                         {"traverses", found.program.traverses},
                         {"arcs", found.program.arcs},
                         {"tool_changes", found.program.tool_changes},
                         {"operations", found.operations.count()},
                         {"files", found.program.files},
                         {"cutting_s", found.cutting_s},
                         {"rapid_s", found.rapid_s},
                         {"pause_s", found.pause_s},
                         {"travel", travel},
                         {"travel_rows", rows},
                         {"rows", found.rows}};
  if (found.has_model()) {
    nlohmann::json largest = nlohmann::json::object(), std = nlohmann::json::object();
    for (std::size_t i = 0; i < found.axes.size(); ++i) {
      largest[found.axes[i]] = found.largest_um.size() > 0 ? found.largest_um[i] : 0.0;
      std[found.axes[i]] = found.std_um.size() > 0 ? found.std_um[i] : 0.0;
    }
    json["largest_offset_um"] = largest;
    json["largest_std_um"] = std;
    found.uncorrected.to(json);
    json["moves_outside_workspace"] = found.outside;
    to_json(*found.beyond, json);
    if (found.options.repeat > 1 && found.predicted > 0) {
      const int good = found.parts.first_good(found.options.tolerance_um);
      json["first_good_part"] = good;
      json["warm_up_s"] = good > 0 ? found.parts.start_of(good) : 0.0;
      const double ahead = found.parts.drift_ahead();
      json["settled"] = ahead <= found.options.tolerance_um;
      json["drift_ahead_um"] = std::isfinite(ahead) ? nlohmann::json(ahead) : nlohmann::json();
    }
  }
  if (found.imprint)
    for (const auto& [line, block] : found.imprint->blocks()) {
      const Eigen::Vector3d mean = block.error.sum / block.error.count, range = block.error.high - block.error.low;
      json["imprint"].push_back({{"line", line},
                                 {"runs", block.runs},
                                 {"mean_um", std::vector<double>(mean.begin(), mean.end())},
                                 {"range_um", std::vector<double>(range.begin(), range.end())}});
    }
  if (found.corrected) json["rewrite"] = found.corrected->json();
  return json;
}

std::string summary_text(const Outcome& found) {
  std::string text = fmt::format(
      "nc: {:.1f} s: {:.1f} s cutting, {:.1f} s rapid, {:.1f} s at rest; {} moves in {} executed lines, {} tool "
      "changes",
      found.duration_s, found.cutting_s, found.rapid_s, found.pause_s, found.program.moves, found.program.blocks,
      found.program.tool_changes);
  if (found.has_model() && found.largest_um.size() > 0) {
    text += "\nlargest offset of a cutting move:";
    for (std::size_t i = 0; i < found.axes.size(); ++i)
      text += fmt::format("{} {} {:.2f} um", i > 0 ? "," : "", found.axes[i], found.largest_um[i]);
    if (const std::string stays = found.uncorrected.sentence(); !stays.empty()) text += "\n" + stays;
  }
  if (found.corrected) text += "\n" + found.corrected->text();
  if (found.options.repeat > 1 && found.predicted > 0) {
    const int good = found.parts.first_good(found.options.tolerance_um);
    text += fmt::format("\nfirst part within {:.3g} um of the last one: number {}, after {:.0f} s",
                        found.options.tolerance_um, good, found.parts.start_of(good));
    if (const double ahead = found.parts.drift_ahead(); ahead > found.options.tolerance_um)
      text += "\n" + nc::unsettled_text(ahead, found.options.tolerance_um, "um");
  }
  if (found.imprint)
    text += fmt::format("\nimprint of tool {}, tool against workpiece:\n", found.imprint->tool()) +
            core::format_table(nc::imprint_table(*found.imprint, 40)) +
            (found.imprint->blocks().size() > 40 ? "further lines are in imprint.csv" : "");
  if (found.outside > 0)
    text += fmt::format("\n{} of {} moves end outside of the model's workspace", found.outside, found.predicted);
  if (found.beyond) text += beyond_text(*found.beyond);
  return text;
}

}  // namespace thermotwin::tools
