// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/day_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstring>
#include <fstream>
#include <limits>
#include <system_error>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/units.h"

namespace thermotwin::tools {
namespace {

constexpr double kept_s = 24.0 * core::units::hour;
constexpr std::size_t most_lines = 3000;                           ///< two days, a moment a minute
constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 28U;  ///< bytes; a day has some megabytes

}  // namespace

void DayFile::warn(const std::string& reason) {
  if (!has_failed_) core::warn(fmt::format("serve: the page's last 24 h are not kept: {}", reason));
  has_failed_ = true;
}

std::vector<std::string> DayFile::before(double time) {
  std::vector<std::string> lines;
  std::error_code none;
  if (file_.empty() || std::filesystem::file_size(file_, none) > largest_file || none) return lines;
  double last = -std::numeric_limits<double>::infinity();
  std::ifstream in(file_);
  for (std::string line; std::getline(in, line);) {
    const nlohmann::json moment = nlohmann::json::parse(line, nullptr, false);
    if (!moment.is_object() || !moment.contains("run_s") || !moment["run_s"].is_number()) continue;
    const double at = moment["run_s"];
    if (at <= last || at >= time || at < time - kept_s) continue;
    last = at;
    lines.push_back(std::move(line));
  }
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  lines_ = lines.size();
  try {
    core::write_file(file_, text);
  } catch (const core::InputError& error) {
    warn(error.what());
  }
  return lines;
}

void DayFile::append(double time, const std::string& line) {
  if (file_.empty()) return;
  if (++lines_ > most_lines) before(time);
  std::ofstream out(file_, std::ios::app);
  out << line << '\n' << std::flush;
  if (!out) warn(file_.string() + ": " + std::strerror(errno));
}

}  // namespace thermotwin::tools
