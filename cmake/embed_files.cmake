# SPDX-License-Identifier: GPL-3.0-or-later
# cmake -D output=FILE.cpp -D folder=DIR -D "files=a.c,exported/main.c" -D header=HEADER -D function=NAME
#   -P embed_files.cmake
# Writes a source that defines compensation::NAME(), which HEADER declares: names and texts of the files.
string(REPLACE "," ";" files "${files}")
set(text "// SPDX-License-Identifier: GPL-3.0-or-later\n#include \"${header}\"\n
namespace thermotwin::compensation {\n
const std::vector<EmbeddedFile>& ${function}() {\n  static const std::vector<EmbeddedFile> files = {\n")
foreach(file IN LISTS files)
  get_filename_component(name "${file}" NAME)
  file(READ "${folder}/${file}" content)
  string(APPEND text "{\"${name}\", R\"embedded(${content})embedded\"},\n")
endforeach()
string(APPEND text "};\n  return files;\n}\n\n}  // namespace thermotwin::compensation\n")
file(WRITE "${output}" "${text}")
