// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/nc.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/range.h"
#include "core/text.h"
#include "nc/motion/axis_motion.h"
#include "nc/motion/logged_times.h"
#include "nc/prediction/prediction.h"
#include "nc/report/imprint.h"
#include "nc/report/location_errors.h"
#include "nc/report/operations.h"
#include "nc/report/parts.h"
#include "nc/report/report.h"
#include "tools/nc/blocks.h"
#include "tools/nc/corrected_program.h"
#include "tools/nc/offset_excess.h"
#include "tools/nc/outcome.h"
#include "tools/nc/page_content.h"
#include "tools/nc/run_report.h"
#include "tools/nc/summary.h"
#include "tools/nc/twin.h"
#include "tools/page.h"

namespace thermotwin::tools {

namespace {

void require_spindle(const mesh::Machine& machine, const nc::MoveState& state, const std::string& file) {
  const double rpm = std::abs(state.spindle_rpm);
  if (machine.spindle_max_rpm > 0 && rpm > machine.spindle_max_rpm)
    throw core::InputError(fmt::format("{}:{}", file, state.line), fmt::format("a spindle speed of {} rpm", rpm),
                           fmt::format("at most {} rpm (spindle_max_rpm)", machine.spindle_max_rpm));
}

nc::ProcessHeat read_process(const NcOptions& options, const mesh::Machine& machine) {
  return options.process.empty() ? nc::ProcessHeat() : nc::ProcessHeat::load(options.process, machine);
}

/// One run through the program with all that is made on the way.
class Run {
public:
  Run(const NcOptions& options, const Twin& twin, const nc::ControlProfile& control,
      std::unique_ptr<nc::PresentMachine> present)
      : process_(read_process(options, twin.machine)),
        options_(options),
        twin_(twin),
        control_(control),
        motion_(twin.machine),
        found_(options, twin),
        start_(start_of(options, twin.machine, present.get())),
        clock_(present ? present->start_s() : 0.0),
        load_(twin.machine, process_.drives(), options.program.stem().string(), options.start_C, start_),
        rows_(start_, options.row_s, process_, [this](const nc::Row& row) { take_row(row); }),
        planner_(
            {control.axes, control.blend_tolerance, control.block_cycle, control.look_ahead, control.overlaps_corners},
            [this](const nc::Timed& timed) { times_ ? times_->add(timed) : take_planned(timed); }) {
    found_.travel = nc::Positions::Zero(start_.size());
    if (!options.log.empty()) use_log();
    if (twin.model) {
      nc::PredictionOptions prediction;
      prediction.start_C = options.start_C;
      prediction.rested = options.rested;
      prediction.interval = options.row_s;
      prediction.parts = options.repeat;
      prediction.drives = process_.drives();
      prediction.largest_um = options.largest_um;
      prediction.rate_um_s = options.rate_um_s;
      predictor_ = std::make_unique<nc::Predictor>(*twin.model, std::move(present), start_, prediction,
                                                   [this](const nc::PredictedMove& move) { take_predicted(move); });
      found_.axes = predictor_->axes();
      found_.beyond = std::make_unique<nc::BeyondLimits>(predictor_->limits());
      if (!options.no_page) content_ = std::make_unique<PageContent>(motion_, *found_.beyond);
      found_.locations = std::make_unique<nc::LocationErrors>(twin.machine);
      if (options.imprint) found_.imprint = std::make_unique<nc::Imprint>(motion_, *options.imprint);
    }
  }

