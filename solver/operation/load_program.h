// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A load program (loads/*.toml): phases of speeds, motions, ambient and coolant. It gives, for any
// time step, the row of channels averaged over the step; a step never crosses a corner.
// Spindle, temperatures, states and process power stay as they were until a phase says otherwise;
// the motion of an axis belongs to its phase alone: before and after, it stands at the last
// position_* or where `position` puts it. While machine_on is false nothing turns, moves or flows.

#include <Eigen/Core>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "solver/operation/channels.h"
#include "solver/operation/time_options.h"

namespace thermotwin::solver {

class LoadProgram {
public:
  /// @throws InputError naming file, line, key; every axis, travel and speed is checked
  static LoadProgram read(const std::filesystem::path& path, const mesh::Machine& machine);
  /// From text. @param path  name for messages; its stem is the program's name
  static LoadProgram parse(const std::string& text, const std::filesystem::path& path, const mesh::Machine& machine);

  const std::string& name() const { return name_; }  ///< file name without extension
  const std::string& title() const { return title_; }
  double duration() const;  ///< s
  double initial_C() const { return initial_C_; }

  /// Ends of the time steps: corners of the program and at most time_step_s apart, evenly divided
  /// in each phase. @param refine  divides the longest step (0.5: half as long)
  std::vector<double> step_ends(double refine = 1.0) const;
  /// Times of output, s: 0, multiples of output_s, and the end, or those chosen; all but 0 are step ends.
  std::vector<double> output_times() const;
  /// Times in place of the multiples of output_s, rising, in [0, duration]; the run ends with the
  /// last one. None: back to the multiples.
  /// @throws InputError
  void choose_outputs(std::vector<double> times, const std::string& place);
  /// Where a step has to end: corners and output times, rising, without 0.
  std::vector<double> stops() const;
  bool is_corner(double time) const;
  /// Mean of the channels over [from, to], which lies in one phase.
  Eigen::VectorXd row(double from, double to) const;
  /// The channels at a time, by the phase that holds `inside`.
  Eigen::VectorXd row_at(double time, double inside) const;
  std::string phase_at(double time) const;  ///< name of the phase

  /// Its own [time], else what was set here (by its case, or the command line), else the defaults.
  TimeOptions time() const { return time_.value_or(TimeOptions{}); }
  bool has_time() const { return time_.has_value(); }
  void set_time(const TimeOptions& time) { time_ = time; }
  double output_interval() const { return output_; }  ///< s
  double longest_step() const { return time_step_; }  ///< s, time_step_s

private:
  friend class LoadReader;
  LoadProgram() = default;

  std::size_t phase_index(double time) const;
  /// Coolants run on, and stop after standstill, as their machine says: corners of their own.
  void schedule_coolants(const mesh::Machine& machine, const Channels& channels);
  /// Divides a phase; both parts keep its name. @param time  inside of it
  void divide_phase(std::size_t phase, double time);

  std::string name_, title_;
  double initial_C_ = 20, time_step_ = 60, output_ = 300;
  std::optional<TimeOptions> time_;
  std::vector<double> chosen_outputs_;
  std::vector<double> corners_;               ///< phases + 1, s
  std::vector<Eigen::VectorXd> start_, end_;  ///< rows at the ends of each phase
  std::vector<std::string> phase_names_;
};

}  // namespace thermotwin::solver
