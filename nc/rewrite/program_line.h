// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A line of an NC program as text with the places of its words, so that single numbers change and all else stays.

#include <cstddef>
#include <filesystem>
#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace thermotwin::nc {

/// Of UTF-8, which editors put before the first line of a file.
constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";

struct Word {
  char letter = 0;                 ///< upper case; @ and ^ of polar coordinates
  std::size_t begin = 0, end = 0;  ///< in the text, from the letter on
  double value = 0;
  bool expression = false;  ///< #1, [1 + 2]: the value is not in the text
};

struct ProgramLine {
  std::string text;  ///< without its end
  std::string end;   ///< "\n", "\r\n" or nothing
  std::vector<Word> words;
  bool control = false;      ///< an O-word: subprograms, loops, branches
  bool label = false;        ///< an O-word with a number alone: the program's name
  bool assigns = false;      ///< sets a parameter
  std::size_t code_end = 0;  ///< behind the last word

  static ProgramLine parse(std::string text, std::string end);

  const Word* find(char letter) const;
  bool has(char letter, double number) const;

  /// Puts a word's number in its place, or adds the word behind the last one of the letters in `after` that is there.
  void set(char letter, const std::string& number, const std::string& after);
  void remove(const std::vector<std::pair<char, double>>& words);
  void remove(char letter);  ///< expressions too

private:
  void read_words();
  bool move_words(std::size_t begin, std::size_t shift);
};

/// The number as NC programs write it: at most so many decimals, no trailing zeros but one, no -0.
std::string nc_number(double value, int decimals);

/// A program by its lines. Of a file only every 64th line's place is kept, and the lines about the one last asked for:
/// memory does not grow with the program. A byte order mark is none of the text.
class ProgramText {
public:
  /// @param text  of any content
  explicit ProgramText(const std::string& text);
  /// @throws InputError if it cannot be read
  static ProgramText of_file(const std::filesystem::path& path);

  std::size_t size() const { return size_; }
  ProgramLine line(std::size_t index) const;  ///< from 0
  std::string raw(std::size_t index) const;   ///< with its end

private:
  ProgramText(std::unique_ptr<std::istream> in, std::string name);
  void load(std::size_t chunk) const;

  std::unique_ptr<std::istream> in_;
  std::string name_;
  std::size_t size_ = 0;
  std::vector<std::streamoff> begins_;  ///< of the chunks
  mutable std::size_t chunk_ = std::string::npos;
  mutable std::vector<std::string> lines_;  ///< of the chunk
};

}  // namespace thermotwin::nc