  std::vector<std::filesystem::path> write(const std::filesystem::path& folder) {
    rows_out_.open(folder / "rows.csv", std::ios::binary);
    rows_out_ << nc::rows_header(twin_.machine, process_.drives())
              << nc::first_row_text(twin_.machine, process_.drives(), start_, clock_);
    const bool blocks = predictor_ && !options_.no_blocks;
    if (blocks) {
      blocks_out_.open(folder / "blocks.csv", std::ios::binary);
      blocks_out_ << blocks_header(twin_.machine, predictor_->axes());
    }
    if (found_.locations) {
      locations_out_.open(folder / "locations.csv", std::ios::binary);
      locations_out_ << found_.locations->header();
    }
    if (found_.imprint) {
      imprint_out_.open(folder / "imprint.csv", std::ios::binary);
      imprint_out_ << nc::Imprint::header();
    }
    if (!options_.rewrite.empty())
      found_.corrected =
          std::make_unique<CorrectedProgram>(options_, control_, motion_, found_.beyond->limits(), folder);
    read();
    warn_of_tools();
    std::vector<std::filesystem::path> files = {"rows.csv", "load.toml", "operations.csv"};
    if (found_.corrected) {
      found_.corrected->finish(found_.program, reading_);
      files.emplace_back(found_.corrected->name());
    }
    if (blocks) files.emplace_back("blocks.csv");
    if (found_.imprint) {
      require_imprint();
      files.insert(files.end(), {"imprint.csv", "imprint.svg"});
      close(imprint_out_, "imprint.csv");
      core::write_file(folder / "imprint.svg", nc::imprint_svg(*found_.imprint));
    }
    if (found_.locations) {
      files.emplace_back("locations.csv");
      close(locations_out_, "locations.csv");
    }
    close(rows_out_, "rows.csv");
    if (blocks) close(blocks_out_, "blocks.csv");
    core::write_file(folder / "load.toml", load_.finish(options_.row_s));
    core::write_file(folder / "operations.csv",
                     found_.operations.csv(predictor_ ? predictor_->axes() : std::vector<std::string>{}));
    if (predictor_ && options_.repeat > 1) {
      core::write_file(folder / "parts.csv", found_.parts.csv(predictor_->axes()));
      files.emplace_back("parts.csv");
      if (!found_.parts.all().empty()) {
        core::write_file(folder / "parts.svg", nc::parts_svg(found_.parts, report_of(found_)));
        files.emplace_back("parts.svg");
      }
    }
    if (content_) {
      write_page(folder / "report.html",
                 [this] { return content_->page(report_of(found_), found_.operations, found_.parts); });
      if (std::filesystem::exists(folder / "report.html")) files.emplace_back("report.html");
    }
    return files;
  }

