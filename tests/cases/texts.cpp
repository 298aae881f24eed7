// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cases/texts.h"

#include <algorithm>
#include <cctype>
#include <regex>
#include <sstream>

#include "tests/cases/toy.h"

namespace thermotwin::cases {

namespace fs = std::filesystem;

namespace {

bool is_blank(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }
bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

/// Reads C++ as far as its literals go.
class LiteralReader {
public:
  LiteralReader(const std::string& source, std::string file) : source_(source), file_(std::move(file)) {}

  std::vector<Passage> read() {
    while (at_ < source_.size()) {
      if (starts("//")) {
        skip_to(source_.find('\n', at_));
      } else if (starts("/*")) {
        skip_to(source_.find("*/", at_), 2);
      } else if (source_[at_] == '#' && starts("#include")) {
        skip_to(source_.find('\n', at_));
      } else if (starts("R\"") && (at_ == 0 || !is_word(source_[at_ - 1]))) {
        end_literal();
        const std::size_t open = source_.find('(', at_);
        skip_to(source_.find(")" + source_.substr(at_ + 2, open - at_ - 2) + "\"", open), open - at_);
      } else if (source_[at_] == '"') {
        take_literal();
      } else if (source_[at_] == '\'' && (at_ == 0 || !is_word(source_[at_ - 1]))) {
        end_literal();
        for (++at_; at_ < source_.size() && source_[at_] != '\''; ++at_) at_ += source_[at_] == '\\' ? 1U : 0U;
        ++at_;
      } else {
        if (!is_blank(source_[at_])) end_literal();
        step();
      }
    }
    end_literal();
    return std::move(passages_);
  }

private:
  bool starts(std::string_view words) const { return source_.compare(at_, words.size(), words) == 0; }
  void step() { line_ += source_[at_++] == '\n' ? 1 : 0; }
  void skip_to(std::size_t place, std::size_t more = 0) {
    const std::size_t end = place == std::string::npos ? source_.size() : std::min(place + more, source_.size());
    while (at_ < end) step();
  }

  void take_literal() {
    for (++at_; at_ < source_.size() && source_[at_] != '"'; ++at_) {
      char c = source_[at_];
      if (c == '\\') {
        c = source_[++at_];
        if (c == 'n') {
          end_literal();
          continue;
        }
      }
      literal_.append(std::string_view(&c, 1), line_);
    }
    ++at_;
  }

  void end_literal() {
    literal_.finish();
    if (!literal_.text.empty()) passages_.push_back(std::move(literal_));
    literal_ = Passage(file_);
  }

