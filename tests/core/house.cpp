// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/core/house.h"

#include <algorithm>
#include <regex>
#include <set>
#include <sstream>

#include "core/file.h"

namespace thermotwin::core {
namespace fs = std::filesystem;

namespace {

bool is_source(const fs::path& path) {
  const std::set<std::string> extensions = {".h", ".cpp", ".c", ".py", ".sh", ".cmake", ".toml"};
  return extensions.count(path.extension().string()) > 0 || path.filename() == "CMakeLists.txt";
}

}  // namespace

std::vector<Source> sources_below(const std::vector<std::string>& folders) {
  const fs::path root = THERMOTWIN_SOURCE_DIR;
  std::vector<Source> sources;
  for (const std::string& folder : folders) {
    if (!fs::exists(root / folder)) continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      const bool in_output = entry.path().string().find("/out/") != std::string::npos;
      if (entry.is_regular_file() && is_source(entry.path()) && !in_output) {
        sources.push_back({fs::relative(entry.path(), root), read_file(entry.path())});
      }
    }
  }
  return sources;
}

std::vector<std::string> includes_of(const std::string& text) {
  static const std::regex include("^\\s*#\\s*include\\s*[\"<]([^\">]+)[\">]");
  std::vector<std::string> names;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_search(line, match, include)) names.push_back(match[1]);
  }
  return names;
}

std::string bare(const std::string& text) {
  std::string code;
  const auto skip = [&](std::size_t from, std::size_t to) {
    to = std::min(to, text.size());
    code += ' ';
    code.append(std::count(text.begin() + from, text.begin() + to, '\n'), '\n');
    return to;
  };
  const auto behind = [&](const std::string& end, std::size_t from) {
    const std::size_t at = text.find(end, from);
    return at == std::string::npos ? text.size() : at + end.size();
  };
  for (std::size_t i = 0; i < text.size();) {
    const bool in_word = i > 0 && (std::isalnum(static_cast<unsigned char>(text[i - 1])) != 0 || text[i - 1] == '_');
    if (text.compare(i, 2, "//") == 0) {
      i = skip(i, text.find('\n', i));
    } else if (text.compare(i, 2, "/*") == 0) {
      i = skip(i, behind("*/", i + 2));
    } else if (text.compare(i, 2, "R\"") == 0 && !in_word) {
      const std::size_t open = text.find('(', i);
      i = skip(i, behind(")" + text.substr(i + 2, open - i - 2) + "\"", open));
    } else if (text[i] == '"' || (text[i] == '\'' && !in_word)) {  // in a number, ' parts digits
      std::size_t end = i + 1;
      while (end < text.size() && text[end] != text[i]) end += text[end] == '\\' ? 2 : 1;
      i = skip(i, end + 1);
    } else {
      code += text[i++];
    }
  }
  return code;
}

std::vector<std::string> layer_names() {
  std::vector<std::string> names;
  for (const Layer& layer : house) names.push_back(layer.name);
  return names;
}

int layer_of(const fs::path& path) {
  const auto found = std::find_if(house.begin(), house.end(),
                                  [&](const Layer& layer) { return layer.name == path.begin()->string(); });
  return found == house.end() ? -1 : static_cast<int>(found - house.begin());
}

int room_of(const fs::path& path) {
  const int layer = layer_of(path);
  if (layer < 0) return -1;
  const auto& order = house[layer].rooms;
  const fs::path folder = path.parent_path();
  if (folder == *path.begin() || order.empty()) return static_cast<int>(order.size());
  const auto found = std::find(order.begin(), order.end(), std::next(path.begin())->string());
  return found == order.end() ? -1 : static_cast<int>(found - order.begin());
}

}  // namespace thermotwin::core
