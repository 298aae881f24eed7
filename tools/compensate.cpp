// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <optional>
#include <unistd.h>
#include <utility>

#include "compensation/control/model_order.h"
#include "compensation/control/online_file.h"
#include "compensation/control/online_twin.h"
#include "compensation/control/state_file.h"
#include "compensation/online/stream.h"
#include "core/error.h"
#include "core/file.h"
#include "core/process.h"
#include "core/progress.h"
#include "core/units.h"
#include "reduction/model/model_file.h"
#include "tools/axis_files.h"
#include "tools/chain.h"
#include "tools/descriptor_input.h"
#include "tools/options.h"
#include "tools/serve/model_line.h"
#include "tools/twin_json.h"

namespace thermotwin::tools {

namespace {

constexpr double sensors_worsen = 1.05;  ///< RMS left with sensors over that without

/// What the observer holds at the end, a line a state.
std::string learned_csv(const compensation::OnlineModel& twin) {
  std::string text = "name,value,std,std_before,unit,memory_h\n";
  for (const compensation::ErrorModel::State& state : twin.learned()) {
    std::string name = state.name;
    for (char& c : name) c = c == ',' ? ' ' : c;
    text += fmt::format("{},{:.6g},{:.6g},{:.6g},{},{:.6g}\n", name, state.value, state.std, state.prior_std,
                        state.unit, state.memory_s / 3600.0);
  }
  return text;
}

/// Rewrites the file of lines beside a control that waits for rows; else once, at the end.
class LinesFile {
public:
  LinesFile(const CompensateOptions& options, const compensation::OnlineModel& twin,
            const reduction::ReducedModel& model)
      : options_(options),
        twin_(twin),
        machine_(model.machine),
        map_(model) {}

  void after_row(const compensation::Offsets& offsets) {
    last_ = offsets;
    if (options_.out != "-" || offsets.time < next_) return;
    // The offsets go on where the lines cannot be written.
    try {
      write();
    } catch (const core::InputError& error) {
      if (!warned_) core::warn(error.what());
      warned_ = true;
      next_ = offsets.time + options_.lines_every_s;
    }
  }
  /// Nothing where no row could be read.
  void write() {
    if (last_.offset_um.size() == 0) return;
    core::write_file(
        options_.lines,
        lines_csv(twin_.axes(), compensation::axis_lines(twin_, map_, machine_, last_.offset_um), last_.time));
    next_ = last_.time + options_.lines_every_s;
  }

private:
  const CompensateOptions& options_;
  const compensation::OnlineModel& twin_;
  const mesh::Machine& machine_;
  compensation::OutputMap map_;
  compensation::Offsets last_;
  double next_ = -std::numeric_limits<double>::infinity();
  bool warned_ = false;
};

/// Goes on from the state where there is one.
void go_on(const CompensateOptions& options, compensation::OnlineTwin& twin,
           std::optional<compensation::StateFile>& state) {
  using Writes = compensation::StateFile::Writes;
  const std::filesystem::path& path = options.state;
  state.emplace(path, options.announce ? Writes::in_background : Writes::at_once);
  if (const std::optional<std::string> saved = state->read()) {
    twin.load(*saved, path.string());
    core::log_line(fmt::format("goes on from {}: state at {} s", path.string(), twin.time()));
  } else {
    core::log_line(fmt::format("{} does not exist yet: cold start", path.string()));
  }
}

/// Files that describe the state after the last row.
void write_at_end(const CompensateOptions& options, const compensation::OnlineModel& twin, const mesh::Machine& machine,
                  bool any_row) {
  if (!options.learned.empty()) core::write_file(options.learned, learned_csv(twin));
  if (!options.axis_errors.empty() && any_row)
    core::log_line(write_axis_errors(options.axis_errors, compensation::error_tables(twin, machine)));
  if (!options.explain.empty()) core::write_file(options.explain, twin.detectability().brief());
}

compensation::ControlOptions core_options(const CompensateOptions& options) {
  compensation::ControlOptions settings;
  settings.compensator.use_sensors = !options.no_sensors;
  settings.compensator.step_s = options.step_s;
  settings.compensator.start_C = options.start_C;
  settings.compensator.largest_um = options.largest_um;
  settings.compensator.rate_um_s = options.rate_um_s;
  return settings;
}

/// With the terms where the detectability of states is asked for.
compensation::OnlineData model_of(const CompensateOptions& options) {
  if (options.explain.empty()) return compensation::online_data({options.model, options.order, options.state});
  compensation::OnlineData data{compensation::model_of_order(reduction::read_model(options.model), options.order), {}};
  data.derived = compensation::derived_data(data.model, compensation::ControlOptions().tolerance);
  return data;
}

/// The rows are those of a file.
bool can_be_read_again(const CompensateOptions& options) { return std::filesystem::is_regular_file(options.in); }

/// Rows of one input to one output, with what is written beside them.
class Run {
public:
  Run(const CompensateOptions& options, const reduction::ReducedModel& model, compensation::OnlineTwin& twin,
      std::istream& in)
      : options_(options),
        machine_(model.machine),
        twin_(twin),
        in_(in) {
    if (!options.state.empty()) go_on(options, twin, state_);
    if (!options.lines.empty()) lines_.emplace(options, twin, model);
    stream_.strict = options.strict;
    stream_.probe_std_um = options.probe_std_um;
    stream_.probed_compensated = options.probed_compensated;
    if (!options.json_lines) return;
    json_.emplace(model, twin, options.model);
    stream_.line = [this](const compensation::Offsets& offsets, std::string_view status) {
      return json_->line(offsets, status, state_ && state_->is_failing());
    };
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  compensation::StreamSummary to(std::ostream& out, bool unbuffered) {
    stream_.unbuffered = unbuffered;
    const std::string in_name = options_.in == "-" ? options_.in_name : options_.in;
    try {
      return compensation::compensate_stream(twin_, machine_, in_, in_name, out, stream_,
                                             [this](const compensation::Offsets& offsets) { after_row(offsets); });
    } catch (const core::Error&) {
      save_after_error();
      throw;
    }
  }

  void finish() {
    if (lines_) lines_->write();
    if (state_ && any_row_) state_->write(twin_.saved());
    write_at_end(options_, twin_, machine_, any_row_);
  }

private:
  void after_row(const compensation::Offsets& offsets) {
    any_row_ = true;
    if (lines_) lines_->after_row(offsets);
    if (state_ && !can_be_read_again(options_)) state_->after_row(offsets.time, [this] { return twin_.saved(); });
  }

  /// An interrupt costs nothing of what the rows have said. Those of a file start again from the state before it.
  void save_after_error() {
    if (!state_ || !any_row_ || can_be_read_again(options_)) return;
    try {
      state_->write(twin_.saved());
    } catch (const core::InputError& error) {
      core::warn(error.what());
    }
  }

  const CompensateOptions& options_;
  const mesh::Machine& machine_;
  compensation::OnlineTwin& twin_;
  std::istream& in_;
  compensation::StreamOptions stream_;
  std::optional<compensation::StateFile> state_;
  std::optional<LinesFile> lines_;
  std::optional<TwinJson> json_;
  bool any_row_ = false;
};

/// What the probed errors say of the offsets, and of the temperature sensors: the same rows without them.
class Probed {
public:
  long values = 0;
  double before_um = 0, left_um = 0, std_um = 0;  ///< std_um: of a probed value
  long unmoved = 0;                               ///< values in directions that no axis moves
  double unmoved_um = 0;
  std::optional<double> left_without_sensors_um;

