// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// `serve` on the toy machine, for the tests of its answers and of its page.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/cases/toy.h"

namespace thermotwin::cases {

/// Largest rate of the toy's offsets while the axes stand.
inline constexpr double toy_rate_um_s = 2.65;

/// Between rows of a warm-up: each writes a state, which takes as long as the disk takes.
inline constexpr double warm_step_s = 240;

/// A line of answers.
struct Served {
  double time = 0, offset[3] = {};
  std::string status;
};
Served served_of(const std::string& line);
/// Lines after the header.
std::vector<Served> all_served(const std::string& out);
std::string last_line_of(const std::string& text);

/// How much longer than on a quiet computer things may take, >= 1.
double slowness();

class Serve : public ::testing::Test {
protected:
  Serve();

  inline static const std::string header = "time_s,spindle.speed_rpm,axis.X.position_mm,air.T_C,T1_C,T2_C,T3_C,T4_C\n";
  static std::string row(double time, double speed = 6000);
  /// The header and rows from 0 to the time, that included. @param time  s, a multiple of warm_step_s
  static std::string rows_to(double time);

  std::string file(const std::string& name) const { return toy_.file(name); }
  std::string model() const { return file("model.rom.h5"); }
  std::string state() const { return file("serve.state"); }
  /// serve MODEL --quiet ...
  std::vector<std::string> arguments(const std::vector<std::string>& more = {}) const;
  /// Ends the processes of this test by SIGKILL. @param part  "model" or "page"  @return their number
  int kill_all(const std::string& part) const;
  int signal_all(const std::string& part, int signal) const;

  Toy toy_;
};

}  // namespace thermotwin::cases
