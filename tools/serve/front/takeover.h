// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A model file that has changed is taken over while the model in use goes on: a second process of the new file first
// gets the rows of the last 24 h, one a minute. Only when it has answered them does it replace the other one. A file
// that cannot be used changes nothing. The rows outlive a restart of `serve`. Where they do not reach back 24 h, nor to
// a cold start of the model, the new model would be cold: the one in use goes on until they do.

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
  /// @param options  must outlive it
  explicit Takeover(const FrontOptions& options);

  /// Columns of the rows; those of others are forgotten.
  void set_header(const std::string& header);
  /// Rows that a new model has to know, one a minute of 24 h. @param is_cold  the model begins cold with the first one
  void keep(ServedRow row, bool is_cold);
  /// Whether a new model would know as much as the one in use.
  bool has_all_rows() const;
  const std::deque<ServedRow>& rows() const { return day_; }

  /// Looks at the file and tends the second process. @param now  boot_s()
  /// @return whether it has answered all that it had to know
  bool tend(const std::string& header, const std::vector<std::string>& axes, double now);
  /// Whether a new file has been found that waits for rows; once.
  bool takes_word_of_waiting() { return std::exchange(says_waiting_, false); }
  /// The second process, which goes on as the one in use. Its state replaces that of the other one, which is kept as
  /// STATE.before. To be called when the other process has ended.
  std::unique_ptr<ModelProcess> take();
  /// What the second process has said of itself.
  const nlohmann::json& announcement() const { return said_; }
  /// A process that was taken saves its state beside STATE until it is started again; this puts it in place.
  void move_state() const;

  /// Descriptor to wait for; -1: none.
  int descriptor() const { return next_ ? next_->descriptor() : -1; }

private:
  /// What tells a file from the one before: a whole new one differs in its time, size or number.
  struct Stamp {
    long long time_ns = 0;
    long long bytes = -1;
    ino_t number = 0;
    bool operator==(const Stamp&) const = default;
  };
  static Stamp stamp_of(const std::filesystem::path& file);
  /// Last line of the file, with the hash of all before it.
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
  std::filesystem::path next_state_;
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
  nlohmann::json said_;   ///< null: nothing yet
  double fed_until_ = 0;  ///< time of the last row of day_ that it got
  double paused_at_ = 0;  ///< time of the last row before which it was ended
  unsigned pauses_ = 0;   ///< so many times
};

/// The command of a model process with this state.
std::vector<std::string> model_command(const FrontOptions& options, const std::filesystem::path& state);

}  // namespace thermotwin::tools
