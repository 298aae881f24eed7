// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/benchmarks/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "core/statistics.h"
#include "core/text.h"

namespace thermotwin::bench {
namespace {

/// Long measurements show what they have found so far.
void tell(const std::vector<std::string>& row) {
  std::fprintf(stderr, "  %s: %s; %s\n", row[0].c_str(), row[1].c_str(), row[3].c_str());
}

std::string memory(double MiB) { return MiB > 0 ? fmt::format("{:.0f}", MiB) : "-"; }

}  // namespace

double median(std::vector<double> values) { return core::quantile(std::move(values), 0.5); }

Pairs in_turn(int pairs, const Command& ours, const Command& other) {
  Pairs results;
  for (int i = 0; i < pairs; ++i) {
    if (i % 2 == 0) results.ours.push_back(run(ours));
    results.other.push_back(run(other));
    if (i % 2 == 1) results.ours.push_back(run(ours));
  }
  return results;
}

std::vector<double> each(const std::vector<Outcome>& outcomes, const std::string& name) {
  std::vector<double> values;
  for (const Outcome& outcome : outcomes) {
    values.push_back(name == "processor" ? outcome.processor_seconds
                     : name == "wall"    ? outcome.seconds
                     : name == "MiB"     ? outcome.peak_MiB
                                         : outcome[name]);
  }
  return values;
}

void Report::compare(const std::string& what, const std::vector<double>& ours, const std::vector<double>& other,
                     const std::string& alternative, int threads, double ours_MiB, double other_MiB) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(ours.size(), other.size()); ++i) ratios.push_back(other[i] / ours[i]);
  const auto [least, most] = std::minmax_element(ratios.begin(), ratios.end());
  rows_.push_back({what, duration(median(ours)), duration(median(other)),
                   fmt::format("{:.3g} ({:.3g} .. {:.3g})", median(ratios), *least, *most), alternative,
                   std::to_string(threads), memory(ours_MiB) + ", " + memory(other_MiB)});
  tell(rows_.back());
}

void Report::figure(const std::string& what, const std::string& value, int threads, double peak_MiB) {
  rows_.push_back({what, value, "-", "-", "-", std::to_string(threads), memory(peak_MiB)});
  tell(rows_.back());
}

std::string Report::text() const {
  std::string text = title_ + "\n" + core::format_table(rows_);
  if (text.back() != '\n') text += '\n';
  for (const std::string& line : notes_) text += "  " + line + "\n";
  return text;
}

std::string duration(double seconds) {
  if (seconds < 1e-3) return fmt::format("{:.2f} us", 1e6 * seconds);
  if (seconds < 1.0) return fmt::format("{:.3g} ms", 1e3 * seconds);
  return fmt::format("{:.3g} s", seconds);
}

}  // namespace thermotwin::bench
