// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/nc.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <map>
#include <memory>
#include <optional>

#include "core/error.h"
#include "core/file.h"
#include "core/range.h"
#include "core/text.h"
#include "core/units.h"
#include "mesh/machine/file.h"
#include "nc/motion/axis_motion.h"
#include "nc/prediction/prediction.h"
#include "nc/rewrite/path_rewriter.h"
#include "nc/rewrite/shift_rewriter.h"
#include "reduction/model/model_file.h"

namespace thermotwin::tools {

namespace units = core::units;

namespace {

/// The machine, and the model where one was given.
struct Twin {
  std::optional<reduction::ReducedModel> model;
  mesh::Machine machine;
};

Twin read_twin(const std::filesystem::path& path) {
  Twin twin;
  if (std::filesystem::is_directory(path) || path.extension() == ".toml") {
    twin.machine = mesh::read_machine(std::filesystem::is_directory(path) ? path / "machine.toml" : path);
  } else {
    twin.model = reduction::read_model(path);
    twin.machine = twin.model->machine;
  }
  return twin;
}

/// What a tool did between two changes.
struct Operation {
  int tool = 0;
  std::uint32_t first_line = 0, last_line = 0;
  double start = 0, end = 0, cutting_s = 0, rapid_s = 0, pause_s = 0, feed_length = 0, rpm_s = 0, fluid_s = 0;
  long moves = 0;
  Eigen::ArrayXd largest_um, sum_um, std_um;  ///< (linear axes) of the offsets at the ends of cutting moves
  long cuts = 0;
  bool any = false;
};

/// Offsets of the cutting moves of each part of a series.
class Parts {
public:
  void add(const nc::PredictedMove& move) {
    if (move.timed->element.rapid) return;
    Part& part = parts_[move.timed->element.state.part];
    const Eigen::ArrayXd offset = move.offset_um.array();
    if (part.moves == 0) {
      part.sum = Eigen::ArrayXd::Zero(offset.size());
      part.low = part.high = offset;
      part.start = move.time;
    }
    ++part.moves;
    part.sum += offset;
    part.low = part.low.min(offset);
    part.high = part.high.max(offset);
    part.end = move.time;
  }
  std::string csv(const std::vector<std::string>& axes) const {
    std::string text = "part,start_s,end_s";
    for (const std::string& axis : axes) text += fmt::format(",mean_offset_{0}_um,low_{0}_um,high_{0}_um", axis);
    text += "\n";
    for (const auto& [number, part] : parts_) {
      text += fmt::format("{},{:.6f},{:.6f}", number + 1, part.start, part.end);
      for (Eigen::Index i = 0; i < part.sum.size(); ++i)
        text += fmt::format(",{:.5g},{:.5g},{:.5g}", part.sum[i] / static_cast<double>(part.moves), part.low[i],
                            part.high[i]);
      text += "\n";
    }
    return text;
  }
  /// The first part whose mean offsets, and those of all after it, are within a tolerance of the last part's; from 1.
  int first_good(double within_um) const {
    int good = 0;
    for (auto part = parts_.rbegin(); part != parts_.rend(); ++part) {
      const Eigen::ArrayXd apart = part->second.mean() - parts_.rbegin()->second.mean();
      if (apart.abs().maxCoeff() > within_um) break;
      good = part->first + 1;
    }
    return good;
  }
  double start_of(int part) const { return parts_.at(part - 1).start; }

private:
  struct Part {
    double start = 0, end = 0;
    long moves = 0;
    Eigen::ArrayXd sum, low, high;
    Eigen::ArrayXd mean() const { return sum / static_cast<double>(moves); }
  };
  std::map<int, Part> parts_;
};

class Operations {
public:
  void add(const nc::Timed& timed) {
    Operation& operation = at(timed.element.state);
    const double duration = timed.duration(), end = timed.start + duration;
    if (!operation.any) {
      operation.start = timed.start;
      operation.first_line = timed.element.state.line;
      operation.any = true;
    }
    operation.end = end;
    operation.tool = timed.element.state.tool;
    operation.last_line = std::max(operation.last_line, timed.element.state.line);
    operation.rpm_s += std::abs(timed.element.state.spindle_rpm) * duration;
    if (timed.element.state.flood || timed.element.state.mist) operation.fluid_s += duration;
    if (timed.element.pause > 0.0) {
      operation.pause_s += duration;
    } else if (timed.element.rapid) {
      operation.rapid_s += duration;
    } else {
      operation.cutting_s += duration;
      operation.feed_length += timed.element.length;
    }
    if (timed.element.last) ++operation.moves;
  }
  void add(const nc::PredictedMove& move) {
    if (move.timed->element.rapid) return;
    Operation& operation = at(move.timed->element.state);
    const Eigen::ArrayXd offset = move.offset_um.array();
    if (operation.cuts == 0) {
      operation.largest_um = operation.sum_um = operation.std_um = Eigen::ArrayXd::Zero(offset.size());
    }
    ++operation.cuts;
    for (Eigen::Index i = 0; i < offset.size(); ++i)
      if (std::abs(offset[i]) > std::abs(operation.largest_um[i])) operation.largest_um[i] = offset[i];
    operation.sum_um += offset;
    operation.std_um = operation.std_um.max(move.std_um.array());
  }
  std::string csv(const std::vector<std::string>& axes) const {
    std::string text =
        "part,operation,tool,first_line,last_line,start_s,end_s,cutting_s,rapid_s,pause_s,feed_length_mm,"
        "mean_feed_mm_min,mean_spindle_rpm,fluid_share,moves";
    for (const std::string& axis : axes)
      text += fmt::format(",mean_offset_{0}_um,largest_offset_{0}_um,std_{0}_um", axis);
    text += "\n";
    for (const auto& [key, o] : operations_) {
      if (!o.any) continue;
      const double duration = std::max(o.end - o.start, 1e-12);
      text +=
          fmt::format("{},{},{},{},{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.6g},{:.6g},{:.6g},{}", key.first + 1,
                      key.second, o.tool, o.first_line, o.last_line, o.start, o.end, o.cutting_s, o.rapid_s, o.pause_s,
                      o.feed_length / units::mm, o.cutting_s > 0 ? o.feed_length / units::mm / o.cutting_s * 60.0 : 0.0,
                      o.rpm_s / duration, o.fluid_s / duration, o.moves);
      for (std::size_t i = 0; i < axes.size(); ++i) {
        const Eigen::Index k = i;
        text += o.cuts == 0 ? ",,,"
                            : fmt::format(",{:.5g},{:.5g},{:.4g}", o.sum_um[k] / static_cast<double>(o.cuts),
                                          o.largest_um[k], o.std_um[k]);
      }
      text += "\n";
    }
    return text;
  }
  std::size_t count() const {
    return std::count_if(operations_.begin(), operations_.end(), [](const auto& one) { return one.second.any; });
  }

private:
  Operation& at(const nc::MoveState& state) { return operations_[{state.part, state.operation}]; }
  std::map<std::pair<int, int>, Operation> operations_;
};

std::string blocks_header(const mesh::Machine& machine, const std::vector<std::string>& axes) {
  std::string text = "part,move,line,operation,tool,rapid,time_s";
  for (const std::string& column : mesh::pose_columns(machine)) text += "," + column;
  text += ",dx_um,dy_um,dz_um";
  for (const std::string& axis : axes) text += ",offset_" + axis + "_um";
  for (const std::string& axis : axes) text += ",std_" + axis + "_um";
  return text + "\n";
}

std::string block_text(const mesh::Machine& machine, const nc::PredictedMove& move, long number) {
  const nc::MoveState& state = move.timed->element.state;
  fmt::memory_buffer out;
  const auto at = std::back_inserter(out);
  fmt::format_to(at, "{},{},{},{},{},{:d},{:.6f}", state.part + 1, number, state.line, state.operation, state.tool,
                 move.timed->element.rapid, move.time);
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const bool linear = machine.axes[i].kind == mesh::AxisKind::linear;
    fmt::format_to(at, ",{:.6f}", move.end[i] / (linear ? units::mm : units::deg));
  }
  for (int i = 0; i < 3; ++i) fmt::format_to(at, ",{:.4f}", move.error_um[i]);
  for (const double value : move.offset_um) fmt::format_to(at, ",{:.4f}", value);
  for (const double value : move.std_um) fmt::format_to(at, ",{:.4f}", value);
  fmt::format_to(at, "\n");
  return fmt::to_string(out);
}

void require_spindle(const mesh::Machine& machine, const nc::MoveState& state, const std::string& file) {
  const double rpm = std::abs(state.spindle_rpm);
  if (machine.spindle_max_rpm > 0 && rpm > machine.spindle_max_rpm)
    throw core::InputError(fmt::format("{}:{}", file, state.line), fmt::format("a spindle speed of {} rpm", rpm),
                           fmt::format("at most {} rpm (spindle_max_rpm)", machine.spindle_max_rpm));
}

/// One run through the program with all that is made on the way.
class Run {
public:
  Run(const NcOptions& options, const Twin& twin, const nc::ControlProfile& control)
      : options_(options),
        twin_(twin),
        control_(control),
        motion_(twin.machine),
        start_(options.start.empty() ? mesh::home_pose(twin.machine)
                                     : mesh::parse_pose(twin.machine, options.start, "--start")),
        load_(twin.machine, options.program.stem().string(), options.start_C, start_),
        rows_(start_, options.row_s, [this](const nc::Row& row) { take_row(row); }),
        planner_(control.axes, control.blend_tolerance, control.look_ahead,
                 [this](const nc::Timed& timed) { take_timed(timed); }) {
    program_travel_ = nc::Positions::Zero(start_.size());
    if (twin.model) {
      nc::PredictionOptions prediction;
      prediction.start_C = options.start_C;
      prediction.interval = options.row_s;
      predictor_ = std::make_unique<nc::Predictor>(*twin.model, start_, prediction,
                                                   [this](const nc::PredictedMove& move) { take_predicted(move); });
    }
  }

