// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/stream.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <ostream>
#include <string_view>

#include "compensation/online/compensator.h"
#include "compensation/online/row_reader.h"
#include "core/error.h"
#include "core/missing.h"
#include "core/progress.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::compensation {

using core::missing;
namespace {

using core::InputError;

/// The status of a row's offsets, with what of the row could not be read.
Status row_status(const RowReader& reader, Status status) {
  if (reader.unreadable().empty() || status == Status::failed || status == Status::input_missing) return status;
  if (!reader.readable() || reader.input_unreadable()) return Status::input_missing;
  return status == Status::outside_workspace ? status : Status::sensor_failed;
}

class OffsetWriter {
public:
  OffsetWriter(std::ostream& out, const std::string& in_name, const StreamOptions& options)
      : out_(out),
        in_name_(in_name),
        options_(options) {}

  void header(const std::vector<std::string>& axes) {
    if (options_.line) return;
    add(FMT_COMPILE("time_s,"));
    columns("offset_", axes);
    columns("std_", axes);
    add(FMT_COMPILE("status\n"));
    if (options_.unbuffered) write();
  }

  /// @return the row's status with the names of what failed; empty: ok. Valid until the next row
  std::string_view row(const Offsets& offsets, const RowReader& reader) {
    if (!options_.line) {
      add(FMT_COMPILE("{},"), offsets.time);
      for (const double value : offsets.offset_um) add(FMT_COMPILE("{:.3f},"), value);
      for (const double value : offsets.std_um) add(FMT_COMPILE("{:.3f},"), value);
    }
    const Status status = row_status(reader, offsets.status);
    const std::size_t begin = text_.size();
    add(FMT_COMPILE("{}"), status_text(status));
    if (status == Status::input_missing) names(offsets.failed_inputs);
    if (status == Status::input_missing || status == Status::sensor_failed) names(offsets.failed_sensors);
    names(reader.unreadable());
    status_.assign(text_.data() + begin, text_.size() - begin);
    if (options_.line) {
      text_.resize(begin);
      add(FMT_COMPILE("{}"), options_.line(offsets, status_));
    }
    text_.push_back('\n');
    return status == Status::ok ? std::string_view() : std::string_view(status_);
  }

  /// After a row and all that follows from it.
  void end_row() {
    constexpr std::size_t chunk = 1U << 16U;
    if (options_.unbuffered || text_.size() >= chunk) write();
  }

  void finish() {
    write();
    if (!options_.unbuffered) out_.flush();
    check();
  }

private:
  template <class Format, class... Values>
  void add(const Format& format, const Values&... values) {
    fmt::format_to(std::back_inserter(text_), format, values...);
  }

  void columns(const char* prefix, const std::vector<std::string>& axes) {
    for (const std::string& axis : axes) {
      std::string lower = axis;
      for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
      add(FMT_COMPILE("{}{}_um,"), prefix, lower);
    }
  }

  void names(std::string_view text) {
    if (!text.empty()) add(FMT_COMPILE(" {}"), text);
  }

  void write() {
    out_.write(text_.data(), std::ssize(text_));
    if (options_.unbuffered) out_.flush();
    text_.clear();
    check();
  }

  void check() const {
    if (!out_) throw InputError("output of " + in_name_, "cannot be written", "a writable file or pipe with room");
  }

  std::ostream& out_;
  const std::string& in_name_;
  const StreamOptions& options_;
  fmt::memory_buffer text_;
  std::string status_;  ///< of the last row
};

/// From a row to its offsets, and probed values to the model.
class Answers {
public:
  Answers(OnlineModel& model, const StreamOptions& options) : model_(model), options_(options), last_(&nothing_) {
    const auto axes = std::ssize(model.axes());
    nothing_.offset_um = nothing_.before_um = Eigen::VectorXd::Zero(axes);
    nothing_.std_um = Eigen::VectorXd::Constant(axes, model.limits().largest_um);
    for (Eigen::Index a = 0; a < axes; ++a) moved_ += model.motion_um(Eigen::VectorXd::Unit(axes, a)).cwiseAbs();
  }
  Answers(const Answers&) = delete;
  Answers& operator=(const Answers&) = delete;

