// SPDX-License-Identifier: GPL-2.0-or-later
#include "nc/rs274/files.h"

#include <climits>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <sys/stat.h>
#include <wordexp.h>

#include "nc/rs274/fanuc.h"
#include "nc/rs274/stream.h"

namespace thermotwin::nc::rs274 {

namespace {

bool guarded = false, is_fanuc = false;
FanucText fanuc_text;
std::string allowed_folder, refused;
std::vector<Rule> word_rules;
std::vector<char*> texts;                                     // of rewritten files, kept to the end
constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";  // of UTF-8
/// Stands for words that were left out, so that a line of them alone counts as executed.
constexpr const char* left_out = "(thermotwin:left out)";

bool is_python(const std::string& line) {
  for (std::size_t i = 0; i + 3 < line.size(); ++i) {
    if (line[i] != ';' && line[i] != '(') continue;
    std::size_t at = i + 1;
    while (at < line.size() && (line[at] == ' ' || line[at] == '\t')) ++at;
    if (strncasecmp(line.c_str() + at, "py,", 3) == 0 || strncasecmp(line.c_str() + at, "pyrun,", 6) == 0 ||
        strncasecmp(line.c_str() + at, "pyreload", 8) == 0)
      return true;
    if (line[i] == ';') return false;
  }
  return false;
}

/// A letter with an unsigned number in a line.
struct Code {
  char letter = 0;  ///< upper case
  double value = 0;
  std::size_t length = 0;  ///< characters; 0: there is none
};

Code code_at(const std::string& line, std::size_t i) {
  const auto is_letter = [&](std::size_t at) { return std::isalpha(static_cast<unsigned char>(line[at])) != 0; };
  if (!is_letter(i) || (i > 0 && is_letter(i - 1))) return {};
  std::size_t digits = i + 1;
  while (digits < line.size() && (line[digits] == ' ' || line[digits] == '\t')) ++digits;
  if (digits == line.size() || line[digits] == '-') return {};
  Code code;
  // Digits and a point alone: strtod reads 0X45 of "G0X45" as a hexadecimal number.
  const auto [end, error] =
      std::from_chars(line.data() + digits, line.data() + line.size(), code.value, std::chars_format::fixed);
  if (error != std::errc()) return {};
  code.letter = static_cast<char>(std::toupper(static_cast<unsigned char>(line[i])));
  code.length = end - (line.data() + i);
  return code;
}

bool is_of(const Code& code, const Rule& rule) {
  return rule.letter == code.letter && rule.number > code.value - 1e-6 && rule.number < code.value + 1e-6;
}

/// The last rule of a word, or one met before that takes the word along; null: there is none.
const Rule* rule_for(const Code& code, const std::vector<Rule>& rules, const std::vector<const Rule*>& met) {
  const Rule* rule = nullptr;
  for (const Rule& candidate : rules)
    if (is_of(code, candidate)) rule = &candidate;
  for (const Rule* before : met)
    if (before->second.find(code.letter) != std::string::npos) rule = before;
  return rule;
}

/// A line with %: the first one of a file begins the program, the next one ends it.
bool is_percent(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t"), last = line.find_last_not_of(" \t\r\n");
  return first != std::string::npos && first == last && line[first] == '%';
}

void see_variables(FILE* file) {
  char* raw = nullptr;
  std::size_t capacity = 0;
  for (ssize_t n = getline(&raw, &capacity, file); n >= 0; n = getline(&raw, &capacity, file))
    fanuc_text.see(std::string(raw, n));
  free(raw);
  rewind(file);
}

/// The whole file with rules applied, or null where nothing in it changes.
char* rewritten_text(FILE* file, std::size_t& size) {
  std::string out;
  bool differs = false, began = false, percent = false, ended = false;
  std::uint32_t number = 0;
  if (is_fanuc) see_variables(file);
  char* raw = nullptr;
  std::size_t capacity = 0;
  for (ssize_t n = getline(&raw, &capacity, file); n >= 0; n = getline(&raw, &capacity, file)) {
    ++number;
    std::string line(raw, n);
    if (number == 1 && line.starts_with(byte_order_mark)) {
      line.erase(0, byte_order_mark.size());
      differs = true;
    }
    // A program without % at its begin may end with one, behind which the control reads nothing.
    ended = ended || (began && !percent && is_percent(line));
    if (ended) {
      out += left_out;
      out += '\n';
      differs = true;
      continue;
    }
    percent = percent || (!began && is_percent(line));
    began = began || line.find_first_not_of(" \t\r\n") != std::string::npos;
    if (is_python(line)) {
      begin_block(number, 0);
      stop(Stop::program, "Python in a comment, which is not executed");
    }
    try {
      std::string changed = rewritten_line(is_fanuc ? fanuc_text.line(line) : line, word_rules);
      differs = differs || changed != line;
      out += changed;
    } catch (const std::string& message) {
      begin_block(number, 0);
      stop(Stop::program, message);
    }
  }
  free(raw);
  if (!differs) return nullptr;
  size = out.size();
  auto* text = static_cast<char*>(malloc(size + 1));
  std::memcpy(text, out.c_str(), size + 1);
  texts.push_back(text);
  return text;
}

FILE* real_open(const char* path, const char* mode) {
  using Open = FILE* (*)(const char*, const char*);
  static const auto open_file = reinterpret_cast<Open>(dlsym(RTLD_NEXT, "fopen64"));
  return open_file(path, mode);
}

FILE* guarded_open(const char* path, const char* mode) {
  if (!guarded) return real_open(path, mode);
  char resolved[PATH_MAX];
  struct stat status;
  if (std::strpbrk(mode, "wa+") != nullptr) {
    errno = EACCES;
    return nullptr;
  }
  if (realpath(path, resolved) == nullptr) return nullptr;
  if (std::string(resolved).compare(0, allowed_folder.size(), allowed_folder) != 0) {
    refused = resolved;
    errno = EACCES;
    return nullptr;
  }
  if (stat(resolved, &status) != 0 || !S_ISREG(status.st_mode)) {
    errno = EACCES;
    return nullptr;
  }
  FILE* file = real_open(resolved, "r");
  if (file == nullptr) return nullptr;
  write_text(Kind::file, 1, 0, resolved);
  std::size_t size = 0;
  if (char* text = rewritten_text(file, size); text != nullptr && size > 0) {
    fclose(file);
    return fmemopen(text, size, "r");
  }
  rewind(file);
  return file;
}

}  // namespace

void guard_files(const std::string& folder, std::vector<Rule> rules, bool fanuc) {
  char resolved[PATH_MAX];
  allowed_folder = realpath(folder.c_str(), resolved) != nullptr ? resolved : folder;
  if (allowed_folder.back() != '/') allowed_folder += '/';
  word_rules = std::move(rules);
  is_fanuc = fanuc;
  guarded = true;
}

const std::string& refused_file() { return refused; }

std::string rewritten_line(const std::string& line, const std::vector<Rule>& rules) {
  std::string out, marker;
  std::vector<const Rule*> met;
  bool named = false;
  std::size_t i = 0;
  while (i < line.size()) {
    const char c = line[i];
    if (c == ';' || c == '\r' || c == '\n') break;
    if (c == '(') {
      const std::size_t close = line.find(')', i);
      out += line.substr(i, close == std::string::npos ? std::string::npos : close - i + 1);
      if (close == std::string::npos) return out;
      i = close + 1;
      continue;
    }
    if (c == '<') named = true;
    if (c == '>') named = false;
    const Code code = named ? Code{} : code_at(line, i);
    if (code.length == 0) {
      out += c;
      ++i;
      continue;
    }
    const Rule* const rule = rule_for(code, rules, met);
    if (rule == nullptr) {
      out += line.substr(i, code.length);
    } else if (rule->action == Rule::Action::refuse) {
      throw line.substr(i, code.length) + (rule->text.empty() ? "" : " " + rule->text);
    } else if (is_of(code, *rule)) {
      met.push_back(rule);
      const std::size_t comment = std::min(rule->text.find('('), rule->text.size());
      if (rule->action == Rule::Action::replace) out += rule->text.substr(0, comment);
      if (marker.empty() || comment < rule->text.size()) marker = rule->text.substr(comment);
      if (marker.empty()) marker = left_out;
    }
    i += code.length;
  }
  // The interpreter takes the last comment of a line only.
  return out + marker + line.substr(std::min(i, line.size()));
}

}  // namespace thermotwin::nc::rs274

// The library's own calls come to these, which the linker finds before those of the C library.
extern "C" {

FILE* fopen64(const char* path, const char* mode) { return thermotwin::nc::rs274::guarded_open(path, mode); }
FILE* fopen(const char* path, const char* mode) { return thermotwin::nc::rs274::guarded_open(path, mode); }
int rename(const char* /*from*/, const char* /*to*/) noexcept { return errno = EACCES, -1; }
int unlink(const char* /*path*/) noexcept { return errno = EACCES, -1; }
int link(const char* /*from*/, const char* /*to*/) noexcept { return errno = EACCES, -1; }
/// Names of subprograms are taken as they are: no shell expands them.
int wordexp(const char* words, wordexp_t* result, int /*flags*/) {
  result->we_wordc = 1;
  result->we_offs = 0;
  result->we_wordv = static_cast<char**>(calloc(2, sizeof(char*)));
  if (result->we_wordv == nullptr) return WRDE_NOSPACE;
  result->we_wordv[0] = strdup(words);
  return 0;
}
void wordfree(wordexp_t* result) {
  if (result->we_wordv == nullptr) return;
  free(result->we_wordv[0]);
  free(result->we_wordv);
  result->we_wordv = nullptr;
}

}  // extern "C"