  std::vector<std::filesystem::path> write(const std::filesystem::path& folder) {
    rows_out_.open(folder / "rows.csv", std::ios::binary);
    rows_out_ << nc::rows_header(twin_.machine) << nc::first_row_text(twin_.machine, start_);
    const bool blocks = predictor_ && !options_.no_blocks;
    if (blocks) {
      blocks_out_.open(folder / "blocks.csv", std::ios::binary);
      blocks_out_ << blocks_header(twin_.machine, predictor_->axes());
    }
    begin_rewrite(folder);
    read();
    std::vector<std::filesystem::path> files = {"rows.csv", "load.toml", "operations.csv"};
    finish_rewrite(folder, files);
    if (blocks) files.emplace_back("blocks.csv");
    close(rows_out_, "rows.csv");
    if (blocks) close(blocks_out_, "blocks.csv");
    core::write_file(folder / "load.toml", load_.finish(options_.row_s));
    core::write_file(folder / "operations.csv",
                     operations_.csv(predictor_ ? predictor_->axes() : std::vector<std::string>{}));
    if (predictor_ && options_.repeat > 1) {
      core::write_file(folder / "parts.csv", parts_.csv(predictor_->axes()));
      files.emplace_back("parts.csv");
    }
    return files;
  }

  nlohmann::json summary() const {
    nlohmann::json travel = nlohmann::json::object(), rows = nlohmann::json::object();
    for (std::size_t i = 0; i < twin_.machine.axes.size(); ++i) {
      const mesh::Axis& axis = twin_.machine.axes[i];
      const bool linear = axis.kind == mesh::AxisKind::linear;
      const double unit = linear ? units::mm : units::deg;
      const std::string name = axis.id + (linear ? "_mm" : "_deg");
      travel[name] = program_travel_[i] / unit;
      rows[name] = rows_.travel()[i] / unit;
    }
    nlohmann::json json = {{"duration_s", planner_.time()},
                           {"moves", program_.moves},
                           {"lines", program_.blocks},
                           {"feeds", program_.feeds},
                           {"traverses", program_.traverses},
                           {"arcs", program_.arcs},
                           {"tool_changes", program_.tool_changes},
                           {"operations", operations_.count()},
                           {"cutting_s", cutting_},
                           {"rapid_s", rapid_},
                           {"pause_s", paused_},
                           {"travel", travel},
                           {"travel_rows", rows},
                           {"rows", row_count_}};
    if (predictor_) {
      nlohmann::json largest = nlohmann::json::object(), std = nlohmann::json::object();
      for (std::size_t i = 0; i < predictor_->axes().size(); ++i) {
        largest[predictor_->axes()[i]] = largest_um_.size() > 0 ? largest_um_[i] : 0.0;
        std[predictor_->axes()[i]] = std_um_.size() > 0 ? std_um_[i] : 0.0;
      }
      json["largest_offset_um"] = largest;
      json["largest_std_um"] = std;
      json["moves_outside_workspace"] = outside_;
      if (options_.repeat > 1 && predicted_ > 0) {
        const int good = parts_.first_good(options_.tolerance_um);
        json["first_good_part"] = good;
        json["warm_up_s"] = good > 0 ? parts_.start_of(good) : 0.0;
      }
    }
    if (path_ || shift_) {
      const nc::RewriteSummary& rewrite = path_ ? path_->summary() : shift_->summary();
      json["rewrite"] = {{"program", rewritten_},
                         {"lines_before", rewrite.lines_before},
                         {"lines_after", rewrite.lines_after},
                         {"changed", rewrite.changed},
                         {"split", rewrite.split},
                         {"cycles_written_out", rewrite.written_out},
                         {"largest_displacement_um", rewrite.largest_um}};
      if (shift_) json["rewrite"]["largest_deviation_um"] = shift_->largest_left_um();
    }
    return json;
  }
  std::string text() const {
    std::string text = fmt::format(
        "nc: {:.1f} s: {:.1f} s cutting, {:.1f} s rapid, {:.1f} s standing; {} moves of {} lines, {} tool changes",
        planner_.time(), cutting_, rapid_, paused_, program_.moves, program_.blocks, program_.tool_changes);
    if (predictor_ && largest_um_.size() > 0) {
      text += "\nlargest offset of a cutting move:";
      for (std::size_t i = 0; i < predictor_->axes().size(); ++i)
        text += fmt::format("{} {} {:.2f} um", i > 0 ? "," : "", predictor_->axes()[i], largest_um_[i]);
    }
    if (path_ || shift_) {
      const nc::RewriteSummary& rewrite = path_ ? path_->summary() : shift_->summary();
      text += fmt::format("\n{}: {} of {} lines changed, {} lines; largest displacement {:.2f} um", rewritten_,
                          rewrite.changed, rewrite.lines_before, rewrite.lines_after, rewrite.largest_um);
    }
    if (outside_ > 0)
      text += fmt::format("\n{} of {} moves end outside of the model's workspace", outside_, predicted_);
    return text;
  }

private:
  void close(std::ofstream& out, const std::string& name) const {
    out.close();
    if (!out)
      throw core::InputError((options_.out / name).string(), "cannot be written", "a place with room and permission");
  }
  void begin_rewrite(const std::filesystem::path& folder) {
    if (options_.rewrite.empty()) return;
    rewritten_ = options_.program.stem().string() + ".corrected" + options_.program.extension().string();
    original_ = core::read_file(options_.program);
    nc::RewriteOptions rewrite;
    rewrite.tolerance = options_.tolerance_um * units::um;
    rewrite.words = control_.words;
    if (options_.rewrite == "shift") {
      shift_ = std::make_unique<nc::ShiftRewriter>(original_, options_.program.string(), motion_, rewrite);
      return;
    }
    program_out_.open(folder / rewritten_, std::ios::binary);
    path_ = std::make_unique<nc::PathRewriter>(original_, options_.program.string(), motion_, rewrite,
                                               [this](const std::string& text) { program_out_ << text; });
  }
  void finish_rewrite(const std::filesystem::path& folder, std::vector<std::filesystem::path>& files) {
    if (options_.rewrite.empty()) return;
    if (shift_) core::write_file(folder / rewritten_, shift_->finish());
    if (path_) {
      const bool differs = path_->finish();
      close(program_out_, rewritten_);
      // Without a displacement loops and subprograms stay as well.
      if (!differs) core::write_file(folder / rewritten_, original_);
    }
    files.emplace_back(rewritten_);
  }
  void read() {
    nc::InterpreterOptions interpreter;
    interpreter.program = options_.program;
    interpreter.folder = options_.folder;
    interpreter.start = motion_.letters_of(start_);
    interpreter.axis_mask = motion_.axis_mask();
    nc::ProgramSink sink;
    sink.block = [this](const nc::Block& block, const nc::Frame& frame) {
      if (file_ != block.file) file_ = block.file;
      if (path_ && rewrites_) path_->block(block.state, block.file, frame);
      if (shift_ && rewrites_) shift_->block(block.state, block.file, frame);
    };
    sink.skipped = [this] {
      if (path_ && rewrites_) path_->skipped();
    };
    sink.move = [this](const nc::Move& given, const nc::Frame& frame) {
      nc::Move move = given;
      require_spindle(twin_.machine, move.state, file_);
      // Switching tool centre point control moves no axis: the control's position is another one from here on.
      if (move.state.tcp != tcp_ && motion_.has_tcp()) {
        move.from = motion_.values(last_, move, move.from);
        if (move.kind != nc::MoveKind::arc) move.length = nc::straight_length(move.to - move.from);
        if (!(move.length > 0.0)) return;
      }
      tcp_ = move.state.tcp;
      move.state.part = part_;
      state_ = move.state;
      if (path_ && rewrites_) path_->move();
      if (shift_ && rewrites_) shift_->move(move);
      const auto source =
          rewrites_ && (path_ || shift_) ? std::make_shared<nc::Source>(nc::Source{move, frame}) : nullptr;
      motion_.elements(move, file_, source, [this](nc::Element&& element) {
        nc::Positions low = element.base, high = element.base;
        element.sweep(0.0, 1.0, program_travel_, low, high);
        last_ = element.end();
        planner_.push(std::move(element));
      });
    };
    sink.pause = [this](const nc::Pause& pause) {
      require_spindle(twin_.machine, pause.state, file_);
      state_ = pause.state;
      state_.part = part_;
      stand(pause.seconds);
    };
    last_ = start_;
    for (part_ = 0; part_ < options_.repeat; ++part_) {
      rewrites_ = part_ + 1 == options_.repeat;
      tcp_ = false;
      interpreter.start = motion_.letters_of(last_);
      program_ = nc::read_program(interpreter, control_, sink);
      if (rewrites_ || !(options_.pause_s > 0.0)) continue;
      // It belongs to the last operation, with spindle and fluid off.
      state_.spindle_rpm = 0.0;
      state_.flood = state_.mist = false;
      stand(options_.pause_s);
    }
    planner_.finish();
    rows_.finish();
  }
  void stand(double seconds) {
    nc::Element element = nc::Element::line(last_, last_);
    element.pause = seconds;
    element.state = state_;
    planner_.push(std::move(element));
  }
  void take_timed(const nc::Timed& timed) {
    operations_.add(timed);
    const double duration = timed.duration();
    (timed.element.pause > 0.0 ? paused_ : timed.element.rapid ? rapid_ : cutting_) += duration;
    if (predictor_) predictor_->add(timed);
    rows_.add(timed);
  }
  void take_row(const nc::Row& row) {
    ++row_count_;
    rows_out_ << nc::row_text(twin_.machine, row);
    load_.add(row);
    if (predictor_) predictor_->row(row);
  }
  void take_predicted(const nc::PredictedMove& move) {
    ++predicted_;
    outside_ += move.outside ? 1 : 0;
    operations_.add(move);
    parts_.add(move);
    if (!move.timed->element.rapid) {
      if (largest_um_.size() == 0) largest_um_ = std_um_ = Eigen::VectorXd::Zero(move.offset_um.size());
      for (Eigen::Index i = 0; i < move.offset_um.size(); ++i)
        if (std::abs(move.offset_um[i]) > std::abs(largest_um_[i])) largest_um_[i] = move.offset_um[i];
      std_um_ = std_um_.cwiseMax(move.std_um);
    }
    if (path_ && move.timed->element.source) path_->predicted(move);
    if (shift_ && move.timed->element.source) shift_->predicted(move);
    if (blocks_out_.is_open()) blocks_out_ << block_text(twin_.machine, move, predicted_);
  }

