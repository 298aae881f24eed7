// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/measure/estimate_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/text.h"
#include "core/units.h"

namespace thermotwin::tools {

using metrology::CycleResult;
using metrology::Estimates;
namespace units = core::units;

namespace {

using Rows = std::vector<std::vector<std::string>>;

constexpr std::size_t most_rows = 12;    ///< of cycles on the terminal
constexpr std::size_t most_columns = 8;  ///< errors beside each other on the terminal

/// The last cycle of many errors, one a row.
Rows last_rows(const Estimates& estimates) {
  Rows rows{{"error", "unit", "last cycle", "U (k = 2)", "range"}};
  for (std::size_t e = 0; e < estimates.errors.size(); ++e) {
    const auto at = e;
    double low = 1e300, high = -1e300;
    for (const CycleResult& cycle : estimates.cycles) {
      low = std::min(low, cycle.value[at] / units::um);
      high = std::max(high, cycle.value[at] / units::um);
    }
    const CycleResult& last = estimates.cycles.back();
    rows.push_back({estimates.errors[e], estimates.units[e]});
    if (std::isnan(last.value[at])) {
      rows.back().insert(rows.back().end(), {"-", "-", "-"});
    } else {
      rows.back().insert(rows.back().end(),
                         {fmt::format("{:.2f}", last.value[at] / units::um),
                          fmt::format("{:.2f}", 2.0 * last.std[at] / units::um), fmt::format("{:.2f}", high - low)});
    }
  }
  return rows;
}

/// (errors) of all cycles.
Eigen::VectorXd largest_std(const Estimates& estimates) {
  Eigen::VectorXd largest = estimates.cycles.back().std;
  for (const CycleResult& cycle : estimates.cycles)
    for (Eigen::Index e = 0; e < largest.size(); ++e)
      if (!(largest[e] >= cycle.std[e])) largest[e] = cycle.std[e];
  return largest;
}

/// Where the cycles differ in U, the table has the largest. The first one is 0 where it is the reference.
std::string expanded_words(const Estimates& estimates) {
  constexpr double alike = 0.05;
  const Eigen::VectorXd largest = largest_std(estimates);
  for (std::size_t i = 1; i < estimates.cycles.size(); ++i) {
    for (Eigen::Index e = 0; e < largest.size(); ++e) {
      if (estimates.cycles[i].std[e] < (1.0 - alike) * largest[e])
        return "U differs between cycles: the table has the largest, the file of the errors that of each\n";
    }
  }
  return "";
}

/// Some cycles, one a row.
Rows cycle_rows(const Estimates& estimates) {
  Rows rows{{"cycle", "time s"}};
  for (std::size_t e = 0; e < estimates.errors.size(); ++e)
    rows[0].push_back(estimates.errors[e] + " " + estimates.units[e]);
  rows[0].insert(rows[0].end(), {"drift um", "residual um"});
  const std::size_t count = estimates.cycles.size(), step = (count + most_rows - 1) / most_rows;
  for (std::size_t i = 0; i < count; i = i + 1 == count ? count : std::min(i + step, count - 1)) {
    const CycleResult& cycle = estimates.cycles[i];
    std::vector<std::string> row{fmt::format("{}", i + 1), fmt::format("{:.6g}", cycle.time)};
    for (std::size_t e = 0; e < estimates.errors.size(); ++e)
      row.push_back(std::isnan(cycle.value[e]) ? "-" : fmt::format("{:.2f}", cycle.value[e] / units::um));
    row.push_back(cycle.drift_estimated ? fmt::format("{:.2f}", cycle.drift.norm() / units::um) : "-");
    row.push_back(fmt::format("{:.2f}", cycle.residual_rms / units::um));
    rows.push_back(row);
  }
  std::vector<std::string> expanded{"U (k = 2)", ""};
  for (const double std : largest_std(estimates))
    expanded.push_back(std::isnan(std) ? "-" : fmt::format("{:.2f}", 2.0 * std / units::um));
  expanded.insert(expanded.end(), {"", ""});
  rows.push_back(expanded);
  return rows;
}

}  // namespace

std::string text_of(const Estimates& estimates) {
  const bool many = estimates.errors.size() > most_columns;
  std::string text = core::format_table(many ? last_rows(estimates) : cycle_rows(estimates));
  if (!many) text += expanded_words(estimates);
  for (const std::string& words : estimates.not_observable) text += words + "\n";
  if (!estimates.not_estimated.empty()) {
    text +=
        fmt::format("assumed 0, because the points do not distinguish them: {}; `errors` in the file chooses others\n",
                    core::join(estimates.not_estimated, "; "));
  }
  return text;
}

std::string residual_words(const Estimates& estimates, double std) {
  const metrology::ResidualTest test = metrology::residual_test(estimates, std);
  if (!test.exceeds) return "";
  return fmt::format(
      "residuals of {:.3g} um are {:.3g} times the stated uncertainty ({} degrees of freedom; by chance in less than "
      "0.1 %): the points show errors that are not estimated, or std_um is too small, so U is too small\n",
      test.ratio * std / units::um, test.ratio, test.degrees);
}

std::string misfit_words(const metrology::ResidualTest& test) {
  if (!test.exceeds) return "";
  return fmt::format(
      "residuals are {:.3g} times the stated uncertainties of the probes ({} degrees of freedom; "
      "by chance in less than 0.1 %): a probe is off, quantities are missing, or std_um is too small, so U is too "
      "small\n",
      test.ratio, test.degrees);
}

}  // namespace thermotwin::tools
