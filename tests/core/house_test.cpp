// SPDX-License-Identifier: GPL-3.0-or-later
// Rules of docs/house.md that the compiler does not keep: size of files, names of tests, casts.
#include "tests/core/house.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

namespace thermotwin::core {
namespace {

std::vector<Source> all_sources() {
  std::vector<std::string> folders = layer_names();
  folders.emplace_back("tests");
  return sources_below(folders);
}

TEST(House, NoFileIsLongerThanAReaderCanHold) {
  constexpr long most_lines = 700;
  for (const Source& source : all_sources()) {
    EXPECT_LE(std::count(source.text.begin(), source.text.end(), '\n'), most_lines) << source.path;
  }
}

TEST(House, TestsAreNamedInOneWay) {
  static const std::regex declared("(^|\n)TEST(_F|_P)?\\((\\w+),\\s*(\\w+)\\)");
  static const std::regex good("[A-Z][A-Za-z0-9]*");
  int tests = 0;
  for (const Source& source : all_sources()) {
    const auto end = std::sregex_iterator();
    for (auto found = std::sregex_iterator(source.text.begin(), source.text.end(), declared); found != end; ++found) {
      ++tests;
      for (const int part : {3, 4}) {
        EXPECT_TRUE(std::regex_match((*found)[part].str(), good)) << source.path << ": " << (*found)[part].str();
      }
    }
  }
  EXPECT_GT(tests, 500);
}

/// A cast that is there to please no warning hides the one that changes a value.
TEST(House, CastsStayRare) {
  constexpr std::ptrdiff_t most_casts = 400;
  static const std::regex cast("(static|reinterpret|const|dynamic)_cast<");
  std::ptrdiff_t casts = 0;
  for (const Source& source : sources_below(layer_names())) {
    casts += std::distance(std::sregex_iterator(source.text.begin(), source.text.end(), cast), std::sregex_iterator());
  }
  EXPECT_LE(casts, most_casts);
  EXPECT_GT(casts, 10);
}

}  // namespace
}  // namespace thermotwin::core
