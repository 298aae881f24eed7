// SPDX-License-Identifier: GPL-3.0-or-later
// What the program knows of a kind of cause stands in the table of diagnosis/causes/kinds.cpp: nothing else compares
// the name of one.
#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <string>
#include <vector>

#include "core/file.h"
#include "tests/core/house.h"

namespace thermotwin::core {
namespace {

/// As diagnosis/README.md lists them, and those that take part beside causes.
std::set<std::string> kind_names() {
  std::set<std::string> names{"none", "unknown", "unmeasured_temperature", "time_constant"};
  const std::string text = read_file(std::filesystem::path(THERMOTWIN_SOURCE_DIR) / "diagnosis/README.md");
  static const std::regex row("\\| `([a-z_]+)` \\|[^\\n]*\\| (?:ratio|absolute) \\|");
  for (std::sregex_iterator at(text.begin(), text.end(), row), end; at != end; ++at) names.insert((*at)[1]);
  return names;
}

/// Comparisons of something that is called a kind with one of the names.
std::vector<std::string> comparisons(const std::string& text, const std::set<std::string>& names) {
  static const std::regex compared(
      "kind(?:\\(\\))?\\s*[=!]=\\s*\"([a-z_]+)\"|\"([a-z_]+)\"\\s*[=!]=\\s*[\\w.]*kind|kind\\.(?:starts|ends)_with\\(");
  std::vector<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), compared), end; at != end; ++at) {
    const std::string name = (*at)[1].matched ? (*at)[1] : (*at)[2];
    if (name.empty() || names.count(name) > 0) found.push_back(at->str());
  }
  return found;
}

TEST(KindNames, ComparisonsAreFound) {
  const std::set<std::string> names{"sensor_lag"};
  EXPECT_EQ(comparisons("if (p.kind == \"sensor_lag\")", names).size(), 1U);
  EXPECT_EQ(comparisons("if (\"sensor_lag\" != p.kind)", names).size(), 1U);
  EXPECT_EQ(comparisons("return kind.starts_with(\"sensor_\");", names).size(), 1U);
  EXPECT_TRUE(comparisons("if (p.kind == Kind::sensor_lag) kind == \"box\";", names).empty());
}

TEST(KindNames, AreComparedNowhere) {
  const std::set<std::string> names = kind_names();
  EXPECT_GE(names.size(), 32U) << "the table of diagnosis/README.md";
  for (const Source& source : sources_below({"diagnosis", "tools", "tests/diagnosis", "tests/hidden_effects"})) {
    for (const std::string& comparison : comparisons(source.text, names))
      ADD_FAILURE() << source.path << ": " << comparison << "; use Kind of diagnosis/causes/kinds.h";
  }
}

}  // namespace
}  // namespace thermotwin::core
