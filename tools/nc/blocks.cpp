// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/blocks.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include "core/units.h"

namespace thermotwin::tools {

namespace units = core::units;

std::string blocks_header(const mesh::Machine& machine, const std::vector<std::string>& axes) {
  std::string text = "part,move,line,operation,tool,rapid,time_s";
  for (const std::string& column : mesh::pose_columns(machine)) text += "," + column;
  text += ",dx_um,dy_um,dz_um";
  for (const std::string& axis : axes) text += ",offset_" + axis + "_um";
  for (const std::string& axis : axes) text += ",std_" + axis + "_um";
  return text + ",file\n";
}

std::string block_text(const mesh::Machine& machine, const nc::PredictedMove& move, long number) {
  const nc::MoveState& state = move.timed->element.state;
  fmt::memory_buffer out;
  const fmt::appender at(out);
  fmt::format_to(at, FMT_COMPILE("{},{},{},{},{},{:d},{:.6f}"), state.part + 1, number, state.line, state.operation,
                 state.tool, move.timed->element.rapid, move.time);
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const bool linear = machine.axes[i].kind == mesh::AxisKind::linear;
    fmt::format_to(at, FMT_COMPILE(",{:.6f}"), move.end[i] / (linear ? units::mm : units::deg));
  }
  for (int i = 0; i < 3; ++i) fmt::format_to(at, FMT_COMPILE(",{:.4f}"), move.error_um[i]);
  for (const double value : move.offset_um) fmt::format_to(at, FMT_COMPILE(",{:.4f}"), value);
  for (const double value : move.std_um) fmt::format_to(at, FMT_COMPILE(",{:.4f}"), value);
  fmt::format_to(at, FMT_COMPILE(",{}\n"), state.file);
  return fmt::to_string(out);
}

}  // namespace thermotwin::tools
