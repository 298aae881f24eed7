// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/dialect/translated_program.h"

#include <cstdlib>
#include <fstream>
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

void translate(const std::filesystem::path& from, const std::filesystem::path& to, const ControlProfile& control,
               int axis_mask, const Nine& start) {
  std::ifstream in(from, std::ios::binary);
  std::ofstream out(to, std::ios::binary);
  SiemensReader reader(control, axis_mask, from.string(), start);
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    constexpr std::size_t between_looks = 4096;
    if (++number % between_looks == 0) core::check_interrupt();
    if (number == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // byte order mark of UTF-8
    out << reader.translate(line, number) << '\n';
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