  const NcOptions& options_;
  const Twin& twin_;
  const nc::ControlProfile& control_;
  nc::AxisMotion motion_;
  nc::Positions start_, last_, program_travel_;
  nc::LoadText load_;
  nc::RowBuilder rows_;
  nc::Planner planner_;
  std::unique_ptr<nc::Predictor> predictor_;
  Operations operations_;
  nc::ProgramSummary program_;
  std::unique_ptr<nc::PathRewriter> path_;
  std::unique_ptr<nc::ShiftRewriter> shift_;
  std::string rewritten_, original_, file_;
  nc::MoveState state_;  ///< of the last element
  std::ofstream rows_out_, blocks_out_, program_out_;
  bool tcp_ = false, rewrites_ = true;
  int part_ = 0;
  Parts parts_;
  double cutting_ = 0, rapid_ = 0, paused_ = 0;
  long row_count_ = 0, predicted_ = 0, outside_ = 0;
  Eigen::VectorXd largest_um_, std_um_;
};

}  // namespace

void nc(const NcOptions& options) {
  nc::PredictionOptions prediction;
  prediction.start_C = options.start_C;
  prediction.interval = options.row_s;
  prediction.validate();
  core::require_within("nc: --tolerance", options.tolerance_um, core::positive);
  core::require_within("nc: --pause", options.pause_s, {0.0, 1e6});
  const Twin twin = read_twin(options.model);
  nc::ControlProfile control = nc::ControlProfile::load(options.control, twin.machine);
  if (!options.tools.empty()) control.tools = nc::read_tool_table(options.tools);
  if (!options.rewrite.empty() && !twin.model)
    throw core::UsageError("nc: --rewrite needs a reduced model (model.rom.h5); allowed: MODEL as `reduce` writes it");
  if (!std::filesystem::is_regular_file(options.program))
    throw core::InputError(options.program.string(), "cannot be read", "an NC program");
  Run run(options, twin, control);
  core::write_files_by(options.out, [&](const std::filesystem::path& staged) { return run.write(staged); });
  nlohmann::json json = run.summary();
  json["out"] = options.out.string();
  print_summary(options, run.text() + "\nrows, loads and operations in " + options.out.string(), json.dump());
}

}  // namespace thermotwin::tools
