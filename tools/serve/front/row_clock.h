// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Times of a client's rows on a scale that only rises, for a model that cannot go back. A clock that was set (an empty
// battery, summer time, an administrator) shifts the scale; time goes on from the row before.
//
// Rows of a machine keep to the clock of the computer from their second one on. Rows of a record, which nobody waits
// for, outrun it: without the largest of their steps, which may be that of a clock, they cover more time than has
// passed. The client of a socket is always a machine, and so are rows that have kept pace with the computer.

#include <limits>
#include <string>
#include <string_view>

namespace thermotwin::tools {

class RowClock {
public:
  enum class Jump { none, back, ahead };
  struct Reading {
    double time = 0;  ///< s, on the rising scale; NaN: the row has none
    Jump jump = Jump::none;
    double stated_s = 0;  ///< as the row states it
    double guard_s = 0;   ///< s, for the guard: of a machine it rises by no more than the computer's time
  };
  enum class Source { socket, pipe, file };

  /// @param now  boot_s(), before the first row can have come
  void begin(Source source, double now);

  /// Takes the header, line by line. @return whether the line belongs to it
  bool take_header(const std::string& line);
  bool has_header() const { return complete_; }
  const std::string& header() const { return header_; }
  /// Another client comes, with a header of its own. The scale goes on.
  void forget_header();

  /// The state that the model goes on from. @param state_s  its time  @param age_s  since it was written, by the
  ///   computer's clock
  void go_on_from(double state_s, double age_s);

  /// Whether a machine or a record sends the rows is not known yet.
  bool is_open() const { return kind_ == Kind::open; }
  /// Rows of a record, which no machine applies.
  bool is_record() const { return kind_ == Kind::record; }
  /// Before the first row of what has come is read. @param rows  lines that wait, this one first  @param ended  no
  ///   others will come
  void look_ahead(std::string_view rows, bool ended, double now);

  /// Writes the rising time into the row where it differs. @param now  boot_s()
  Reading read(std::string& line, double now);
  /// The rows keep pace with the computer: a machine waits for their answers. Recorded rows come faster.
  bool is_in_real_time() const { return in_real_time_; }

private:
  /// How far rows have come, without their largest step.
  struct Run {
    double last_s = std::numeric_limits<double>::quiet_NaN(), sum_s = 0, largest_s = 0;
    void add(double stated_s);
    double without_largest_s() const { return sum_s - largest_s; }
  };
  enum class Kind { machine, open, record };

  double allowed_step(double step, double passed) const;
  double stated_time(std::string_view line) const;
  /// s, by the computer's clock.
  double age_of_state(double now) const;
  void judge_pace(double taken, double now, bool has_jumped);
  bool outruns(const Run& run, double now) const;

  std::string header_;
  std::size_t time_at_ = 0;
  bool complete_ = false;
  double state_s_ = -std::numeric_limits<double>::infinity(), state_age_s_ = 0;  ///< age at begin()
  double last_ = -std::numeric_limits<double>::infinity(), shift_ = 0;
  double last_now_ = 0, last_step_ = 1.0;
  double anchor_time_ = 0, anchor_now_ = 0;  ///< of a second or more before
  bool in_real_time_ = false;
  Source source_ = Source::pipe;
  Kind kind_ = Kind::open;
  double begun_at_ = 0, guard_s_ = 0;
  Run run_;
};

}  // namespace thermotwin::tools
