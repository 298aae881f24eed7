// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The last offsets that were sent to a machine, in a file beside the state. The control may still apply them when
// `serve` starts again, and the new offsets then continue from them. A separate thread replaces the whole file, so a
// slow disk delays no row.

#include <Eigen/Core>

#include <filesystem>
#include <future>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace thermotwin::tools {

class LastOffsets {
public:
  /// Age up to which the offsets are used. A control may have removed older ones.
  static constexpr double valid_s = 300.0;

  /// Reads the file; a damaged file gives a warning.
  explicit LastOffsets(std::filesystem::path file);
  ~LastOffsets();
  LastOffsets(const LastOffsets&) = delete;
  LastOffsets& operator=(const LastOffsets&) = delete;

  /// @param time       s, of the first row, on the scale of RowClock
  /// @param is_record  the rows are a record: the age is then at least the difference of `time` and the stored time
  /// @return (axes) um; nothing if there was no file, if it has other axes, or if it is older than valid_s
  std::optional<Eigen::VectorXd> before(const std::vector<std::string>& axes, double time, bool is_record) const;

  /// To be called after each answer to a machine. The file is written at most once a second if an offset has changed by
  /// 0.1 um or more, else every 30 s.
  void keep(const std::vector<std::string>& axes, const Eigen::VectorXd& offset_um, double time, double now);
  /// Writes offsets that are not in the file yet, and waits for the thread.
  void finish();

private:
  struct Kept {
    std::vector<std::string> axes;
    Eigen::VectorXd offset_um;
    double time = 0;
  };
  void write();
  void take_in();

  std::filesystem::path file_;
  std::optional<Kept> found_;
  double age_s_ = 0;  ///< of found_, at the start
  Kept kept_;
  Eigen::VectorXd written_um_;
  double written_at_ = 0;
  bool is_open_ = false;  ///< kept_ is not on the disk yet
  bool warned_ = false;
  std::future<std::string> writing_;  ///< error of the running write; empty: none
};

}  // namespace thermotwin::tools
