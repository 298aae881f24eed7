// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Heat of the cutting process: the power of the spindle while a tool cuts, divided by stated shares between sources of
// the machine: those of the chips, the tool, the workpiece and the fluid. A tool cuts while the spindle turns in a feed
// move. docs/reference/process.md documents the file's keys.

#include <Eigen/Core>

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/config.h"
#include "core/key_table.h"
#include "mesh/machine/machine.h"
#include "nc/motion/planner.h"

namespace thermotwin::nc {

const core::KeyTable& process_keys();

class ProcessHeat {
public:
  /// J of the spindle between two times of the program
  using Measured = std::function<double(double from, double to)>;

  ProcessHeat() = default;  ///< none
  /// @throws InputError (file, line, key)
  ProcessHeat(const core::Config& config, const mesh::Machine& machine);
  static ProcessHeat load(const std::filesystem::path& path, const mesh::Machine& machine);

  /// The measured power in place of that of the tools.
  void use(Measured measured) { measured_ = std::move(measured); }

  /// Of the machine's sources; their channels are DRIVE.power_W.
  const std::vector<std::string>& drives() const { return drives_; }
  /// Adds the heat of a stretch of an element. @param energy  (drives) J
  void add(const Timed& timed, double from, double to, Eigen::VectorXd& energy);
  /// Tools that cut and whose power is not known; it was taken to be 0.
  const std::set<int>& unknown_tools() const { return unknown_; }

private:
  struct ToolPower {
    double power = 0, idle = 0;  ///< W
    Eigen::VectorXd shares;      ///< (drives)
  };
  Eigen::VectorXd read_shares(const core::Node& node, const std::string& key, const mesh::Machine& machine);

  std::vector<std::string> drives_;
  ToolPower other_;  ///< tools that the file does not have
  std::map<int, ToolPower> tools_;
  Measured measured_;
  std::set<int> unknown_;
};

}  // namespace thermotwin::nc