  /// A row that cannot be read gets the answer of the row before.
  const Offsets& step(const RowReader& reader) {
    if (!reader.readable()) return *last_;
    try {
      last_ = &model_.step(reader.time(), reader.row(), reader.sensors());
    } catch (const InputError& error) {
      throw InputError(reader.place() + ": " + error.what());
    }
    return *last_;
  }

  const Offsets& last() const { return *last_; }

  void probe(const RowReader& reader, StreamSummary& summary) {
    if (!reader.readable() || !reader.probed().array().isFinite().any()) return;
    const mesh::Pose pose = model_.pose();
    if (options_.probed_compensated) {
      model_.probe_compensated(pose, reader.probed(), last_->before_um, options_.probe_std_um);
    } else {
      compare(reader.probed(), summary);
      model_.probe(pose, reader.probed(), options_.probe_std_um);
    }
  }

private:
  /// Adds squares; the end of the stream makes RMS of them.
  void compare(const Eigen::Vector3d& probed, StreamSummary& summary) const {
    const Eigen::Vector3d left = probed + model_.motion_um(last_->offset_um);
    for (Eigen::Index i = 0; i < 3; ++i) {
      if (!std::isfinite(probed[i])) continue;
      if (moved_[i] < 1e-6) {
        ++summary.probed_unmoved;
        summary.unmoved_rms_um += probed[i] * probed[i];
        continue;
      }
      ++summary.probed;
      summary.probed_rms_um += probed[i] * probed[i];
      summary.left_rms_um += left[i] * left[i];
    }
  }

  OnlineModel& model_;
  const StreamOptions& options_;
  Offsets nothing_;  ///< before there is a row that can be read
  const Offsets* last_;
  Eigen::Vector3d moved_ = Eigen::Vector3d::Zero();  ///< how much offsets of 1 um move the TCP along x y z, um
};

void count_status(std::string_view status, StreamSummary& summary) {
  if (status.empty()) return;
  auto known = summary.not_ok.find(status);
  if (known == summary.not_ok.end()) {
    const bool room = summary.not_ok.size() < StreamSummary::most_statuses;
    known = summary.not_ok.try_emplace(room ? std::string(status) : "others", 0).first;
  }
  ++known->second;
}

void ask_for_machine(const std::string& in_name, const mesh::Machine& machine, const StreamOptions& options) {
  options.log(fmt::format(
      "{} does not name its machine; the model's machine is '{}'. To have it checked, begin with '# machine {} {}'",
      in_name, machine.name, machine.name, machine.hash));
}

}  // namespace

StreamSummary compensate_stream(OnlineModel& model, const mesh::Machine& machine, std::istream& in,
                                const std::string& in_name, std::ostream& out, const StreamOptions& options,
                                const std::function<void(const Offsets&)>& after_row) {
  options.validate();
  RowReader reader(in, in_name, options, model.channels(), machine);
  StreamSummary summary;
  summary.first_s = summary.last_s = missing;
  summary.names_machine = reader.names_machine();
  if (!summary.names_machine) ask_for_machine(in_name, machine, options);
  OffsetWriter writer(out, in_name, options);
  writer.header(model.axes());

  model.never_told(reader.absent());
  constexpr long between_checks = 4096;
  Answers answers(model, options);
  while (reader.next()) {
    const Offsets& offsets = answers.step(reader);
    if (offsets.status == Status::input_missing) reader.tell_lacking();
    count_status(writer.row(offsets, reader), summary);
    ++summary.rows;
    summary.unreadable += !reader.unreadable().empty();
    if (reader.readable()) {
      if (!std::isfinite(summary.first_s)) summary.first_s = reader.time();
      summary.last_s = reader.time();
    }
    answers.probe(reader, summary);
    if (reader.readable() && after_row) after_row(answers.last());
    writer.end_row();
    if (summary.rows % between_checks == 0) core::check_interrupt();
  }
  writer.finish();
  for (double* sum : {&summary.probed_rms_um, &summary.left_rms_um})
    *sum = summary.probed > 0 ? std::sqrt(*sum / summary.probed) : 0.0;
  if (summary.probed_unmoved > 0) summary.unmoved_rms_um = std::sqrt(summary.unmoved_rms_um / summary.probed_unmoved);
  return summary;
}

}  // namespace thermotwin::compensation
