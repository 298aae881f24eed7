// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A model process of `serve`: rows in, a line of JSON for each. One that has died is started again and goes on from its
// state. It begins with a line of its own (tools/serve/model_line.h).

#include <nlohmann/json.hpp>

#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compensation/linuxcnc/exported/process_link.h"

namespace thermotwin::tools {

struct ServedRow {
  double time = 0;           ///< s, on the scale of RowClock; NaN: none
  double stated_s = 0;       ///< as its client states it
  std::string text;          ///< with its end
  std::string notes;         ///< for its status, "clock=back"
  double since = 0;          ///< boot_s() at which it came
  double guard_s = 0;        ///< its time for the guard, see RowClock
  bool answered = false;     ///< by the guard alone: the model's answer comes too late
  bool again = false;        ///< of the last day, for a model that has not seen it
  bool after_pause = false;  ///< `serve` had ended before it, for longer than a state holds
  bool lost = false;         ///< the process that had it has ended without an answer
};

class ModelProcess {
public:
  struct Answer {
    ServedRow row;
    nlohmann::json json;
  };
  struct Refusal {
    std::string fault, what;    ///< as model_line.h
    bool of_rows = false;       ///< of a header or row, after the process had announced itself
    bool after_answer = false;  ///< and rows of this header had been answered before, by this or another process
  };

  /// @param command  the program first
  explicit ModelProcess(std::vector<std::string> command);
  ~ModelProcess();
  ModelProcess(const ModelProcess&) = delete;
  ModelProcess& operator=(const ModelProcess&) = delete;

  /// For the next start.
  void set_command(std::vector<std::string> command);
  /// The lines before the rows. Another header than before starts the process again.
  void set_header(const std::string& header);
  /// @param first  before all that wait
  void add(ServedRow row, bool first = false);
  /// Starts, feeds and watches the process. @param now  boot_s()
  void tend(double now);
  /// What has come since: an answer, in the order of the rows.
  std::optional<Answer> answer(double now);
  /// The line in which the process says that it cannot go on; it has ended.
  std::optional<Refusal> take_refusal();
  /// The line in which it says that it can, once for each start.
  std::optional<nlohmann::json> take_announcement();

  /// The oldest row without an answer; null: none.
  ServedRow* oldest();
  bool has_room() const;  ///< for another row
  /// Drops rows that have been answered without the model, the oldest ones, down to what it takes at a time.
  void drop_answered();
  /// Time without an answer after which the process is ended, s.
  void set_longest_answer(double seconds) { link_.hang_s = seconds; }
  void wait_before_start(double until) { link_.next_start_at = until; }
  /// Ends the process, which saves its state.
  void end();

  bool is_up() const { return link_.process > 0 && announced_; }
  bool is_idle() const { return waiting_.empty() && sent_.empty(); }
  unsigned restarts() const { return link_.starts > 0 ? link_.starts - 1 : 0; }
  int descriptor() const { return link_.process > 0 ? link_.from : -1; }

private:
  void begin_process();
  void feed(double now);

  std::vector<std::string> command_;
  std::vector<const char*> pointers_;
  process_link link_{};
  std::string header_, part_;
  std::deque<ServedRow> waiting_, sent_, lost_;
  std::optional<Refusal> refusal_;
  std::optional<nlohmann::json> announcement_;
  unsigned seen_starts_ = 0;
  bool announced_ = false;        ///< since the last start
  bool fed_header_ = false;       ///< since the last start
  bool header_answered_ = false;  ///< a row of this header was, ever
  bool ever_answered_ = false;
};

}  // namespace thermotwin::tools