  std::string sentence() const { return unmoved_words() + moved_words(); }

private:
  std::string unmoved_words() const {
    if (unmoved == 0) return "";
    return fmt::format("; {} probed values in directions that no axis moves: RMS {:.2f} um, which stays", unmoved,
                       unmoved_um);
  }

  std::string moved_words() const {
    if (values == 0) return "";
    std::string text = fmt::format("; {} probed values{}: RMS {:.2f} um, {:.2f} um with the offsets", values,
                                   unmoved > 0 ? " in those that axes move" : "", before_um, left_um);
    if (!left_without_sensors_um) return text;
    text += fmt::format(", {:.2f} um without temperature sensors", *left_without_sensors_um);
    if (left_um > sensors_worsen * *left_without_sensors_um && left_um > *left_without_sensors_um + 0.5 * std_um) {
      text +=
          ". The sensors worsen the offsets: one reads another place than machine.toml states, or its offset is wrong; "
          "--no-sensors leaves them out, thermotwin diagnose judges each";
    }
    return text;
  }
};

Probed probed_of(const CompensateOptions& options, const compensation::StreamSummary& done) {
  Probed probed;
  probed.values = done.probed;
  probed.before_um = done.probed_rms_um;
  probed.left_um = done.left_rms_um;
  probed.std_um = options.probe_std_um;
  probed.unmoved = done.probed_unmoved;
  probed.unmoved_um = done.unmoved_rms_um;
  // Rows that went on from a state cannot be run again from their start.
  if (done.probed == 0 || options.no_sensors || !options.state.empty() || !can_be_read_again(options)) return probed;
  compensation::ControlOptions blind = core_options(options);
  blind.compensator.use_sensors = false;
  compensation::OnlineData data = model_of(options);
  compensation::OnlineTwin without(data.model, std::move(data.derived), blind);
  std::ifstream again(options.in, std::ios::binary);
  std::ofstream nowhere("/dev/null");
  compensation::StreamOptions quiet;
  quiet.probe_std_um = options.probe_std_um;
  quiet.log = quiet.warn = [](const std::string&) {};
  probed.left_without_sensors_um =
      compensation::compensate_stream(without, data.model.machine, again, options.in, nowhere, quiet).left_rms_um;
  return probed;
}

void summarise(const CompensateOptions& options, const compensation::StreamSummary& done, double seconds,
               Eigen::Index order, long entered, const Probed& probed) {
  std::string statuses;
  for (const auto& [status, rows] : done.not_ok)
    statuses += fmt::format("{} {} in {} rows", statuses.empty() ? "; status" : ",", status, rows);
  const double rate = done.rows / seconds, memory = peak_memory_GiB();
  const std::string span = std::isfinite(done.first_s)
                               ? fmt::format(" from {:.10g} to {:.10g} s ({:.3g} h)", done.first_s, done.last_s,
                                             (done.last_s - done.first_s) / core::units::hour)
                               : "";
  const std::string text =
      fmt::format("{}: {} rows{} in {:.2f} s ({:.0f} rows/s), {}order {}, peak memory {:.2f} GiB{}{}",
                  options.announce ? "serve: this model process" : "compensate", done.rows, span, seconds, rate,
                  done.unreadable > 0 ? fmt::format("{} of them partly unreadable, ", done.unreadable) : "", order,
                  memory, statuses, probed.sentence());
  if (options.out == "-") {
    core::log_line(text);
    return;
  }
  nlohmann::json json = {{"rows", done.rows},     {"from_s", done.first_s},
                         {"to_s", done.last_s},   {"unreadable", done.unreadable},
                         {"not_ok", done.not_ok}, {"seconds", seconds},
                         {"order", order},        {"peak_memory_GiB", memory},
                         {"probed", entered},     {"offsets", options.out.string()}};
  if (probed.unmoved > 0) {
    json["probed_unmoved"] = probed.unmoved;
    json["probed_unmoved_rms_um"] = probed.unmoved_um;
  }
  if (probed.values > 0) {
    json["probed_rms_um"] = probed.before_um;
    json["probed_left_rms_um"] = probed.left_um;
    if (probed.left_without_sensors_um) json["probed_left_without_sensors_rms_um"] = *probed.left_without_sensors_um;
  }
  print_summary(options, text + "; offsets in " + options.out.string(), json.dump());
}

/// What is written would otherwise replace what is read.
void require_other_files(const CompensateOptions& options) {
  namespace fs = std::filesystem;
  const std::pair<const char*, fs::path> written[] = {
      {"--out", options.out},         {"--state", options.state},     {"--lines", options.lines},
      {"--learned", options.learned}, {"--explain", options.explain}, {"--axis-errors", options.axis_errors}};
  for (const auto& [option, file] : written) {
    for (const auto& [read, what] : {std::pair{fs::path(options.in), "rows"}, {fs::path(options.model), "model"}}) {
      std::error_code none;
      if (!file.empty() && fs::is_regular_file(file, none) && fs::equivalent(file, read, none)) {
        throw core::InputError(fmt::format("{} {}", option, file.string()),
                               fmt::format("the file of the {} itself", what), "another file, or one that is new");
      }
    }
  }
}

void run_rows(const CompensateOptions& options) {
  require_other_files(options);
  const bool from_stdin = options.in == "-", to_stdout = options.out == "-";
  if (to_stdout && options.json)
    throw core::UsageError("--json and the offsets would both go to standard output; allowed: --json with --out FILE");
  const compensation::ControlOptions settings = core_options(options);
  compensation::OnlineData data = model_of(options);
  const reduction::ReducedModel& model = data.model;
  compensation::OnlineTwin twin(model, std::move(data.derived), settings);

  std::ios::sync_with_stdio(false);
  DescriptorInput standard_input(STDIN_FILENO);
  std::ifstream file;
  if (!from_stdin) {
    file.open(options.in, std::ios::binary);
    if (!file) throw core::InputError(options.in, "cannot be read", "a CSV file, or - for standard input");
  }
  std::istream piped(&standard_input);
  Run run(options, model, twin, from_stdin ? piped : file);
  if (options.announce) std::cout << announcement(twin) << std::endl;
  const compensation::OffsetLimits& limits = twin.limits();
  core::log_line(
      fmt::format("offset limits: {:.0f} um, {:.3g} um/s while the axes stand, {:.3g} um/s with all axes at rapid",
                  limits.largest_um, limits.rate_um_s, limits.fastest_um_s()));
  const Stopwatch time;
  compensation::StreamSummary done;
  std::error_code none;
  if (!to_stdout && std::filesystem::is_character_file(options.out, none)) {
    std::ofstream out(options.out, std::ios::binary);  // /dev/null: nothing to replace as a whole
    if (!out) throw core::InputError(options.out.string(), "cannot be written", "a file or device with permission");
    done = run.to(out, true);
  } else if (to_stdout) {
    // A control waits for each answer: rows are flushed one by one.
    done = run.to(std::cout, true);
  } else {
    core::write_file_by(options.out, [&](const std::filesystem::path& temporary) {
      std::ofstream out(temporary, std::ios::binary);
      try {
        done = run.to(out, false);
      } catch (const core::InputError&) {
        if (out) throw;
        throw core::InputError(options.out.string(), "cannot be written", "a place with room and permission");
      }
    });
  }
  run.finish();
  const double seconds = time.seconds();
  summarise(options, done, seconds, model.system.order(), twin.probed(), probed_of(options, done));
}

}  // namespace

void compensate(const CompensateOptions& options) {
  try {
    run_rows(options);
  } catch (const core::InputError& error) {
    if (!options.announce) throw;
    std::cout << refusal(error) << std::endl;  // the front says it
    core::leave(error.exit_status());
  }
}

}  // namespace thermotwin::tools
