// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Replaces the model when its file has changed, without interrupting the model in use. A second process with the new
// file first gets the rows of the last 24 h, one a minute, to reach the thermal state of the machine. It replaces the
// process in use when it has answered all of them. A file that cannot be used changes nothing. The rows are kept in a
// file and survive a restart of `serve`. If they reach back neither 24 h nor to a cold start of the model, the new
// model would start cold. The model in use then goes on until they do.

#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <sys/types.h>
#include <utility>
#include <vector>

#include "tools/serve/front/front_options.h"
#include "tools/serve/front/model_process.h"
#include "tools/serve/front/rows_file.h"

namespace thermotwin::tools {

class Takeover {
public:
  /// @param options  must outlive the takeover
  explicit Takeover(const FrontOptions& options);

  /// Sets the column names of the rows; rows with other columns are dropped.
  void set_header(const std::string& header);
  /// Keeps a row for a new model: one a minute of the last 24 h.
  /// @param is_cold  the model in use started cold with the first row
  void keep(ServedRow row, bool is_cold);
  /// Whether the rows are enough for a new model: 24 h, or all since a cold start.
  bool has_all_rows() const;
  const std::deque<ServedRow>& rows() const { return day_; }

  /// Checks the model file, starts the second process and gives it rows; to be called repeatedly.
  /// @param axes  axes of the offsets; a model with other axes is refused  @param now  boot_s()
  /// @return whether the second process has answered all rows, so that take() may be called
  bool tend(const std::string& header, const std::vector<std::string>& axes, double now);
  /// Whether a new file has been found that waits for enough rows. True once for each file.
  bool takes_word_of_waiting() { return std::exchange(says_waiting_, false); }
  /// The second process, which goes on as the one in use. Its state replaces that of the other one, which is kept as
  /// STATE.before. To be called when the other process has ended.
  std::unique_ptr<ModelProcess> take();
  /// Announcement of the second process: its first line, as JSON.
  const nlohmann::json& announcement() const { return said_; }
  /// Renames the state of the process that was taken last to STATE. That process saves to its own file until it is
  /// started again.
  void move_state() const;

  /// Descriptor to wait for; -1: none.
  int descriptor() const { return next_ ? next_->descriptor() : -1; }

private:
  /// Identity of a model file: a new file differs in time, size or inode.
  struct Stamp {
    long long time_ns = 0;
    long long bytes = -1;  ///< -1: there is no file
    ino_t number = 0;      ///< inode
    bool operator==(const Stamp&) const = default;
  };
  static Stamp stamp_of(const std::filesystem::path& file);
  /// @return the last line of the file: the hash of all lines before it; empty if there is none
  static std::string hash_of(const std::filesystem::path& file);

  void keep_first(ServedRow& row, bool is_cold);
  void write_file();
  KeptRow kept_of(const ServedRow& row) const;
  void begin_or_wait(const std::string& header);
  bool feed();
  double kept_h() const;
  void look(const std::string& header, double now);
  void begin(const std::string& header);
  void give_up(const std::string& why);

  const FrontOptions& options_;
  std::filesystem::path next_state_;   ///< of next_
  std::filesystem::path taken_state_;  ///< of the process that was taken last; empty: none was
  RowsFile file_;
  std::deque<ServedRow> day_;
  std::string header_;
  bool begins_cold_ = false;  ///< the model began with the first of these rows
  bool is_first_ = true;      ///< no row has come since the start
  bool waits_ = false, says_waiting_ = false;
  Stamp used_, seen_;
  std::string hash_;
  double looked_at_ = 0;
  std::unique_ptr<ModelProcess> next_;
  nlohmann::json said_;   ///< announcement of next_; null: none yet
  double fed_until_ = 0;  ///< time of the last row of day_ that next_ got
  double paused_at_ = 0;  ///< time of the last row after a pause, before which next_ was ended
  unsigned pauses_ = 0;   ///< number of such ends
};

/// The command of a model process with this state.
std::vector<std::string> model_command(const FrontOptions& options, const std::filesystem::path& state);

}  // namespace thermotwin::tools