  const Outcome& found() const { return found_; }

private:
  void close(std::ofstream& out, const std::string& name) const {
    out.close();
    if (!out)
      throw core::InputError((options_.out / name).string(), "cannot be written", "a place with room and permission");
  }
  void require_imprint() const {
    if (!found_.imprint->blocks().empty()) return;
    std::vector<std::string> tools;
    for (const int tool : cutting_tools_) tools.push_back(std::to_string(tool));
    throw core::InputError("nc: --imprint", fmt::format("tool {}, which cuts nothing", found_.imprint->tool()),
                           tools.empty() ? "a program that cuts" : "one of: " + core::join(tools));
  }
  void warn_of_lines() const {
    if (found_.program.deletable > 0 && control_.block_delete)
      core::warn(
          fmt::format("{}: {} lines begin with / and are left out; block_delete = false in the control profile "
                      "runs them",
                      options_.program.string(), found_.program.deletable));
    if (found_.program.open_end)
      core::warn(fmt::format("{}: ends without M2, M30 or %; the end of the file is taken as the end of the program",
                             options_.program.string()));
    if (found_.program.probes > 0)
      core::warn(fmt::format("{}: {} probing {} to {} end, as if the workpiece were not touched before",
                             found_.program.first_probe, found_.program.probes,
                             found_.program.probes == 1 ? "move runs" : "moves run",
                             found_.program.probes == 1 ? "its" : "their"));
  }
  void warn_of_tools() const {
    if (process_.unknown_tools().empty()) return;
    std::vector<std::string> names;
    for (const int tool : process_.unknown_tools()) names.push_back(tool > 0 ? fmt::format("T{}", tool) : "none");
    core::warn(fmt::format("{}: no [[tool]] for {}; the process power of these tools is assumed to be 0",
                           options_.process.string(), core::join(names)));
  }
  nc::ProgramSink program_sink() {
    nc::ProgramSink sink;
    sink.block = [this](const nc::Block& block, const nc::Frame& frame) {
      if (file_ != block.file) file_ = block.file;
      if (files_.size() <= block.state.file) files_.resize(block.state.file + 1);
      if (files_[block.state.file].empty()) files_[block.state.file] = file_;
      if (found_.corrected && rewrites_) found_.corrected->block(block, frame);
      if (!times_) return;
      nc::MoveState state = block.state;
      state.part = part_;
      times_->block(state);
    };
    sink.skipped = [this] {
      if (times_) times_->skipped();
      if (found_.corrected && rewrites_) found_.corrected->skipped();
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
      set_run(move.state);
      state_ = move.state;
      if (found_.corrected && rewrites_) found_.corrected->move(move);
      const auto source = rewrites_ && (found_.corrected || content_ || found_.imprint)
                              ? std::make_shared<nc::Source>(nc::Source{move, frame})
                              : nullptr;
      motion_.elements(move, file_, source, [this](nc::Element&& element) {
        nc::Positions low = element.base, high = element.base;
        element.sweep(0.0, 1.0, found_.travel, low, high);
        last_ = element.end();
        planner_.push(std::move(element));
      });
    };
    sink.pause = [this](const nc::Pause& pause) {
      require_spindle(twin_.machine, pause.state, file_);
      state_ = pause.state;
      set_run(state_);
      if (found_.corrected && rewrites_) found_.corrected->pause(pause);
      stand(pause.seconds);
    };
    return sink;
  }
  void read() {
    reading_.program = options_.program;
    reading_.folder = options_.folder;
    reading_.axis_mask = motion_.axis_mask();
    const nc::ProgramSink sink = program_sink();
    last_ = start_;
    for (part_ = 0; part_ < options_.repeat; ++part_) {
      rewrites_ = part_ + 1 == options_.repeat;
      tcp_ = false;
      reading_.start = motion_.letters_of(last_);
      found_.program = nc::read_program(reading_, control_, sink);
      if (rewrites_ || !(options_.pause_s > 0.0)) continue;
      // It belongs to the last operation, with spindle and fluid off.
      state_.spindle_rpm = 0.0;
      state_.flood = state_.mist = false;
      set_run(state_);
      stand(options_.pause_s / options_.time_factor);
    }
    warn_of_lines();
    planner_.finish();
    if (times_) times_->finish();
    rows_.finish();
    found_.rows_travel = rows_.travel();
  }
  /// Which run of the program, and how much of the log, a state belongs to.
  void set_run(nc::MoveState& state) const {
    state.part = part_;
    if (times_) state.logged = times_->reached();
  }
  void use_log() {
    log_ = nc::ControlLog::read(options_.log, options_.program);
    times_ = std::make_unique<nc::LoggedTimes>(log_, start_, [this](const nc::Timed& timed) { take_timed(timed); });
    if (!log_.power.empty())
      process_.use(
          [this](double from, double to) { return log_.energy(from - times_->log_zero(), to - times_->log_zero()); });
  }
  void stand(double seconds) {
    nc::Element element = nc::Element::line(last_, last_);
    element.pause = seconds;
    element.state = state_;
    planner_.push(std::move(element));
  }
  void take_planned(const nc::Timed& planned) {
    if (options_.time_factor == 1.0)
      take_timed(planned);
    else
      take_timed(planned.slower(options_.time_factor));
  }
  void take_timed(const nc::Timed& timed) {
    found_.operations.add(timed);
    const double duration = timed.duration();
    found_.duration_s = timed.end();
    (timed.element.pause > 0.0 ? found_.pause_s : timed.element.rapid ? found_.rapid_s : found_.cutting_s) += duration;
    if (predictor_) predictor_->add(timed);
    rows_.add(timed);
  }
  void take_row(const nc::Row& row) {
    ++found_.rows;
    rows_out_ << nc::row_text(twin_.machine, row, clock_);
    load_.add(row);
    if (!predictor_) return;
    predictor_->row(row);
    locations_out_ << found_.locations->add(predictor_->field(), row.to);
  }
  static const nc::MoveState& state_of(const nc::PredictedMove& move) { return move.timed->element.state; }
  void take_predicted(const nc::PredictedMove& move) {
    ++found_.predicted;
    found_.outside += move.outside ? 1 : 0;
    found_.operations.add(move);
    found_.parts.add(move);
    const std::optional<nc::BeyondLimits::Excess> excess = found_.beyond->add(move);
    if (excess && found_.corrected && move.timed->element.source)
      refuse_excess(*excess, *found_.beyond, fmt::format("{}:{}", files_[state_of(move).file], state_of(move).line),
                    options_);
    if (content_) content_->add(move);
    if (found_.imprint) imprint_out_ << found_.imprint->add(move);
    if (!move.timed->element.rapid) {
      cutting_tools_.insert(move.timed->element.state.tool);
      found_.uncorrected.add(move);
      if (found_.largest_um.size() == 0)
        found_.largest_um = found_.std_um = Eigen::VectorXd::Zero(move.offset_um.size());
      for (Eigen::Index i = 0; i < move.offset_um.size(); ++i)
        if (std::abs(move.offset_um[i]) > std::abs(found_.largest_um[i])) found_.largest_um[i] = move.offset_um[i];
      found_.std_um = found_.std_um.cwiseMax(move.std_um);
    }
    if (found_.corrected && move.timed->element.source) found_.corrected->predicted(move);
    if (blocks_out_.is_open()) blocks_out_ << block_text(twin_.machine, move, found_.predicted);
  }

