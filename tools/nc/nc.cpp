// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/nc.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "compensation/control/model_order.h"
#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/quoted.h"
#include "core/range.h"
#include "core/text.h"
#include "core/units.h"
#include "mesh/machine/file.h"
#include "nc/motion/axis_motion.h"
#include "nc/motion/logged_times.h"
#include "nc/prediction/prediction.h"
#include "nc/report/imprint.h"
#include "nc/report/location_errors.h"
#include "nc/report/operations.h"
#include "nc/report/parts.h"
#include "nc/report/report.h"
#include "reduction/model/model_file.h"
#include "tools/nc/blocks.h"
#include "tools/nc/corrected_program.h"
#include "tools/nc/offset_excess.h"
#include "tools/nc/page_content.h"
#include "tools/nc/uncorrected.h"
#include "tools/page.h"

namespace thermotwin::tools {

namespace units = core::units;

namespace {

/// The machine, and the model where one was given.
struct Twin {
  std::optional<reduction::ReducedModel> model;
  mesh::Machine machine;
};

Twin read_twin(const std::filesystem::path& path, int order) {
  Twin twin;
  if (std::filesystem::is_directory(path) || path.extension() == ".toml") {
    twin.machine = mesh::read_machine(std::filesystem::is_directory(path) ? path / "machine.toml" : path);
  } else {
    twin.model = compensation::model_of_order(reduction::read_model(path), order);
    twin.machine = twin.model->machine;
  }
  return twin;
}

/// The machine as the saved state has it; none where there is no state.
std::unique_ptr<nc::PresentMachine> present_machine(const NcOptions& options, const Twin& twin) {
  if (options.state.empty()) return nullptr;
  if (!twin.model)
    throw core::UsageError("nc: --state needs a reduced model (model.rom.h5); allowed: MODEL as `reduce` writes it");
  nc::PresentOptions present;
  present.state = options.state;
  present.after_s = options.after_s.value_or(options.row_s);
  present.step_s = options.row_s;
  compensation::CompensatorOptions& saved_with = present.saved_with.compensator;
  saved_with.step_s = options.step_s;
  saved_with.start_C = options.start_C;
  saved_with.largest_um = options.largest_um;
  saved_with.rate_um_s = options.rate_um_s;
  present.validate();
  return std::make_unique<nc::PresentMachine>(*twin.model, present);
}

nc::Positions start_of(const NcOptions& options, const mesh::Machine& machine, const nc::PresentMachine* present) {
  if (!options.start.empty()) return mesh::parse_pose(machine, options.start, "--start");
  return present != nullptr ? present->pose() : mesh::home_pose(machine);
}

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
        uncorrected_(twin.machine),
        start_(start_of(options, twin.machine, present.get())),
        clock_(present ? present->start_s() : 0.0),
        load_(twin.machine, process_.drives(), options.program.stem().string(), options.start_C, start_),
        rows_(start_, options.row_s, process_, [this](const nc::Row& row) { take_row(row); }),
        planner_(
            {control.axes, control.blend_tolerance, control.block_cycle, control.look_ahead, control.overlaps_corners},
            [this](const nc::Timed& timed) { times_ ? times_->add(timed) : take_planned(timed); }) {
    program_travel_ = nc::Positions::Zero(start_.size());
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
      beyond_ = std::make_unique<nc::BeyondLimits>(predictor_->limits());
      if (!options.no_page) content_ = std::make_unique<PageContent>(motion_, *beyond_);
      locations_ = std::make_unique<nc::LocationErrors>(twin.machine);
      if (options.imprint) imprint_ = std::make_unique<nc::Imprint>(motion_, *options.imprint);
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
    if (locations_) {
      locations_out_.open(folder / "locations.csv", std::ios::binary);
      locations_out_ << locations_->header();
    }
    if (imprint_) {
      imprint_out_.open(folder / "imprint.csv", std::ios::binary);
      imprint_out_ << nc::Imprint::header();
    }
    if (!options_.rewrite.empty())
      corrected_ = std::make_unique<CorrectedProgram>(options_, control_, motion_, beyond_->limits(), folder);
    read();
    warn_of_tools();
    std::vector<std::filesystem::path> files = {"rows.csv", "load.toml", "operations.csv"};
    if (corrected_) {
      corrected_->finish(program_, reading_);
      files.emplace_back(corrected_->name());
    }
    if (blocks) files.emplace_back("blocks.csv");
    if (imprint_) {
      require_imprint();
      files.insert(files.end(), {"imprint.csv", "imprint.svg"});
      close(imprint_out_, "imprint.csv");
      core::write_file(folder / "imprint.svg", nc::imprint_svg(*imprint_));
    }
    if (locations_) {
      files.emplace_back("locations.csv");
      close(locations_out_, "locations.csv");
    }
    close(rows_out_, "rows.csv");
    if (blocks) close(blocks_out_, "blocks.csv");
    core::write_file(folder / "load.toml", load_.finish(options_.row_s));
    core::write_file(folder / "operations.csv",
                     operations_.csv(predictor_ ? predictor_->axes() : std::vector<std::string>{}));
    if (predictor_ && options_.repeat > 1) {
      core::write_file(folder / "parts.csv", parts_.csv(predictor_->axes()));
      files.emplace_back("parts.csv");
      if (!parts_.all().empty()) {
        core::write_file(folder / "parts.svg", nc::parts_svg(parts_, report()));
        files.emplace_back("parts.svg");
      }
    }
    if (content_) {
      write_page(folder / "report.html", [this] { return content_->page(report(), operations_, parts_); });
      if (std::filesystem::exists(folder / "report.html")) files.emplace_back("report.html");
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
    nlohmann::json json = {{"duration_s", duration_},
                           {"moves", program_.moves},
                           {"lines", program_.blocks},
                           {"feeds", program_.feeds},
                           {"traverses", program_.traverses},
                           {"arcs", program_.arcs},
                           {"tool_changes", program_.tool_changes},
                           {"operations", operations_.count()},
                           {"files", program_.files},
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
      uncorrected_.to(json);
      json["moves_outside_workspace"] = outside_;
      to_json(*beyond_, json);
      if (options_.repeat > 1 && predicted_ > 0) {
        const int good = parts_.first_good(options_.tolerance_um);
        json["first_good_part"] = good;
        json["warm_up_s"] = good > 0 ? parts_.start_of(good) : 0.0;
        const double ahead = parts_.drift_ahead();
        json["settled"] = ahead <= options_.tolerance_um;
        json["drift_ahead_um"] = std::isfinite(ahead) ? nlohmann::json(ahead) : nlohmann::json();
      }
    }
    if (imprint_)
      for (const auto& [line, block] : imprint_->blocks()) {
        const Eigen::Vector3d mean = block.error.sum / block.error.count, range = block.error.high - block.error.low;
        json["imprint"].push_back({{"line", line},
                                   {"runs", block.runs},
                                   {"mean_um", std::vector<double>(mean.begin(), mean.end())},
                                   {"range_um", std::vector<double>(range.begin(), range.end())}});
      }
    if (corrected_) json["rewrite"] = corrected_->json();
    return json;
  }
  std::string text() const {
    std::string text = fmt::format(
        "nc: {:.1f} s: {:.1f} s cutting, {:.1f} s rapid, {:.1f} s at rest; {} moves in {} executed lines, {} tool "
        "changes",
        duration_, cutting_, rapid_, paused_, program_.moves, program_.blocks, program_.tool_changes);
    if (predictor_ && largest_um_.size() > 0) {
      text += "\nlargest offset of a cutting move:";
      for (std::size_t i = 0; i < predictor_->axes().size(); ++i)
        text += fmt::format("{} {} {:.2f} um", i > 0 ? "," : "", predictor_->axes()[i], largest_um_[i]);
      if (const std::string stays = uncorrected_.sentence(); !stays.empty()) text += "\n" + stays;
    }
    if (corrected_) text += "\n" + corrected_->text();
    if (options_.repeat > 1 && predicted_ > 0) {
      const int good = parts_.first_good(options_.tolerance_um);
      text += fmt::format("\nfirst part within {:.3g} um of the last one: number {}, after {:.0f} s",
                          options_.tolerance_um, good, parts_.start_of(good));
      if (const double ahead = parts_.drift_ahead(); ahead > options_.tolerance_um)
        text += "\n" + nc::unsettled_text(ahead, options_.tolerance_um, "um");
    }
    if (imprint_)
      text += fmt::format("\nimprint of tool {}, tool against workpiece:\n", imprint_->tool()) +
              core::format_table(nc::imprint_table(*imprint_, 40)) +
              (imprint_->blocks().size() > 40 ? "further lines are in imprint.csv" : "");
    if (outside_ > 0)
      text += fmt::format("\n{} of {} moves end outside of the model's workspace", outside_, predicted_);
    if (beyond_) text += beyond_text(*beyond_);
    return text;
  }

private:
  void close(std::ofstream& out, const std::string& name) const {
    out.close();
    if (!out)
      throw core::InputError((options_.out / name).string(), "cannot be written", "a place with room and permission");
  }
  void require_imprint() const {
    if (!imprint_->blocks().empty()) return;
    std::vector<std::string> tools;
    for (const int tool : cutting_tools_) tools.push_back(std::to_string(tool));
    throw core::InputError("nc: --imprint", fmt::format("tool {}, which cuts nothing", imprint_->tool()),
                           tools.empty() ? "a program that cuts" : "one of: " + core::join(tools));
  }
  void warn_of_lines() const {
    if (program_.deletable > 0 && control_.block_delete)
      core::warn(
          fmt::format("{}: {} lines begin with / and are left out; block_delete = false in the control profile "
                      "runs them",
                      options_.program.string(), program_.deletable));
    if (program_.open_end)
      core::warn(fmt::format("{}: ends without M2, M30 or %; the end of the file is taken as the end of the program",
                             options_.program.string()));
    if (program_.probes > 0)
      core::warn(fmt::format("{}: {} probing {} to {} end, as if the workpiece were not touched before",
                             program_.first_probe, program_.probes, program_.probes == 1 ? "move runs" : "moves run",
                             program_.probes == 1 ? "its" : "their"));
  }
  void warn_of_tools() const {
    if (process_.unknown_tools().empty()) return;
    std::vector<std::string> names;
    for (const int tool : process_.unknown_tools()) names.push_back(tool > 0 ? fmt::format("T{}", tool) : "none");
    core::warn(fmt::format("{}: no [[tool]] for {}; the process power of these tools is assumed to be 0",
                           options_.process.string(), core::join(names)));
  }
  nc::Report report() const {
    nc::Report report;
    report.program = options_.program.filename().string();
    report.machine = fmt::format("machine {}, order {}", twin_.machine.name, twin_.model->system.order());
    report.begins = options_.state.empty()
                        ? fmt::format("the machine begins at a uniform temperature of {} °C{}", options_.start_C,
                                      options_.rested ? ", rested" : "")
                        : fmt::format("begins {} s after the saved state {}", options_.after_s.value_or(options_.row_s),
                                      options_.state.filename().string());
    report.axes = predictor_->axes();
    report.duration_s = duration_;
    report.cutting_s = cutting_;
    report.rapid_s = rapid_;
    report.pause_s = paused_;
    report.moves = program_.moves;
    report.lines = program_.blocks;
    report.parts = options_.repeat;
    report.tolerance_um = options_.tolerance_um;
    if (options_.repeat > 1 && predicted_ > 0) {
      report.first_good_part = parts_.first_good(options_.tolerance_um);
      report.warm_up_s = report.first_good_part > 0 ? parts_.start_of(report.first_good_part) : 0.0;
      report.drift_ahead_um = parts_.drift_ahead();
    }
    report.rewritten = uncorrected_.sentence("µm");
    if (corrected_) {
      report.rewritten = fmt::format("{} is the corrected program.{}{}", corrected_->name(),
                                     report.rewritten.empty() ? "" : " ", report.rewritten);
    }
    report.locations = nc::location_section(*locations_);
    if (imprint_) report.imprint = nc::imprint_section(*imprint_, 300);
    report.next = next_steps();
    return report;
  }
  /// Options that the program is read with, as they were given.
  std::string reading_words() const {
    std::string words;
    if (options_.control != NcOptions().control) words += " --control " + core::shell_word(options_.control);
    for (const auto& [option, file] :
         {std::pair{"--tools", &options_.tools}, {"--folder", &options_.folder}, {"--process", &options_.process}}) {
      if (!file->empty()) words += fmt::format(" {} {}", option, core::shell_word(*file));
    }
    if (!options_.start.empty()) words += " --start " + core::shell_word(options_.start);
    if (options_.start_C != NcOptions().start_C) words += fmt::format(" --start-C {:g}", options_.start_C);
    if (options_.rested) words += " --rested";
    return words;
  }
  std::vector<core::NextStep> next_steps() const {
    const std::string model = core::shell_word(options_.model),
                      program = core::shell_word(options_.program) + reading_words(),
                      out = core::shell_word(options_.out);
    std::vector<core::NextStep> steps;
    if (options_.rewrite.empty())
      steps.push_back({"The program with corrected coordinates:",
                       fmt::format("thermotwin nc {} {} --rewrite path --out {}", model, program, out)});
    if (options_.state.empty())
      steps.push_back({"From the present temperatures, if `compensate --state machine.state` runs beside the control:",
                       fmt::format("thermotwin nc {} {} --state machine.state --out {}", model, program, out)});
    if (options_.repeat == 1)
      steps.push_back({"A series of parts, and how long to warm up before the first good one:",
                       fmt::format("thermotwin nc {} {} --repeat 20 --pause 60 --out {}", model, program, out)});
    steps.push_back({"The offsets of a control on the same rows:",
                     fmt::format("thermotwin compensate {} --in {}/rows.csv --out offsets.csv", model, out)});
    return steps;
  }
  nc::ProgramSink program_sink() {
    nc::ProgramSink sink;
    sink.block = [this](const nc::Block& block, const nc::Frame& frame) {
      if (file_ != block.file) file_ = block.file;
      if (files_.size() <= block.state.file) files_.resize(block.state.file + 1);
      if (files_[block.state.file].empty()) files_[block.state.file] = file_;
      if (corrected_ && rewrites_) corrected_->block(block, frame);
      if (!times_) return;
      nc::MoveState state = block.state;
      state.part = part_;
      times_->block(state);
    };
    sink.skipped = [this] {
      if (times_) times_->skipped();
      if (corrected_ && rewrites_) corrected_->skipped();
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
      if (corrected_ && rewrites_) corrected_->move(move);
      const auto source = rewrites_ && (corrected_ || content_ || imprint_)
                              ? std::make_shared<nc::Source>(nc::Source{move, frame})
                              : nullptr;
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
      set_run(state_);
      if (corrected_ && rewrites_) corrected_->pause(pause);
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
      program_ = nc::read_program(reading_, control_, sink);
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
    operations_.add(timed);
    const double duration = timed.duration();
    duration_ = timed.end();
    (timed.element.pause > 0.0 ? paused_ : timed.element.rapid ? rapid_ : cutting_) += duration;
    if (predictor_) predictor_->add(timed);
    rows_.add(timed);
  }
  void take_row(const nc::Row& row) {
    ++row_count_;
    rows_out_ << nc::row_text(twin_.machine, row, clock_);
    load_.add(row);
    if (!predictor_) return;
    predictor_->row(row);
    locations_out_ << locations_->add(predictor_->field(), row.to);
  }
  static const nc::MoveState& state_of(const nc::PredictedMove& move) { return move.timed->element.state; }
  void take_predicted(const nc::PredictedMove& move) {
    ++predicted_;
    outside_ += move.outside ? 1 : 0;
    operations_.add(move);
    parts_.add(move);
    const std::optional<nc::BeyondLimits::Excess> excess = beyond_->add(move);
    if (excess && corrected_ && move.timed->element.source)
      refuse_excess(*excess, *beyond_, fmt::format("{}:{}", files_[state_of(move).file], state_of(move).line),
                    options_);
    if (content_) content_->add(move);
    if (imprint_) imprint_out_ << imprint_->add(move);
    if (!move.timed->element.rapid) {
      cutting_tools_.insert(move.timed->element.state.tool);
      uncorrected_.add(move);
      if (largest_um_.size() == 0) largest_um_ = std_um_ = Eigen::VectorXd::Zero(move.offset_um.size());
      for (Eigen::Index i = 0; i < move.offset_um.size(); ++i)
        if (std::abs(move.offset_um[i]) > std::abs(largest_um_[i])) largest_um_[i] = move.offset_um[i];
      std_um_ = std_um_.cwiseMax(move.std_um);
    }
    if (corrected_ && move.timed->element.source) corrected_->predicted(move);
    if (blocks_out_.is_open()) blocks_out_ << block_text(twin_.machine, move, predicted_);
  }

  nc::ProcessHeat process_;
  const NcOptions& options_;
  const Twin& twin_;
  const nc::ControlProfile& control_;
  nc::AxisMotion motion_;
  Uncorrected uncorrected_;
  nc::Positions start_, last_, program_travel_;
  double clock_;  ///< s, of the program's start in rows.csv
  nc::LoadText load_;
  nc::RowBuilder rows_;
  nc::Planner planner_;
  nc::ControlLog log_;
  std::unique_ptr<nc::LoggedTimes> times_;  ///< none: those of the planner
  std::unique_ptr<nc::Predictor> predictor_;
  std::unique_ptr<nc::BeyondLimits> beyond_;
  std::unique_ptr<PageContent> content_;
  std::unique_ptr<nc::Imprint> imprint_;
  std::unique_ptr<nc::LocationErrors> locations_;
  std::set<int> cutting_tools_;
  nc::Operations operations_;
  nc::ProgramSummary program_;
  nc::InterpreterOptions reading_;
  std::unique_ptr<CorrectedProgram> corrected_;
  std::string file_;                ///< of the last block
  std::vector<std::string> files_;  ///< by MoveState::file
  nc::MoveState state_;             ///< of the last element
  std::ofstream rows_out_, blocks_out_, imprint_out_, locations_out_;
  bool tcp_ = false, rewrites_ = true;
  int part_ = 0;
  nc::Parts parts_;
  double duration_ = 0, cutting_ = 0, rapid_ = 0, paused_ = 0;  ///< s
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
  nlohmann::json json = run.summary();
  json["out"] = options.out.string();
  print_summary(options, run.text() + "\nrows, loads and operations in " + options.out.string(), json.dump());
}

}  // namespace thermotwin::tools
