// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The corrected program of `nc --rewrite`, written by one of the two rewriters.

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "nc/control/control_profile.h"
#include "nc/rewrite/path_rewriter.h"
#include "nc/rewrite/shift_rewriter.h"
#include "tools/nc/nc.h"

namespace thermotwin::tools {

class CorrectedProgram {
public:
  /// @param options  with a rewriter @param folder  where the program goes
  CorrectedProgram(const NcOptions& options, const nc::ControlProfile& control, const nc::AxisMotion& motion,
                   const std::filesystem::path& folder);

  /// In the interpreter's order. @param frame  before the line runs
  void block(const nc::Block& block, const nc::Frame& frame);
  void skipped();
  void move(const nc::Move& move);
  /// In the same order, later.
  void predicted(const nc::PredictedMove& move);
  /// The end of the program: the file is whole. @throws InputError  if it cannot be written
  void finish();

  const std::string& name() const { return name_; }  ///< of the file
  const nc::RewriteSummary& summary() const { return path_ ? path_->summary() : shift_->summary(); }
  nlohmann::json json() const;
  std::string text() const;

private:
  void close();

  std::filesystem::path program_, out_, file_;
  std::string name_;
  std::ofstream stream_;
  std::unique_ptr<nc::PathRewriter> path_;
  std::unique_ptr<nc::ShiftRewriter> shift_;
};

}  // namespace thermotwin::tools
