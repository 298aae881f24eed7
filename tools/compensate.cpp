// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <optional>
#include <streambuf>
#include <unistd.h>

#include "compensation/online/compensator.h"
#include "compensation/online/stream.h"
#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/units.h"
#include "reduction/model/model_file.h"
#include "tools/axis_files.h"
#include "tools/chain.h"
#include "tools/descriptor_input.h"
#include "tools/options.h"

namespace thermotwin::tools {

namespace {

constexpr double sensors_worsen = 1.05;  ///< RMS left with sensors over that without

/// What the observer holds at the end, a line a state.
std::string learned_csv(const compensation::Compensator& compensator) {
  std::string text = "name,value,std,std_before,unit,memory_h\n";
  for (const compensation::ErrorModel::State& state : compensator.learned()) {
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
  LinesFile(const CompensateOptions& options, const compensation::Compensator& compensator,
            const reduction::ReducedModel& model)
      : options_(options),
        compensator_(compensator),
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
    core::write_file(options_.lines,
                     lines_csv(compensator_.axes(),
                               compensation::axis_lines(compensator_, map_, machine_, last_.offset_um), last_.time));
    next_ = last_.time + options_.lines_every_s;
  }

private:
  const CompensateOptions& options_;
  const compensation::Compensator& compensator_;
  const mesh::Machine& machine_;
  compensation::OutputMap map_;
  compensation::Offsets last_;
  double next_ = -std::numeric_limits<double>::infinity();
  bool warned_ = false;
};

/// Files that describe the state after the last row.
void write_at_end(const CompensateOptions& options, const compensation::Compensator& compensator,
                  const mesh::Machine& machine, bool any_row) {
  if (!options.learned.empty()) core::write_file(options.learned, learned_csv(compensator));
  if (!options.axis_errors.empty() && any_row)
    core::log_line(write_axis_errors(options.axis_errors, compensation::error_tables(compensator, machine)));
  if (!options.explain.empty()) core::write_file(options.explain, compensator.detectability().brief());
}

/// What the probed errors say of the offsets, and of the temperature sensors: the same rows without them.
struct Probed {
  long values = 0;
  double before_um = 0, left_um = 0, std_um = 0;  ///< std_um: of a probed value
  std::optional<double> left_without_sensors_um;

