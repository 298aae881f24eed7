// SPDX-License-Identifier: GPL-3.0-or-later
// Rules of docs/house.md that the compiler does not keep: size of files, names of tests, casts.
#include "tests/core/house.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <sstream>

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

std::ptrdiff_t casts_in(const std::string& text) {
  static const std::vector<std::regex> spellings(casts.begin(), casts.end());
  std::ptrdiff_t count = 0;
  std::istringstream lines(bare(text));
  for (std::string line; std::getline(lines, line);) {
    if (line.find_first_of("(<{") == std::string::npos) continue;
    for (const std::regex& spelling : spellings)
      count += std::distance(std::sregex_iterator(line.begin(), line.end(), spelling), std::sregex_iterator());
  }
  return count;
}

TEST(House, ACastIsFoundInEverySpelling) {
  for (const char* one :
       {"x = static_cast<int>(y);", "x = const_cast<A*>(y);", "x = std::bit_cast<B>(y);", "x = y.cast<float>();",
        "x = double(y);", "f(std::size_t(y));", "x = Eigen::Index(y) * 2;", "x = int{y};", "x = (long)y * n;",
        "x = (const unsigned char*)y + 1;", "execv(a, (char* const*)y);", "return (int)y;", "x = (uint64_t)(y + 1);",
        "x = -(double)*y;", "f((phase)y);", "x = 1'000 * (int)y + 1'000;", "#define A(y) ((int)y)"})
    EXPECT_EQ(casts_in(one), 1) << one;
  for (const char* none :
       {"(void)x, (void)y;", "std::function<double(int)> f;", "double f(int x);", "if (x) y = 1;", "f(x)(y);",
        "x = std::size_t{0};", "int (*f)(int) = g;", "x = (a) * b;", "explicit operator bool() const;", "// (int)y",
        "x = \"(int)y\";", "/* static_cast<int>(y) */", "x = R\"a((int)y)a\";", "x = sizeof(int);",
        "const auto f = [](int x) { return x; };"})
    EXPECT_EQ(casts_in(none), 0) << none;
}

/// A cast that is there to please no warning hides the one that changes a value. C++ and C count together.
TEST(House, CastsStayRare) {
  constexpr std::ptrdiff_t most_casts = 400;
  std::ptrdiff_t count = 0;
  for (const Source& source : sources_below(layer_names())) {
    const std::string kind = source.path.extension().string();
    if (kind == ".h" || kind == ".cpp" || kind == ".c") count += casts_in(source.text);
  }
  EXPECT_LE(count, most_casts);
  EXPECT_GT(count, 10);
}

}  // namespace
}  // namespace thermotwin::core
