// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The offsets that a machine was given last, in a file beside the state: the control may still apply them when `serve`
// starts again. It is written whole, in a thread of its own, so that a slow disk holds up no row.

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
  /// Later, a control may have put them away.
  static constexpr double valid_s = 300.0;

  /// Reads the file; one that is damaged is a warning.
  explicit LastOffsets(std::filesystem::path file);
  ~LastOffsets();
  LastOffsets(const LastOffsets&) = delete;
  LastOffsets& operator=(const LastOffsets&) = delete;

  /// @param time  s, of the first row, on the scale of RowClock  @param is_record  its time alone counts besides
  /// @return (axes) um; nothing where there was no file, of these axes, as young as valid_s
  std::optional<Eigen::VectorXd> before(const std::vector<std::string>& axes, double time, bool is_record) const;

  /// After each answer to a machine: written at most once a second, where an offset has changed, or each 30 s.
  void keep(const std::vector<std::string>& axes, const Eigen::VectorXd& offset_um, double time, double now);
  /// At the end.
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
  std::future<std::string> writing_;  ///< what went wrong; empty: nothing
};

}  // namespace thermotwin::tools
