// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/load/process_heat.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/text.h"
#include "core/unique_id.h"

namespace thermotwin::nc {

using core::Absent;
using core::InputError;
using core::KeyTable;
using core::non_negative;
using core::required;
namespace key = core::key;

namespace {

const KeyTable heat_table{
    "heat",
    "A share of the process power. The shares add up to at most 1; the rest leaves the machine.",
    {
        key::text("drive", required,
                  "Drive of a `[[source]]` in machine.toml, such as chips, tool, workpiece or fluid; its channel is "
                  "`<drive>.power_W`."),
        key::number("share", "1", {0.0, 1.0}, required, "Its share of the power."),
    }};

const KeyTable tool_table{
    "tool",
    "A tool.",
    {
        key::whole("number", 0, 99999, required, "Its number, as T calls it; 0: cuts before the first tool change."),
        key::number("power_W", "W", non_negative, 0.0,
                    "Power of the spindle while the tool cuts; `spindle_power_W` of `nc --log` replaces it."),
        key::number("idle_W", "W", non_negative, 0.0,
                    "Power of the spindle at this speed without a cut; it is subtracted from the power while the tool "
                    "cuts."),
        key::tables("heat", heat_table, Absent{"those of the file"}, "Its own shares."),
    }};

const KeyTable process_file{"process.toml",
                            "Heat of the cutting process for `nc --process`: the power of tools, and where it goes.",
                            {
                                key::schema(),
                                key::tables("heat", heat_table, Absent{"those of the tools"},
                                            "Shares of the power, for tools without shares of their own."),
                                key::tables("tool", tool_table, Absent{"the power of `nc --log`"}, "Tools."),
                            }};

std::vector<std::string> drives_of(const mesh::Machine& machine) {
  std::vector<std::string> drives;
  for (const mesh::SourceSpec& source : machine.sources)
    if (!source.drive.empty() && std::find(drives.begin(), drives.end(), source.drive) == drives.end())
      drives.push_back(source.drive);
  return drives;
}

}  // namespace

const KeyTable& process_keys() { return process_file; }

ProcessHeat ProcessHeat::load(const std::filesystem::path& path, const mesh::Machine& machine) {
  return {core::Config::load(path, &process_keys()), machine};
}

ProcessHeat::ProcessHeat(const core::Config& config, const mesh::Machine& machine) {
  const core::Node root = config.root();
  root.schema(1);
  other_.shares = read_shares(root, "heat", machine);
  for (const core::Node& node : root.tables("tool")) {
    const int number = node.integer("number");
    ToolPower tool;
    tool.power = node.number("power_W");
    tool.idle = node.number("idle_W");
    if (node.has("heat")) tool.shares = read_shares(node, "heat", machine);
    node.finish();
    if (!tools_.emplace(number, tool).second)
      throw InputError(node.place("number"), fmt::format("tool {} twice", number), "each tool once");
  }
  root.finish();
  const Eigen::Index count = std::ssize(drives_);
  if (count == 0) throw InputError(root.place(), "no heat", "one or more [[heat]], of the file or of its tools");
  other_.shares.conservativeResizeLike(Eigen::VectorXd::Zero(count));
  for (auto& [number, tool] : tools_) {
    if (tool.shares.size() == 0) tool.shares = other_.shares;
    tool.shares.conservativeResizeLike(Eigen::VectorXd::Zero(count));
  }
}

/// @return (drives so far) shares of the file or of a tool
Eigen::VectorXd ProcessHeat::read_shares(const core::Node& parent, const std::string& key,
                                         const mesh::Machine& machine) {
  const std::vector<std::string> known = drives_of(machine);
  std::vector<std::string> seen;
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(std::ssize(drives_));
  for (const core::Node& node : parent.tables(key)) {
    const std::string drive = node.text("drive");
    core::require_unique_id(drive, node.place("drive"), seen);
    if (std::find(known.begin(), known.end(), drive) == known.end())
      throw InputError(
          node.place("drive"), fmt::format("'{}', which no source of {} has", drive, machine.name),
          known.empty() ? "a drive of a [[source]]; machine.toml has none" : "one of: " + core::join(known));
    const auto at = std::find(drives_.begin(), drives_.end(), drive) - drives_.begin();
    if (at == std::ssize(drives_)) drives_.push_back(drive);
    shares.conservativeResizeLike(Eigen::VectorXd::Zero(std::ssize(drives_)));
    shares[at] = node.number("share");
    node.finish();
    if (shares.sum() > 1.0 + 1e-9)
      throw InputError(node.place("share"), fmt::format("shares that add up to {:.6g}", shares.sum()), "at most 1");
  }
  return shares;
}

void ProcessHeat::add(const Timed& timed, double from, double to, Eigen::VectorXd& energy) {
  const Element& element = timed.element;
  if (drives_.empty() || element.rapid || element.pause > 0.0 || element.state.spindle_rpm == 0.0) return;
  const auto found = tools_.find(element.state.tool);
  const ToolPower& tool = found != tools_.end() ? found->second : other_;
  if (!measured_ && found == tools_.end()) unknown_.insert(element.state.tool);
  const double given = measured_ ? measured_(from, to) : tool.power * (to - from);
  energy += std::max(0.0, given - tool.idle * (to - from)) * tool.shares;
}

}  // namespace thermotwin::nc