  std::string sentence() const {
    if (values == 0) return "";
    std::string text =
        fmt::format("; {} probed values: RMS {:.2f} um, {:.2f} um with the offsets", values, before_um, left_um);
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

/// Takes everything and keeps nothing.
class NoOutput final : public std::streambuf {
  int overflow(int c) override { return c; }
  std::streamsize xsputn(const char*, std::streamsize count) override { return count; }
};

Probed probed_of(const CompensateOptions& options, const reduction::ReducedModel& model,
                 const compensation::CompensatorOptions& settings, const compensation::StreamSummary& done) {
  Probed probed{done.probed, done.probed_rms_um, done.left_rms_um, options.probe_std_um, {}};
  if (done.probed == 0 || !settings.use_sensors || !std::filesystem::is_regular_file(options.in)) return probed;
  compensation::CompensatorOptions blind = settings;
  blind.use_sensors = false;
  compensation::Compensator without(model, blind);
  std::ifstream again(options.in, std::ios::binary);
  NoOutput sink;
  std::ostream nowhere(&sink);
  compensation::StreamOptions quiet;
  quiet.probe_std_um = options.probe_std_um;
  quiet.log = quiet.warn = [](const std::string&) {};
  probed.left_without_sensors_um =
      compensation::compensate_stream(without, model.machine, again, options.in, nowhere, quiet).left_rms_um;
  return probed;
}

}  // namespace

void compensate(const CompensateOptions& options) {
  const bool from_stdin = options.in == "-", to_stdout = options.out == "-";
  if (to_stdout && options.json)
    throw core::UsageError("--json and the offsets would both go to standard output; allowed: --json with --out FILE");
  const reduction::ReducedModel model = reduction::read_model(options.model);
  compensation::CompensatorOptions settings;
  settings.use_sensors = !options.no_sensors;
  settings.step_s = options.step_s;
  settings.start_C = options.start_C;
  settings.largest_um = options.largest_um;
  settings.rate_um_s = options.rate_um_s;
  compensation::Compensator compensator(model, settings);

  std::ios::sync_with_stdio(false);
  DescriptorInput standard_input(STDIN_FILENO);
  std::ifstream file;
  if (!from_stdin) {
    file.open(options.in, std::ios::binary);
    if (!file) throw core::InputError(options.in, "cannot be read", "a CSV file, or - for standard input");
  }
  std::istream piped(&standard_input);
  std::istream& in = from_stdin ? piped : file;
  const std::string in_name = from_stdin ? "standard input" : options.in;

  const compensation::OffsetLimits& limits = compensator.limits();
  core::log_line(
      fmt::format("offset limits: {:.0f} um, {:.3g} um/s while the axes stand, {:.3g} um/s with all axes at rapid",
                  limits.largest_um, limits.rate_um_s, limits.fastest_um_s()));
  compensation::StreamOptions stream;
  stream.strict = options.strict;
  stream.probe_std_um = options.probe_std_um;
  stream.probed_compensated = options.probed_compensated;
  std::optional<LinesFile> lines;
  if (!options.lines.empty()) lines.emplace(options, compensator, model);
  bool any_row = false;
  const auto after_row = [&](const compensation::Offsets& offsets) {
    any_row = true;
    if (lines) lines->after_row(offsets);
  };
  const Stopwatch time;
  compensation::StreamSummary done;
  if (to_stdout) {
    // A control waits for each answer: rows are flushed one by one.
    stream.unbuffered = true;
    done = compensation::compensate_stream(compensator, model.machine, in, in_name, std::cout, stream, after_row);
  } else {
    core::write_file_by(options.out, [&](const std::filesystem::path& temporary) {
      std::ofstream out(temporary, std::ios::binary);
      try {
        done = compensation::compensate_stream(compensator, model.machine, in, in_name, out, stream, after_row);
      } catch (const core::InputError&) {
        if (out) throw;
        throw core::InputError(options.out.string(), "cannot be written", "a place with room and permission");
      }
    });
  }
  if (lines) lines->write();
  write_at_end(options, compensator, model.machine, any_row);
  const double seconds = time.seconds();
  const Probed probed = probed_of(options, model, settings, done);
  std::string statuses;
  for (const auto& [status, rows] : done.not_ok)
    statuses += fmt::format("{} {} in {} rows", statuses.empty() ? "; status" : ",", status, rows);
  const double rate = static_cast<double>(done.rows) / seconds, memory = peak_memory_GiB();
  const std::string text = fmt::format(
      "compensate: {} rows{} in {:.2f} s ({:.0f} rows/s), {}order {}, peak memory {:.2f} GiB{}{}", done.rows,
      std::isfinite(done.first_s) ? fmt::format(" from {:.10g} to {:.10g} s ({:.3g} h)", done.first_s, done.last_s,
                                                (done.last_s - done.first_s) / core::units::hour)
                                  : "",
      seconds, rate, done.unreadable > 0 ? fmt::format("{} of them partly unreadable, ", done.unreadable) : "",
      model.system.order(), memory, statuses, probed.sentence());
  if (to_stdout) {
    core::log_line(text);
    return;
  }
  nlohmann::json json = {{"rows", done.rows},
                         {"from_s", done.first_s},
                         {"to_s", done.last_s},
                         {"unreadable", done.unreadable},
                         {"not_ok", done.not_ok},
                         {"seconds", seconds},
                         {"order", model.system.order()},
                         {"peak_memory_GiB", memory},
                         {"probed", compensator.probed()},
                         {"offsets", options.out.string()}};
  if (probed.values > 0) {
    json["probed_rms_um"] = probed.before_um;
    json["probed_left_rms_um"] = probed.left_um;
    if (probed.left_without_sensors_um) json["probed_left_without_sensors_rms_um"] = *probed.left_without_sensors_um;
  }
  print_summary(options, text + "; offsets in " + options.out.string(), json.dump());
}

}  // namespace thermotwin::tools
