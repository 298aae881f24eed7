// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/rows_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <system_error>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"

namespace thermotwin::tools {
namespace {

constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 28U;  ///< bytes; a day has some hundred kilobytes
constexpr char header_kind = 'h';

}  // namespace

void RowsFile::warn(const std::string& reason) {
  if (!has_failed_) core::warn(fmt::format("serve: the rows of the last 24 h are not kept: {}", reason));
  has_failed_ = true;
}

/// HASH [number, kind, time, text]
std::string RowsFile::line_of(char kind, double time, const std::string& text) {
  const nlohmann::json json = {lines_++, std::string(1, kind), time, text};
  const std::string line = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return core::content_hash(line) + " " + line + "\n";
}

RowsFile::Content RowsFile::read() {
  constexpr std::size_t digits = 16;
  Content content;
  std::error_code none;
  if (std::filesystem::file_size(file_, none) > largest_file || none) return content;
  std::ifstream in(file_, std::ios::binary);
  std::size_t damaged = 0, expected = 0;
  for (std::string line; std::getline(in, line);) {
    const std::string rest = line.substr(std::min(line.size(), digits + 1));
    const bool is_whole = line.size() > digits && core::content_hash(rest) == line.substr(0, digits);
    const nlohmann::json json = is_whole ? nlohmann::json::parse(rest, nullptr, false) : nlohmann::json();
    if (!json.is_array() || json.size() != 4) {
      ++damaged;
      continue;
    }
    const std::size_t number = json[0];
    if (number != expected) {
      damaged += content.rows.empty() ? 0 : 1;
      content.rows.clear();
    }
    expected = number + 1;
    const char kind = json[1].get<std::string>().at(0);
    if (kind == header_kind) {
      content = {json[3], {}};
      continue;
    }
    content.rows.push_back({kind, json[2], json[3]});
  }
  if (content.header.empty()) content.rows.clear();
  if (damaged > 0)
    core::warn(fmt::format("serve: {} is damaged; {} rows of it are used", file_.string(), content.rows.size()));
  return content;
}

void RowsFile::write(const Content& content) {
  lines_ = 0;
  std::string text = line_of(header_kind, 0.0, content.header);
  for (const KeptRow& row : content.rows) text += line_of(row.kind, row.time, row.text);
  try {
    core::write_file(file_, text);
  } catch (const core::InputError& error) {
    warn(error.what());
  }
}

void RowsFile::append(const KeptRow& row) {
  std::ofstream out(file_, std::ios::app | std::ios::binary);
  out << line_of(row.kind, row.time, row.text) << std::flush;
  if (!out) warn(file_.string() + ": " + std::strerror(errno));
}

}  // namespace thermotwin::tools
