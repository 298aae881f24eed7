// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/corrected_program.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "core/error.h"
#include "core/progress.h"
#include "core/units.h"

namespace thermotwin::tools {

CorrectedProgram::CorrectedProgram(const NcOptions& options, const nc::ControlProfile& control,
                                   const nc::AxisMotion& motion, const compensation::OffsetLimits& limits,
                                   const std::filesystem::path& folder)
    : control_(control),
      program_(options.program),
      out_(options.out),
      name_(options.program.stem().string() + ".corrected" + options.program.extension().string()),
      read_back_(folder / "moves.bin") {
  nc::RewriteOptions rewrite;
  rewrite.tolerance = options.tolerance_um * core::units::um;
  rewrite.words = control.words;
  rewrite.dwells_in_ms = control.dialect == nc::Dialect::fanuc;
  file_ = folder / name_;
  stream_.open(file_, std::ios::binary);
  nc::ProgramText lines = nc::ProgramText::of_file(program_);
  if (options.rewrite == "shift") {
    shift_ = std::make_unique<nc::ShiftRewriter>(std::move(lines), program_.string(), motion, rewrite,
                                                 [this](const nc::ExpectedMove& move) { read_back_.expect(move); });
    return;
  }
  rewrite.largest_offset = std::min(rewrite.largest_offset, limits.largest_um * core::units::um);
  path_ = std::make_unique<nc::PathRewriter>(
      std::move(lines), program_.string(), motion, rewrite, [this](const std::string& text) { stream_ << text; },
      [this](const nc::ExpectedMove& move, const std::vector<nc::ExpectedPoint>& inside) {
        read_back_.expect(move, inside);
      });
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

void CorrectedProgram::pause(const nc::Pause& pause) {
  if (path_ && pause.kind == nc::Pause::Kind::dwell) path_->dwell(pause.seconds);
}

void CorrectedProgram::predicted(const nc::PredictedMove& move) {
  if (path_) path_->predicted(move);
  if (shift_) shift_->predicted(move);
}

void CorrectedProgram::finish(const nc::ProgramSummary& program, const nc::InterpreterOptions& reading) {
  if (shift_) shift_->finish([this](const std::string& text) { stream_ << text; });
  state_zero_offsets();
  const bool differs = shift_ || path_->finish();
  close();
  if (differs) {
    read_back(program, reading);
    return;
  }
  // Without a displacement loops and subprograms stay as well.
  stream_.open(file_, std::ios::binary | std::ios::trunc);
  stream_ << std::ifstream(program_, std::ios::binary).rdbuf();
  close();
}

/// An update is absolute: where the profile does not state the work offset, it replaces the one that the control has.
void CorrectedProgram::state_zero_offsets() {
  if (!shift_) return;
  std::string names;
  for (const int number : shift_->updated()) {
    const bool stated = std::any_of(control_.work_offsets.begin(), control_.work_offsets.end(),
                                    [&](const nc::WorkOffset& offset) { return offset.number == number; });
    if (stated) continue;
    assumed_zero_.push_back(number);
    names += (names.empty() ? "" : ", ") +
             (number <= 6 ? fmt::format("G{}", 53 + number) : fmt::format("G59.{}", number - 6));
  }
  if (names.empty()) return;
  core::warn(
      fmt::format("{}: the work offset {} is not stated and taken to be zero; the G10 L2 lines of {} would "
                  "replace the one of the control. State it as [[work_offset]] in a control profile (--control)",
                  program_.string(), names, name_));
}

/// The interpreter reads below one folder only, so the subprograms go beside the corrected program.
void CorrectedProgram::read_back(const nc::ProgramSummary& program, nc::InterpreterOptions reading) {
  const std::filesystem::path beside = file_.parent_path() / "again";
  const std::filesystem::path folder =
      std::filesystem::canonical(reading.folder.empty() ? program_.parent_path() / "." : reading.folder);
  std::filesystem::create_directories(beside);
  if (shift_)
    for (const std::string& file : program.files) {
      if (file == program_.string()) continue;
      const std::filesystem::path below = std::filesystem::relative(file, folder);
      if (below.empty() || *below.begin() == "..")
        throw core::InputError(file, "outside of " + folder.string(), "subprograms below the program's folder");
      const std::filesystem::path copy = beside / below;
      std::filesystem::create_directories(copy.parent_path());
      std::filesystem::copy_file(file, copy, std::filesystem::copy_options::overwrite_existing);
    }
  std::filesystem::rename(file_, beside / name_);
  reading.program = beside / name_;
  reading.folder = beside;
  read_back_.check(reading, control_, program, shift_ ? shift_->largest_update() : 0.0);
  std::filesystem::rename(beside / name_, file_);
  std::filesystem::remove_all(beside);
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
  if (shift_) {
    json["largest_deviation_um"] = shift_->largest_left_um();
    json["work_offsets_assumed_zero"] = assumed_zero_;
  }
  return json;
}

std::string CorrectedProgram::text() const {
  const nc::RewriteSummary& rewrite = summary();
  return fmt::format("{}: {} of the file's {} lines changed, {} lines written; largest displacement {:.2f} um", name_,
                     rewrite.changed, rewrite.lines_before, rewrite.lines_after, rewrite.largest_um) +
         (assumed_zero_.empty() ? "" : "; work offsets that are not stated were taken to be zero");
}

}  // namespace thermotwin::tools
