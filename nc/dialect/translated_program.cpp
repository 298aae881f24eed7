// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/dialect/translated_program.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <system_error>

#include "core/error.h"
#include "core/progress.h"
#include "nc/dialect/siemens_reader.h"

namespace thermotwin::nc {

using core::InputError;

namespace {

std::filesystem::path temporary_folder() {
  std::string name = (std::filesystem::temp_directory_path() / "thermotwin_nc_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr)
    throw InputError(name, "cannot be made", "a folder for temporary files (TMPDIR) with room and permission");
  return std::filesystem::canonical(name);
}

/// A Sinumerik control starts with G1, LinuxCNC's interpreter without a motion mode: the first line of coordinates that
/// states none gets it. @return whether the line has set a mode
bool begin_motion(std::string& line) {
  std::istringstream words(line);
  bool moves = false;
  for (std::string word; words >> word;) {
    if (word[0] == '/') word.erase(0, 1);
    if (word.empty()) continue;
    if (word[0] == 'G') {
      const double code = std::atof(word.c_str() + 1);
      if (code < 4.0 || code == 33.0 || (code >= 73.0 && code < 90.0)) return line[0] != '/';
      if (code == 52.0 || code == 10.0 || code == 92.0 || code == 28.0 || code == 30.0) return false;
    }
    moves = moves || std::find(letters.begin(), letters.end(), word[0]) != letters.end();
  }
  if (!moves) return false;
  line.insert(line[0] == '/' ? 1 : 0, "G1 ");
  return line[0] != '/';
}

void translate(const std::filesystem::path& from, const std::filesystem::path& to, const ControlProfile& control,
               int axis_mask, const Nine& start) {
  std::ifstream in(from, std::ios::binary);
  std::ofstream out(to, std::ios::binary);
  SiemensReader reader(control, axis_mask, from.string(), start);
  std::size_t number = 0;
  bool moving = false;
  for (std::string line; std::getline(in, line);) {
    constexpr std::size_t between_looks = 4096;
    if (++number % between_looks == 0) core::check_interrupt();
    if (number == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // byte order mark of UTF-8
    std::string text = reader.translate(line, number);
    moving = moving || begin_motion(text);
    out << text << '\n';
  }
  out.close();
  if (!out) throw InputError(to.string(), "cannot be written", "room for the program in LinuxCNC's language");
}

}  // namespace

TranslatedProgram::TranslatedProgram(const std::filesystem::path& program, const ControlProfile& control, int axis_mask,
                                     const Nine& start)
    : folder_(temporary_folder()) {
  try {
    translate(program, path(), control, axis_mask, start);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
    throw;
  }
}

TranslatedProgram::~TranslatedProgram() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

}  // namespace thermotwin::nc
