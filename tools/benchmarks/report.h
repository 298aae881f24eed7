// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Paired measurements and the table of their results. In each pair this program and an alternative run one after the
// other; the one that begins alternates from pair to pair. A ratio is the median of the pairs' ratios, so a computer
// that is slow for a while affects both.

#include <functional>
#include <string>
#include <vector>

#include "tools/benchmarks/process.h"

namespace thermotwin::bench {

double median(std::vector<double> values);

struct Pairs {
  std::vector<Outcome> ours, other;
};
Pairs in_turn(int pairs, const Command& ours, const Command& other);

/// @return one quantity of all outcomes
/// @param name  "processor" or "wall" (s), "MiB" (peak memory), or a name that the program prints
std::vector<double> each(const std::vector<Outcome>& outcomes, const std::string& name);

class Report {
public:
  explicit Report(std::string title) : title_(std::move(title)) {}

  /// Adds a row. @param what  measured quantity  @param ours, other  seconds of each pair, same length
  /// @param alternative  the other program, in words
  void compare(const std::string& what, const std::vector<double>& ours, const std::vector<double>& other,
               const std::string& alternative, int threads, double ours_MiB = 0, double other_MiB = 0);
  /// A figure without an alternative.
  void figure(const std::string& what, const std::string& value, int threads, double peak_MiB = 0);
  void note(const std::string& line) { notes_.push_back(line); }
  std::string text() const;

private:
  std::string title_;
  std::vector<std::vector<std::string>> rows_{
      {"what", "ours", "alternative", "alternative / ours", "of", "threads", "MiB ours, other"}};
  std::vector<std::string> notes_;
};

/// "12.3 ms"
std::string duration(double seconds);

}  // namespace thermotwin::bench
