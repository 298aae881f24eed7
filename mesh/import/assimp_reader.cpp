// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/assimp_reader.h"

#include <system_error>

#include "core/error.h"
#include "core/module.h"
#include "mesh/import/assimp_module.h"

namespace thermotwin::mesh {

namespace {

ReadTriangles assimp_module() {
  static const ReadTriangles reader = [] {
    void* found = core::module_function("libthermotwin_assimp.so", "thermotwin_assimp", "surface files",
                                        "install the program again");
    return reinterpret_cast<ReadTriangles (*)()>(found)();
  }();
  return reader;
}

}  // namespace

void load_assimp() { assimp_module(); }

Surface read_triangles(const std::filesystem::path& path, const std::string& body) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored))
    throw core::InputError("body '" + body + "'", "no such file: '" + path.string() + "'", "a readable surface file");
  return assimp_module()(path, body);
}

}  // namespace thermotwin::mesh
