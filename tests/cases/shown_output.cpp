// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cases/shown_output.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <regex>
#include <set>
#include <sstream>

namespace thermotwin::cases {
namespace {

using Words = std::vector<std::string>;

constexpr double tolerance = 0.03;  ///< another compiler or processor moves figures of a diagnosis by less

const std::regex number(R"((?:^|[^\w.])(-?\d+(\.\d+)?(e[+-]?\d+)?)(?![\w.]*\w))");

Words words_of(const std::string& text) {
  std::istringstream all(text);
  return {std::istream_iterator<std::string>(all), {}};
}

struct Parts {
  std::string frame;  ///< with # in place of numbers
  std::vector<std::string> numbers;
};

Parts parts_of(const std::string& word) {
  Parts parts;
  auto from = word.cbegin();
  for (std::sregex_iterator at(word.begin(), word.end(), number); at != std::sregex_iterator(); ++at) {
    parts.frame += std::string(from, (*at)[1].first) + "#";
    parts.numbers.push_back((*at)[1]);
    from = (*at)[1].second;
  }
  parts.frame += std::string(from, word.cend());
  return parts;
}

bool agree(const std::string& shown, const std::string& found) {
  const std::size_t point = shown.find('.');
  const double digits = point == std::string::npos ? 0.0 : static_cast<double>(shown.size() - point - 1);
  const double a = std::stod(shown), b = std::stod(found), most = std::max(std::abs(a), std::abs(b));
  return std::abs(a - b) <= std::max(tolerance * most, 1.001 * std::pow(10.0, -digits));
}

/// Whether a number before this word depends on the computer.
bool is_of_the_computer(const std::string& unit) {
  static const std::set<std::string> units = {"s", "min", "MiB", "GiB", "rows/s"};
  const std::size_t end = unit.find_last_not_of(",;.)");
  return end != std::string::npos && units.count(unit.substr(0, end + 1)) > 0;
}

bool fits(const std::string& shown, const std::string& found, bool any_number) {
  if (shown == found) return true;
  const Parts a = parts_of(shown), b = parts_of(found);
  return !a.numbers.empty() && a.frame == b.frame && a.numbers.size() == b.numbers.size() &&
         (any_number || std::equal(a.numbers.begin(), a.numbers.end(), b.numbers.begin(), agree));
}

/// The number of leading words of a part that stand at this place of the output.
std::size_t fitting(const Words& part, const Words& output, std::size_t place) {
  std::size_t n = 0;
  while (n < part.size() && place + n < output.size() &&
         fits(part[n], output[place + n], n + 1 < part.size() && is_of_the_computer(part[n + 1])))
    ++n;
  return n;
}

/// Words between two "...".
std::vector<Words> parts_between_dots(const std::vector<std::string>& lines) {
  std::vector<Words> parts(1);
  for (const std::string& line : lines)
    for (std::string& word : words_of(line)) {
      if (word == "...")
        parts.emplace_back();
      else
        parts.back().push_back(std::move(word));
    }
  std::erase_if(parts, [](const Words& part) { return part.empty(); });
  return parts;
}

}  // namespace

std::string missing_in(const std::vector<std::string>& shown, const std::string& output) {
  const Words said = words_of(output);
  std::size_t from = 0;
  for (const Words& part : parts_between_dots(shown)) {
    std::optional<std::size_t> found;
    std::size_t best = 0, nearest = said.size();
    for (std::size_t place = from; place < said.size() && !found; ++place) {
      const std::size_t n = fitting(part, said, place);
      if (n == part.size()) found = place;
      if (n > best) best = n, nearest = place;
    }
    if (!found) {
      std::string text = "after";
      for (std::size_t i = best > 5 ? best - 5 : 0; i < best; ++i) text += " " + part[i];
      return text + ": shown '" + part[best] + "', said '" +
             (nearest + best < said.size() ? said[nearest + best] : "nothing") + "'";
    }
    from = *found + part.size();
  }
  return "";
}

}  // namespace thermotwin::cases
