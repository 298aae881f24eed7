// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/row_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/missing.h"
#include "core/text.h"

namespace thermotwin::tools {
namespace {

constexpr double longest_step_s = 30 * 86400.0;  ///< the model takes no longer one
constexpr double least_step_s = 1e-3;
/// Rows that kept pace with the computer over so long come from a running machine.
constexpr double pace_s = 1.0, pace_within = 0.2, recorded_pace = 2.0;
/// A leap of a machine's rows by more than this beside the computer's clock is their clock's.
constexpr double leap_s = 60.0;
constexpr double outrun_s = 10.0;  ///< so far beyond the computer's clock, rows are those of a record
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

}  // namespace

bool RowClock::take_header(const std::string& line) {
  if (complete_) return false;
  header_ += line;
  std::string_view rest = line;
  if (header_.size() == line.size() && rest.starts_with(byte_order_mark)) rest.remove_prefix(byte_order_mark.size());
  if (rest.starts_with('#')) return true;
  complete_ = true;
  for (time_at_ = 0;; ++time_at_) {
    const std::size_t comma = rest.find(',');
    if (core::trimmed(rest.substr(0, comma)) == "time_s") return true;
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  time_at_ = std::string::npos;  // the model refuses the header
  return true;
}

void RowClock::forget_header() {
  header_.clear();
  complete_ = false;
}

void RowClock::go_on_from(double state_s, double age_s) {
  state_s_ = state_s;
  state_age_s_ = age_s;
}

void RowClock::begin(Source source, double now) {
  source_ = source;
  kind_ = source == Source::socket ? Kind::machine : source == Source::file ? Kind::record : Kind::open;
  begun_at_ = now;
}

void RowClock::Run::add(double stated_s) {
  if (!std::isfinite(stated_s)) return;
  if (std::isfinite(last_s)) {
    const double step = std::max(0.0, stated_s - last_s);
    sum_s += step;
    largest_s = std::max(largest_s, step);
  }
  last_s = stated_s;
}

bool RowClock::outruns(const Run& run, double now) const {
  return run.without_largest_s() > now - begun_at_ + outrun_s;
}

void RowClock::look_ahead(std::string_view rows, bool ended, double now) {
  if (!is_open()) return;
  Run run = run_;
  for (std::size_t at = 0; at < rows.size();) {
    const std::size_t end = std::min(rows.find('\n', at), rows.size());
    run.add(stated_time(rows.substr(at, end - at)));
    at = end + 1;
  }
  if (ended || outruns(run, now)) kind_ = Kind::record;
}

/// @param step, passed  s since the row before, by its clock and by the computer's
double RowClock::allowed_step(double step, double passed) const {
  const bool leaps = step > longest_step_s || (!is_record() && step > passed + leap_s);
  if (step > 0.0 && !leaps) return step;
  return std::max(is_record() ? last_step_ : passed, least_step_s);
}

namespace {

/// @return begin and end of a cell; both at the end of the line: it has no such cell
std::pair<std::size_t, std::size_t> cell_of(std::string_view line, std::size_t column) {
  std::size_t begin = 0;
  for (std::size_t c = 0; c < column && begin != std::string_view::npos; ++c) {
    begin = line.find(',', begin);
    if (begin != std::string_view::npos) ++begin;
  }
  if (begin == std::string_view::npos) return {line.size(), line.size()};
  return {begin, std::min(line.find_first_of(",\r\n", begin), line.size())};
}

}  // namespace

double RowClock::stated_time(std::string_view line) const {
  if (time_at_ == std::string::npos) return core::missing;
  const auto [begin, end] = cell_of(line, time_at_);
  const std::string_view cell = core::trimmed(line.substr(begin, end - begin));
  double stated = core::missing;
  const auto parsed = std::from_chars(cell.data(), cell.data() + cell.size(), stated);
  const bool is_number = parsed.ec == std::errc() && parsed.ptr == cell.data() + cell.size();
  return is_number && std::isfinite(stated) && std::abs(stated) <= 1e10 ? stated : core::missing;
}

void RowClock::judge_pace(double taken, double now, bool has_jumped) {
  if (has_jumped) {
    anchor_time_ = taken;
    anchor_now_ = now;
  } else if (now - anchor_now_ >= pace_s) {
    const double pace = (taken - anchor_time_) / (now - anchor_now_);
    in_real_time_ = std::abs(pace - 1.0) < pace_within || (in_real_time_ && pace < recorded_pace);
    if (in_real_time_ && source_ != Source::file) kind_ = Kind::machine;
    anchor_time_ = taken;
    anchor_now_ = now;
  }
}

double RowClock::age_of_state(double now) const {
  return std::clamp(state_age_s_ + now - begun_at_, least_step_s, longest_step_s - 1.0);
}

RowClock::Reading RowClock::read(std::string& line, double now) {
  const double stated = stated_time(line);
  Reading reading{core::missing, Jump::none, stated, core::missing};
  if (std::isnan(stated)) return reading;
  run_.add(stated);
  if (is_open() && outruns(run_, now)) kind_ = Kind::record;
  const double time = stated + shift_;
  double taken = time;
  const bool is_first = !std::isfinite(last_);
  if (!is_first) {
    const double step = time - last_;
    const double allowed = allowed_step(step, now - last_now_);
    if (allowed == step) {
      last_step_ = step;
    } else {
      taken = last_ + allowed;
      reading.jump = step > 0.0 ? Jump::ahead : Jump::back;
    }
    guard_s_ += is_record() ? taken - last_ : std::min(taken - last_, std::max(0.0, now - last_now_));
  } else if (time <= state_s_) {
    // Nobody knows how long the machine was off but for the age of the file.
    taken = state_s_ + age_of_state(now);
    reading.jump = Jump::back;
  }
  if (reading.jump != Jump::none) shift_ = taken - stated;
  judge_pace(taken, now, is_first || reading.jump != Jump::none);
  last_ = reading.time = taken;
  last_now_ = now;
  reading.guard_s = guard_s_;
  if (shift_ != 0.0) {
    const auto [begin, end] = cell_of(line, time_at_);
    line.replace(begin, end - begin, fmt::format("{}", taken));
  }
  return reading;
}

}  // namespace thermotwin::tools