  nc::ProcessHeat process_;
  const NcOptions& options_;
  const Twin& twin_;
  const nc::ControlProfile& control_;
  nc::AxisMotion motion_;
  Outcome found_;
  nc::Positions start_, last_;
  double clock_;  ///< s, of the program's start in rows.csv
  nc::LoadText load_;
  nc::RowBuilder rows_;
  nc::Planner planner_;
  nc::ControlLog log_;
  std::unique_ptr<nc::LoggedTimes> times_;  ///< none: those of the planner
  std::unique_ptr<nc::Predictor> predictor_;
  std::unique_ptr<PageContent> content_;
  std::set<int> cutting_tools_;
  nc::InterpreterOptions reading_;
  std::string file_;                ///< of the last block
  std::vector<std::string> files_;  ///< by MoveState::file
  nc::MoveState state_;             ///< of the last element
  std::ofstream rows_out_, blocks_out_, imprint_out_, locations_out_;
  bool tcp_ = false, rewrites_ = true;
  int part_ = 0;
};

}  // namespace

void nc(const NcOptions& options) {
  nc::PredictionOptions prediction;
  prediction.start_C = options.start_C;
  prediction.interval = options.row_s;
  prediction.validate();
  core::require_within("nc: --tolerance", options.tolerance_um, core::positive);
  core::require_within("nc: --pause", options.pause_s, {0.0, 1e6});
  const Twin twin = read_twin(options.model, options.order);
  nc::ControlProfile control = nc::ControlProfile::load(options.control, twin.machine);
  if (!options.tools.empty()) control.use_table(nc::read_tool_table(options.tools));
  if (!options.rewrite.empty() && !twin.model)
    throw core::UsageError("nc: --rewrite needs a reduced model (model.rom.h5); allowed: MODEL as `reduce` writes it");
  if (options.imprint && !twin.model)
    throw core::UsageError("nc: --imprint needs a reduced model (model.rom.h5); allowed: MODEL as `reduce` writes it");
  if (!options.rewrite.empty() && control.dialect == nc::Dialect::siemens)
    throw core::UsageError("nc: --rewrite does not write programs of the control '" + control.name +
                           "'; allowed: control profiles with dialect = \"rs274\" or \"fanuc\"");
  if (!std::filesystem::is_regular_file(options.program))
    throw core::InputError(options.program.string(), "cannot be read", "an NC program");
  Run run(options, twin, control, present_machine(options, twin));
  core::write_files_by(options.out, [&](const std::filesystem::path& staged) { return run.write(staged); });
  nlohmann::json json = summary(run.found());
  json["out"] = options.out.string();
  print_summary(options, summary_text(run.found()) + "\nrows, loads and operations in " + options.out.string(),
                json.dump());
}

}  // namespace thermotwin::tools
