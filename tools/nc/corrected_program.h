// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The corrected program of `nc --rewrite`, written by one of the two rewriters.

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "nc/control/control_profile.h"
#include "nc/rewrite/path_rewriter.h"
#include "nc/rewrite/read_back.h"
#include "nc/rewrite/shift_rewriter.h"
#include "tools/nc/nc.h"

namespace thermotwin::tools {

class CorrectedProgram {
public:
  /// @param options  with a rewriter @param limits  of the offsets @param folder  where the program goes
  CorrectedProgram(const NcOptions& options, const nc::ControlProfile& control, const nc::AxisMotion& motion,
                   const compensation::OffsetLimits& limits, const std::filesystem::path& folder);

  /// In the interpreter's order. @param frame  before the line runs
  void block(const nc::Block& block, const nc::Frame& frame);
  void skipped();
  void move(const nc::Move& move);
  void pause(const nc::Pause& pause);
  /// In the same order, later.
  void predicted(const nc::PredictedMove& move);
  /// The end of the program: the file is whole, and the interpreter has read it again.
  /// @param program  as it was read  @param reading  how it was read
  /// @throws InputError  if it cannot be written, or does anything else than is meant
  void finish(const nc::ProgramSummary& program, const nc::InterpreterOptions& reading);

  const std::string& name() const { return name_; }  ///< of the file
  const nc::RewriteSummary& summary() const { return path_ ? path_->summary() : shift_->summary(); }
  nlohmann::json json() const;
  std::string text() const;

private:
  void close();
  void state_zero_offsets();
  void read_back(const nc::ProgramSummary& program, nc::InterpreterOptions reading);

  const nc::ControlProfile& control_;
  std::filesystem::path program_, out_, file_;
  std::string name_;
  std::ofstream stream_;
  nc::ReadBack read_back_;
  std::unique_ptr<nc::PathRewriter> path_;
  std::unique_ptr<nc::ShiftRewriter> shift_;
  std::vector<int> assumed_zero_;  ///< numbers of updated work offsets that the profile does not state
};

}  // namespace thermotwin::tools
