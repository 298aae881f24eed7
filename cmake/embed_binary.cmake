# SPDX-License-Identifier: GPL-3.0-or-later
# cmake -D output=FILE.cpp -D binary=FILE -D function=NAME -P embed_binary.cmake
# Writes a source that defines compensation::NAME() (compensation/control/control_fmu.h).
file(READ "${binary}" bytes HEX)
string(REGEX REPLACE "(................................................................)" "\\1\n" bytes "${bytes}")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
file(WRITE "${output}" "// SPDX-License-Identifier: GPL-3.0-or-later\n#include \"compensation/control/control_fmu.h\"\n
namespace thermotwin::compensation {\n
std::string_view ${function}() {\n  static const unsigned char bytes[] = {\n${bytes}};
  return {reinterpret_cast<const char*>(bytes), sizeof bytes};\n}\n\n}  // namespace thermotwin::compensation\n")
