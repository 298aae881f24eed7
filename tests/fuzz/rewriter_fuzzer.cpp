// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes are a program of a warm five-axis machine: the interpreter or a rewriter refuses it with an InputError, or
// the corrected program is written and the interpreter reads it as it is meant. The first byte chooses the rewriter.
// Each program runs through the helper process twice, so that some tens of programs are tried in a second.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <unistd.h>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "nc/motion/axis_motion.h"
#include "nc/motion/planner.h"
#include "nc/prediction/prediction.h"
#include "nc/program/program.h"
#include "nc/rewrite/path_rewriter.h"
#include "nc/rewrite/read_back.h"
#include "nc/rewrite/shift_rewriter.h"
#include "tests/fuzz/require.h"
#include "tests/machines/five_axis.h"

using namespace thermotwin;

namespace fs = std::filesystem;

namespace {

const reduction::ReducedModel& model() {
  static const reduction::ReducedModel lumps = compensation::test::lumped_model();
  return lumps;
}

const nc::ControlProfile& control() {
  static const nc::ControlProfile profile = nc::ControlProfile::parse(
      "schema = 1\n[[word]]\nword = \"M428\"\naction = \"tcp_on\"\n[[word]]\nword = \"M429\"\naction = \"tcp_off\"\n"
      "[[tool]]\nnumber = 1\nlength_mm = 50\n[[tool]]\nnumber = 2\n[limits]\nmoves = 2000\n"
      "lines_without_move = 20000\nseconds = 2\n",
      "fuzz.toml", model().machine);
  return profile;
}

nc::PredictionOptions warm() {
  nc::PredictionOptions options;
  options.start_C = 28.0;
  return options;
}

/// A program on its way through the chain of `nc`.
class Correction {
public:
  Correction(const fs::path& program, bool shift)
      : motion_(model().machine),
        start_(mesh::home_pose(model().machine)),
        last_(start_),
        rows_(start_, warm().interval, process_, [this](const nc::Row& row) { predictor_.row(row); }),
        predictor_(model(), nullptr, start_, warm(), [this](const nc::PredictedMove& move) { predicted(move); }),
        planner_({control().axes, control().blend_tolerance, control().block_cycle, control().look_ahead,
                  control().overlaps_corners},
                 [this](const nc::Timed& timed) {
                   predictor_.add(timed);
                   rows_.add(timed);
                 }),
        read_back_(program.parent_path() / "moves.bin") {
    reading_.program = program;
    reading_.axis_mask = motion_.axis_mask();
    reading_.helper = THERMOTWIN_HELPER;
    reading_.start = motion_.letters_of(start_);
    nc::RewriteOptions options;
    options.words = control().words;
    if (shift)
      shift_ =
          std::make_unique<nc::ShiftRewriter>(nc::ProgramText::of_file(program), program.string(), motion_, options,
                                              [this](const nc::ExpectedMove& move) { read_back_.expect(move); });
    else
      path_ = std::make_unique<nc::PathRewriter>(
          nc::ProgramText::of_file(program), program.string(), motion_, options,
          [this](const std::string& text) { text_ += text; },
          [this](const nc::ExpectedMove& move, const std::vector<nc::ExpectedPoint>& inside) {
            read_back_.expect(move, inside);
          });
  }

  void run() {
    const nc::ProgramSummary program = nc::read_program(reading_, control(), sink());
    planner_.finish();
    rows_.finish();
    if (shift_) shift_->finish([this](const std::string& text) { text_ += text; });
    if (path_ && !path_->finish()) return;  // no offset: the original holds
    core::write_file(reading_.program, text_);
    read_back_.check(reading_, control(), program, shift_ ? shift_->largest_update() : 0.0);
  }

private:
  nc::ProgramSink sink() {
    nc::ProgramSink sink;
    sink.block = [this](const nc::Block& block, const nc::Frame& frame) {
      file_ = block.file;
      if (path_) path_->block(block.state, block.file, frame);
      if (shift_) shift_->block(block.state, block.file, frame);
    };
    sink.skipped = [this] {
      if (path_) path_->skipped();
    };
    sink.move = [this](const nc::Move& given, const nc::Frame& frame) {
      nc::Move move = given;
      if (move.state.tcp != tcp_) {
        move.from = motion_.values(last_, move, move.from);
        if (move.kind != nc::MoveKind::arc) move.length = nc::straight_length(move.to - move.from);
        if (!(move.length > 0.0)) return;
      }
      tcp_ = move.state.tcp;
      if (path_) path_->move();
      if (shift_) shift_->move(move);
      motion_.elements(move, file_, std::make_shared<nc::Source>(nc::Source{move, frame}), [&](nc::Element&& element) {
        last_ = element.end();
        planner_.push(std::move(element));
      });
    };
    sink.pause = [this](const nc::Pause& pause) {
      if (path_ && pause.kind == nc::Pause::Kind::dwell) path_->dwell(pause.seconds);
      nc::Element stand = nc::Element::line(last_, last_);
      // The heat of a longer one takes time to compute and says nothing new.
      stand.pause = std::min(pause.seconds, 100.0);
      stand.state = pause.state;
      if (stand.pause > 0.0) planner_.push(std::move(stand));
    };
    return sink;
  }
  void predicted(const nc::PredictedMove& move) {
    require(move.offset_um.allFinite() && move.time >= move.start, "a prediction is a number");
    if (path_ && move.timed->element.source) path_->predicted(move);
    if (shift_ && move.timed->element.source) shift_->predicted(move);
  }

  nc::AxisMotion motion_;
  nc::Positions start_, last_;
  nc::ProcessHeat process_;
  nc::RowBuilder rows_;
  nc::Predictor predictor_;
  nc::Planner planner_;
  nc::ReadBack read_back_;
  nc::InterpreterOptions reading_;
  std::unique_ptr<nc::PathRewriter> path_;
  std::unique_ptr<nc::ShiftRewriter> shift_;
  std::string file_, text_;
  bool tcp_ = false;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  static const fs::path folder = [] {
    fs::path made = fs::temp_directory_path() / ("thermotwin_rewriter_" + std::to_string(::getpid()));
    fs::create_directories(made);
    return made;
  }();
  const fs::path program = folder / "part.ngc";
  core::write_file(program, std::string(reinterpret_cast<const char*>(data + 1), size - 1));
  try {
    Correction(program, data[0] % 2 == 1).run();
  } catch (const core::InputError&) {}
  return 0;
}