  const std::string& source_;
  std::string file_;
  std::size_t at_ = 0;
  long line_ = 1;
  Passage literal_{file_};
  std::vector<Passage> passages_;
};

/// Prose without what is no prose in it.
std::string plain(const std::string& line) {
  static const std::regex code("`[^`]*`"), link("!?\\[([^\\]]*)\\]\\([^)]*\\)"), address("<?https?://[^ )>]*>?");
  std::string text = std::regex_replace(line, code, "x");
  text = std::regex_replace(text, link, "$1");
  return std::regex_replace(text, address, "x");
}

std::size_t indentation(const std::string& line) { return std::min(line.find_first_not_of(' '), line.size()); }

bool begins_item(const std::string& line) {
  static const std::regex item("\\s*([-*+]|[0-9]+\\.)\\s.*");
  return std::regex_match(line, item);
}

}  // namespace

void Passage::append(std::string_view piece, long line) {
  for (const char c : piece) {
    if (is_blank(c) && (text.empty() || text.back() == ' ')) continue;
    text += is_blank(c) ? ' ' : c;
    lines_.push_back(line);
  }
}

void Passage::finish() {
  if (text.empty() || text.back() != ' ') return;
  text.pop_back();
  lines_.pop_back();
}

fs::path source_tree() { return fs::weakly_canonical(toy_case() / "../../.."); }

std::vector<fs::path> files_with(const std::string& extension) {
  const fs::path root = source_tree();
  std::vector<fs::path> found;
  auto entry = fs::recursive_directory_iterator(root);
  for (; entry != fs::recursive_directory_iterator(); ++entry) {
    const std::string name = entry->path().filename().string();
    if (entry->is_directory()) {
      const bool built = name == "build" || name == "out" || fs::exists(entry->path() / "CMakeCache.txt");
      if (built || name.starts_with(".")) entry.disable_recursion_pending();
    } else if (entry->path().extension() == extension) {
      found.push_back(fs::relative(entry->path(), root));
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<Passage> literals_of(const std::string& source, const std::string& file) {
  return LiteralReader(source, file).read();
}

std::vector<Passage> paragraphs_of(const std::string& markdown, const std::string& file) {
  std::vector<Passage> paragraphs;
  Passage current(file);
  const auto end = [&] {
    current.finish();
    if (!current.text.empty()) paragraphs.push_back(std::move(current));
    current = Passage(file);
  };
  std::istringstream lines(markdown);
  bool in_code = false, in_comment = false, in_formula = false;
  bool parted = false, after_formula = false;  // by a blank line; the last text was a displayed formula
  long number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::size_t indent = indentation(line);
    if (line.compare(indent, 3, "```") == 0) {
      end();
      in_code = !in_code;
      continue;
    }
    if (line.compare(indent, 4, "<!--") == 0) in_comment = true;
    if (in_code || in_comment) {
      in_comment = in_comment && line.find("-->") == std::string::npos;
      continue;
    }
    if (in_formula) {
      in_formula = line.find("$$") == std::string::npos;
      continue;
    }
    if (indent == line.size()) {
      parted = true;
      continue;
    }
    // A sentence goes on over a displayed formula, which is a word of it.
    if (line.compare(indent, 2, "$$") == 0) {
      in_formula = line.find("$$", indent + 2) == std::string::npos;
      current.append(" X ", number);
      parted = false;
      after_formula = true;
      continue;
    }
    const bool row = line.compare(indent, 1, "|") == 0, heading = line.starts_with("#");
    const bool goes_on = after_formula && std::islower(static_cast<unsigned char>(line[indent])) != 0;
    if ((parted && !goes_on) || row || heading || begins_item(line)) end();
    parted = after_formula = false;
    if (indent >= 4 && current.text.empty() && !begins_item(line)) continue;
    current.is_table_row = row;
    current.append(plain(line) + "\n", number);
    if (row || heading) end();
  }
  end();
  return paragraphs;
}

std::vector<CodeBlock> code_blocks_of(const std::string& markdown) {
  std::vector<CodeBlock> blocks;
  std::istringstream lines(markdown);
  bool inside = false;
  std::size_t indent = 0;
  long number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::size_t own = indentation(line);
    if (line.compare(own, 3, "```") == 0) {
      inside = !inside;
      indent = own;
      if (inside) blocks.push_back({line.substr(std::min(own + 3, line.size())), number + 1, {}});
    } else if (inside) {
      blocks.back().lines.push_back(line.substr(std::min({own, indent, line.size()})));
    }
  }
  return blocks;
}

std::vector<std::string> prose_lines(const std::string& markdown) {
  std::vector<std::string> lines;
  std::istringstream all(markdown);
  bool code = false;
  for (std::string line; std::getline(all, line);) {
    const bool fence = line.find("```") == line.find_first_not_of(' ') && line.find("```") != std::string::npos;
    if (fence) code = !code;
    if (!fence && !code) lines.push_back(line);
  }
  return lines;
}

namespace {

/// @param text  up to a point
bool ends_abbreviation(std::string_view text) {
  static const std::vector<std::string_view> all = {"al.", "Fig.", "Figs.", "Eq.", "Doc.", "No.", "e.g.", "cf."};
  return std::any_of(all.begin(), all.end(), [&](std::string_view word) {
    return text.ends_with(word) && (text.size() == word.size() || !is_word(text[text.size() - word.size() - 1]));
  });
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> sentences_of(const std::string& text) {
  std::vector<std::pair<std::size_t, std::size_t>> sentences;
  std::size_t begin = 0;
  const auto end_at = [&](std::size_t end) {
    if (end > begin) sentences.emplace_back(begin, end);
    begin = end;
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '<' && i + 1 < text.size() &&
        (std::isalpha(static_cast<unsigned char>(text[i + 1])) || text[i + 1] == '/')) {
      const std::size_t close = text.find('>', i);
      if (close == std::string::npos) continue;
      end_at(i);
      begin = i = close + 1;
      continue;
    }
    if (std::string_view(".!?").find(text[i]) == std::string_view::npos) continue;
    std::size_t after = i + 1;
    if (ends_abbreviation(std::string_view(text).substr(begin, i + 1 - begin))) continue;
    while (after < text.size() && std::string_view("\"')]*_").find(text[after]) != std::string_view::npos) ++after;
    if (after < text.size() && text[after] == ' ' && after + 1 < text.size() &&
        std::islower(static_cast<unsigned char>(text[after + 1])) == 0)
      end_at(after + 1);
  }
  end_at(text.size());
  return sentences;
}

std::ptrdiff_t words_in(std::string_view sentence) {
  std::ptrdiff_t count = 0;
  bool counted = false;
  for (const char c : sentence) {
    if (is_blank(c)) counted = false;
    if (counted || !(is_word(c) || c == '{')) continue;
    counted = true;
    ++count;
  }
  return count;
}

}  // namespace thermotwin::cases
