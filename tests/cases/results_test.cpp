// SPDX-License-Identifier: GPL-3.0-or-later
// Tables of docs/results: each has the commit of its figures, and a command that repeats them.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>

#include "tests/cases/help.h"
#include "tests/cases/program.h"
#include "tests/cases/texts.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> pages_with_figures() {
  std::vector<fs::path> pages = files_with(".md");
  std::erase_if(pages, [](const fs::path& page) {
    return page.parent_path() != "docs/results" || page.filename() == "README.md";
  });
  return pages;
}

// A figure without the commit that measured it cannot be repeated.
TEST(Results, EachSectionWithATableNamesItsCommit) {
  static const std::regex row(R"(\| (.*) \| (.*\b[0-9a-f]{7}\b.*|every run of the tests) \| .*\|)");
  int tables = 0;
  for (const fs::path& page : pages_with_figures()) {
    std::string heading;
    std::set<std::string> with_table, with_commit;
    for (const std::string& line : prose_lines(read(source_tree() / page))) {
      std::smatch cells;
      if (line.starts_with("#")) {
        heading = line.substr(line.find(' ') + 1);
      } else if (line.starts_with("|") && heading != "Commits") {
        with_table.insert(heading);
      } else if (std::regex_match(line, cells, row)) {
        with_commit.insert(cells[1]);
      }
    }
    EXPECT_EQ(with_commit, with_table) << page;
    tables += static_cast<int>(with_table.size());
  }
  EXPECT_GT(tables, 50);
}

/// What stands under a heading, up to the next one of any level.
struct Section {
  std::string heading;
  std::size_t level = 0;
  bool has_table = false;
  bool names_command = false;  ///< in a block, or by a sentence: "The commands above ...", "No command repeats ..."
  bool has_code = false;       ///< the command in a line or in a cell
};

/// Inline code that begins as a command does.
bool is_command(const std::string& code) {
  static const std::vector<std::string> known = verbs();
  const std::string first = code.substr(0, code.find(' '));
  return first == "thermotwin" || first == "ctest" || first.starts_with("tools/") || first.starts_with("build/") ||
         (first != code && std::find(known.begin(), known.end(), first) != known.end());
}

bool has_command(const std::string& line) {
  static const std::regex code("`([^`]+)`");
  for (std::sregex_iterator at(line.begin(), line.end(), code); at != std::sregex_iterator(); ++at)
    if (is_command((*at)[1])) return true;
  return false;
}

std::vector<Section> sections_of(const std::string& markdown) {
  static const std::regex word(R"([Cc]ommands?\b(?! line))");
  std::vector<Section> sections;
  bool code = false;
  std::istringstream lines(markdown);
  for (std::string line; std::getline(lines, line);) {
    const bool fence = line.starts_with("```");
    if (fence) code = !code;
    if (!code && line.starts_with("#")) {
      const std::size_t level = line.find(' ');
      sections.push_back({line.substr(level + 1), level});
    } else if (!sections.empty()) {
      Section& here = sections.back();
      here.names_command |= code ? line.starts_with("```sh") : std::regex_search(line, word);
      here.has_table |= !code && line.starts_with("|");
      here.has_code |= !code && has_command(line);
    }
  }
  return sections;
}

/// Headings of sections with a table and no word on a command, neither there nor in a section that holds them.
std::vector<std::string> without_command(const std::vector<Section>& sections) {
  std::vector<std::string> found;
  std::vector<Section> open;
  for (const Section& section : sections) {
    while (!open.empty() && open.back().level >= section.level) open.pop_back();
    open.push_back(section);
    const bool named =
        section.has_code || std::any_of(open.begin(), open.end(), [](const Section& one) { return one.names_command; });
    if (section.has_table && section.heading != "Commits" && !named) found.push_back(section.heading);
  }
  return found;
}

TEST(Results, EachSectionWithATableNamesItsCommandOrSaysThatThereIsNone) {
  for (const fs::path& page : pages_with_figures())
    EXPECT_EQ(without_command(sections_of(read(source_tree() / page))), std::vector<std::string>()) << page;
}

TEST(ResultsReader, FindsSectionsWithoutACommand) {
  const auto found = [](const std::string& page) { return without_command(sections_of(page)); };
  const std::string table = "\n| a | b |\n|---|---|\n", block = "```sh parse\ntools/kills\n```\n";
  using Headings = std::vector<std::string>;
  EXPECT_EQ(found("# P\n## A\n" + table + "## B\n" + block + table + "### C\n" + table + "## Commits\n" + table),
            Headings{"A"});
  EXPECT_EQ(found("# P\n" + block + "## A\n" + table), Headings());
  EXPECT_EQ(found("# P\n## A\nNo command repeats it.\n" + table + "## B\nBy the command line.\n" + table),
            Headings{"B"});
  EXPECT_EQ(found("# P\n## A\n`validate cases/vmc5` prints\n" + table + "## B\n`validate` prints\n" + table),
            Headings{"B"});
  EXPECT_EQ(found("# P\nFigures of `validate cases/vmc5`.\n## A\n" + table), Headings{"A"});
  EXPECT_EQ(found("# P\n```text\ntools/run\n```\n## A\n" + table), Headings{"A"});
}

}  // namespace
}  // namespace thermotwin::cases
