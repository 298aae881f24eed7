// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/corrected_program.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::tools {

CorrectedProgram::CorrectedProgram(const NcOptions& options, const nc::ControlProfile& control,
                                   const nc::AxisMotion& motion, const std::filesystem::path& folder)
    : program_(options.program),
      out_(options.out),
      name_(options.program.stem().string() + ".corrected" + options.program.extension().string()) {
  nc::RewriteOptions rewrite;
  rewrite.tolerance = options.tolerance_um * core::units::um;
  rewrite.words = control.words;
  file_ = folder / name_;
  stream_.open(file_, std::ios::binary);
  nc::ProgramText lines = nc::ProgramText::of_file(program_);
  if (options.rewrite == "shift") {
    shift_ = std::make_unique<nc::ShiftRewriter>(std::move(lines), program_.string(), motion, rewrite);
    return;
  }
  path_ = std::make_unique<nc::PathRewriter>(std::move(lines), program_.string(), motion, rewrite,
                                             [this](const std::string& text) { stream_ << text; });
}

void CorrectedProgram::block(const nc::Block& block, const nc::Frame& frame) {
  if (path_) path_->block(block.state, block.file, frame);
  if (shift_) shift_->block(block.state, block.file, frame);
}

void CorrectedProgram::skipped() {
  if (path_) path_->skipped();
}

void CorrectedProgram::move(const nc::Move& move) {
  if (path_) path_->move();
  if (shift_) shift_->move(move);
}

void CorrectedProgram::predicted(const nc::PredictedMove& move) {
  if (path_) path_->predicted(move);
  if (shift_) shift_->predicted(move);
}

void CorrectedProgram::finish() {
  if (shift_) shift_->finish([this](const std::string& text) { stream_ << text; });
  const bool differs = shift_ || path_->finish();
  close();
  if (differs) return;
  // Without a displacement loops and subprograms stay as well.
  stream_.open(file_, std::ios::binary | std::ios::trunc);
  stream_ << std::ifstream(program_, std::ios::binary).rdbuf();
  close();
}

void CorrectedProgram::close() {
  stream_.close();
  if (!stream_)
    throw core::InputError((out_ / name_).string(), "cannot be written", "a place with room and permission");
}

nlohmann::json CorrectedProgram::json() const {
  const nc::RewriteSummary& rewrite = summary();
  nlohmann::json json = {{"program", name_},
                         {"lines_before", rewrite.lines_before},
                         {"lines_after", rewrite.lines_after},
                         {"changed", rewrite.changed},
                         {"split", rewrite.split},
                         {"cycles_written_out", rewrite.written_out},
                         {"largest_displacement_um", rewrite.largest_um}};
  if (shift_) json["largest_deviation_um"] = shift_->largest_left_um();
  return json;
}

std::string CorrectedProgram::text() const {
  const nc::RewriteSummary& rewrite = summary();
  return fmt::format("{}: {} of {} lines changed, {} lines; largest displacement {:.2f} um", name_, rewrite.changed,
                     rewrite.lines_before, rewrite.lines_after, rewrite.largest_um);
}

}  // namespace thermotwin::tools
