// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/row_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "core/missing.h"
#include "core/text.h"

namespace thermotwin::tools {
namespace {

constexpr double longest_step_s = 30 * 86400.0;  ///< the model takes no longer one
constexpr double least_step_s = 1e-3;
/// Rows that kept pace with the computer over so long come from a running machine ...
constexpr double pace_s = 1.0, pace_within = 0.2, recorded_pace = 2.0;
/// ... and a leap of more than this beside the computer's clock is their clock's.
constexpr double leap_s = 60.0;
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
  state_age_s_ = std::clamp(age_s, 0.0, longest_step_s - 1.0);
}

/// @param step, passed  s since the row before, by its clock and by the computer's
double RowClock::allowed_step(double step, double passed) {
  const bool leaps = step > longest_step_s || (in_real_time_ && step > passed + leap_s);
  if (step > 0.0 && !leaps) return step;
  return std::max(in_real_time_ ? passed : last_step_, least_step_s);
}

RowClock::Reading RowClock::read(std::string& line, double now) {
  Reading reading{core::missing, Jump::none, core::missing};
  if (time_at_ == std::string::npos) return reading;
  std::size_t begin = 0;
  for (std::size_t c = 0; c < time_at_ && begin != std::string::npos; ++c) {
    begin = line.find(',', begin);
    if (begin != std::string::npos) ++begin;
  }
  if (begin == std::string::npos) return reading;
  const std::size_t end = std::min(line.find_first_of(",\r\n", begin), line.size());
  const std::string_view cell = core::trimmed(std::string_view(line).substr(begin, end - begin));
  double stated = core::missing;
  const auto parsed = std::from_chars(cell.data(), cell.data() + cell.size(), stated);
  if (parsed.ptr != cell.data() + cell.size() || !std::isfinite(stated) || std::abs(stated) > 1e10) return reading;
  reading.stated_s = stated;
  const double time = stated + shift_;
  double taken = time;
  if (std::isfinite(last_)) {
    const double step = time - last_;
    const double allowed = allowed_step(step, now - last_now_);
    if (allowed == step) {
      last_step_ = step;
    } else {
      taken = last_ + allowed;
      reading.jump = step > 0.0 ? Jump::ahead : Jump::back;
    }
  } else if (time <= state_s_) {
    // Nobody knows how long the machine was off but for the age of the file.
    taken = state_s_ + std::max(state_age_s_, least_step_s);
    reading.jump = Jump::back;
  }
  if (reading.jump != Jump::none) shift_ = taken - stated;
  if (!std::isfinite(last_) || reading.jump != Jump::none) {
    anchor_time_ = taken;
    anchor_now_ = now;
  } else if (now - anchor_now_ >= pace_s) {
    const double pace = (taken - anchor_time_) / (now - anchor_now_);
    in_real_time_ = std::abs(pace - 1.0) < pace_within || (in_real_time_ && pace < recorded_pace);
    anchor_time_ = taken;
    anchor_now_ = now;
  }
  last_ = reading.time = taken;
  last_now_ = now;
  if (shift_ != 0.0) line.replace(begin, end - begin, fmt::format("{}", taken));
  return reading;
}

}  // namespace thermotwin::tools
