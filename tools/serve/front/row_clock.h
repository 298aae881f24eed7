// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Times of a client's rows on a scale that only rises, for a model that cannot go back. A clock that was set (an empty
// battery, summer time, an administrator) shifts the scale; time goes on from the row before.

#include <limits>
#include <string>

namespace thermotwin::tools {

class RowClock {
public:
  enum class Jump { none, back, ahead };
  struct Reading {
    double time = 0;  ///< s, on the rising scale; NaN: the row has none
    Jump jump = Jump::none;
    double stated_s = 0;  ///< as the row states it
  };

  /// Takes the header, line by line. @return whether the line belongs to it
  bool take_header(const std::string& line);
  bool has_header() const { return complete_; }
  const std::string& header() const { return header_; }
  /// Another client comes, with a header of its own. The scale goes on.
  void forget_header();

  /// The state that the model goes on from. @param state_s  its time  @param age_s  since it was written, by the
  ///   computer's clock
  void go_on_from(double state_s, double age_s);

  /// Writes the rising time into the row where it differs. @param now  boot_s()
  Reading read(std::string& line, double now);
  /// The rows keep pace with the computer: a machine waits for their answers. Recorded rows come faster.
  bool is_in_real_time() const { return in_real_time_; }

private:
  double allowed_step(double step, double passed);

  std::string header_;
  std::size_t time_at_ = 0;
  bool complete_ = false;
  double state_s_ = -std::numeric_limits<double>::infinity(), state_age_s_ = 0;
  double last_ = -std::numeric_limits<double>::infinity(), shift_ = 0;
  double last_now_ = 0, last_step_ = 1.0;
  double anchor_time_ = 0, anchor_now_ = 0;  ///< of a second or more before
  bool in_real_time_ = false;
};

}  // namespace thermotwin::tools
