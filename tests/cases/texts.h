// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads the texts of the project for the tests of its words: string literals of C++ sources, paragraphs and code blocks
// of Markdown pages. Every text knows its file and, for each of its places, the line.

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace thermotwin::cases {

/// A text with one blank between words.
class Passage {
public:
  explicit Passage(std::string of_file = {}) : file(std::move(of_file)) {}

  void append(std::string_view piece, long line);
  /// Removes a blank at the end.
  void finish();
  long line_at(std::size_t place) const { return lines_.empty() ? 0 : lines_[std::min(place, lines_.size() - 1)]; }

  std::string file, text;
  bool is_table_row = false;

private:
  std::vector<long> lines_;  ///< of each character
};

/// A fenced block of a Markdown page.
struct CodeBlock {
  std::string info;                ///< after the fence: "sh", "sh long", "text", ""
  long line = 0;                   ///< of its first line
  std::vector<std::string> lines;  ///< without the indentation of the fence
};

/// The folder that holds README.md, cases and tests.
std::filesystem::path source_tree();

/// Files of the tree with this extension, relative to it and sorted; build folders and hidden ones are left out.
std::vector<std::filesystem::path> files_with(const std::string& extension);

/// String literals; adjacent ones are one. A line break in a literal begins another passage. Raw literals, which hold
/// styles and scripts, and names of includes are left out, and tags of HTML end a sentence.
std::vector<Passage> literals_of(const std::string& source, const std::string& file);

/// Paragraphs, headings, list items and rows of tables, without code blocks, comments and addresses of links. Inline
/// code and a displayed formula count as a word; a paragraph goes on after a formula with a small letter.
std::vector<Passage> paragraphs_of(const std::string& markdown, const std::string& file);

std::vector<CodeBlock> code_blocks_of(const std::string& markdown);

/// Lines of a page outside of its code blocks.
std::vector<std::string> prose_lines(const std::string& markdown);

/// Sentences as ranges [begin, end) of the text.
std::vector<std::pair<std::size_t, std::size_t>> sentences_of(const std::string& text);

/// Parts between blanks that hold a letter, a digit or a placeholder.
std::ptrdiff_t words_in(std::string_view sentence);

}  // namespace thermotwin::cases
