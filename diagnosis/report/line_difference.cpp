// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/line_difference.h"

#include <cstddef>
#include <sstream>
#include <vector>

#include "core/text.h"

namespace thermotwin::diagnosis {

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace

std::string difference(const std::string& before, const std::string& after) {
  const auto a = lines_of(before), b = lines_of(after);
  std::string out;
  constexpr std::size_t ahead = 4;
  std::size_t i = 0, j = 0;
  std::string table;
  while (i < a.size() || j < b.size()) {
    if (i < a.size() && j < b.size() && a[i] == b[j]) {
      if (a[i].starts_with("[")) table.clear();
      if (table.size() < 400) table += "  " + core::xml_text(a[i]) + "\n";
      ++i, ++j;
      continue;
    }
    out += table.empty() ? "" : table;
    table.clear();
    std::size_t next_a = i, next_b = j;
    bool found = false;
    for (std::size_t step = 1; step <= 2 * ahead && !found; ++step) {
      for (std::size_t in_a = 0; in_a <= step && !found; ++in_a) {
        const std::size_t in_b = step - in_a;
        if (i + in_a < a.size() && j + in_b < b.size() && a[i + in_a] == b[j + in_b] && !a[i + in_a].empty())
          next_a = i + in_a, next_b = j + in_b, found = true;
      }
    }
    if (!found) next_a = a.size(), next_b = b.size();
    for (; i < next_a; ++i) out += "<span class=\"orange\">- " + core::xml_text(a[i]) + "</span>\n";
    for (; j < next_b; ++j) out += "<span class=\"green\">+ " + core::xml_text(b[j]) + "</span>\n";
  }
  return out;
}

}  // namespace thermotwin::diagnosis
