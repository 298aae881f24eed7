// SPDX-License-Identifier: GPL-3.0-or-later
// Rules of the house that no compiler checks: includes point back along the order of the layers and of the rooms
// in them, a .cpp has one header of its name, every source file names its licence, and a heavy library stays
// behind one .cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/core/house.h"

namespace thermotwin::core {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> layers = layer_names();

TEST(Layers, ReaderOfIncludesWorks) {
  EXPECT_EQ(includes_of("#include \"core/a.h\"\n  # include <mesh/b.h>\n// #include \"c.h\"\n"),
            (std::vector<std::string>{"core/a.h", "mesh/b.h"}));
  EXPECT_LT(layer_of("core/a.h"), layer_of("tools/b.h"));
  EXPECT_EQ(layer_of("vector"), -1);
  EXPECT_LT(room_of("solver/linear/a.h"), room_of("solver/export/b.h"));
  EXPECT_LT(room_of("mesh/import/a.h"), room_of("mesh/b.h"));
  EXPECT_EQ(room_of("mesh/attic/a.h"), -1);
}

TEST(Layers, IncludesPointBack) {
  const std::vector<Source> sources = sources_below(layers);
  ASSERT_GT(sources.size(), 10U);
  for (const Source& source : sources) {
    for (const std::string& name : includes_of(source.text)) {
      EXPECT_LE(layer_of(name), layer_of(source.path)) << source.path << " includes " << name;
      EXPECT_NE(fs::path(name).begin()->string(), "tests") << source.path << " includes " << name;
    }
  }
}

TEST(Rooms, IncludesPointBack) {
  for (const Source& source : sources_below(layers)) {
    EXPECT_GE(room_of(source.path), 0) << source.path << " is in a room that has no place in the order";
    for (const std::string& name : includes_of(source.text)) {
      if (layer_of(name) != layer_of(source.path) || layer_of(name) < 0) continue;
      EXPECT_LE(room_of(name), room_of(source.path)) << source.path << " includes " << name;
    }
  }
}

TEST(Rooms, EveryCppHasOneHeaderOfItsName) {
  for (const Source& source : sources_below(layers)) {
    if (source.path.extension() != ".cpp" || layer_of(source.path) == layer_of("tools")) continue;
    if (source.path.filename() == "multigrid_petsc_module.cpp") continue;  // loaded by name
    if (source.path == "nc/rs274/rs274.cpp") continue;                     // a program of its own
    fs::path header = source.path;
    header.replace_extension(".h");
    EXPECT_TRUE(fs::exists(fs::path(THERMOTWIN_SOURCE_DIR) / header)) << source.path;
    const std::vector<std::string> names = includes_of(source.text);
    EXPECT_TRUE(!names.empty() && names.front() == header.string()) << source.path << " includes its own header first";
  }
}

TEST(Layers, EverySourceFileNamesItsLicence) {
  std::vector<std::string> folders = layers;
  folders.insert(folders.end(), {"tests", "cases", "cmake"});
  for (const Source& source : sources_below(folders)) {
    const std::string head = source.text.substr(0, 200);
    // The helper process links LinuxCNC, which is under GPL-2.0.
    const char* licence = source.path.parent_path() == "nc/rs274" ? "GPL-2.0-or-later" : "GPL-3.0-or-later";
    EXPECT_NE(head.find(std::string("SPDX-License-Identifier: ") + licence), std::string::npos) << source.path;
  }
}

TEST(Layers, HeavyLibrariesStayOutOfHeadersAndInOneFile) {
  const std::map<std::string, std::regex> heavy = {
      {"assimp", std::regex("^assimp/.*")},     {"gmsh", std::regex("^gmsh\\.h.*")},
      {"cholmod", std::regex(".*cholmod\\.h")}, {"umfpack", std::regex(".*umfpack\\.h")},
      {"HDF5", std::regex("^(H5.*|hdf5)\\.h")}, {"muParser", std::regex("^muParser.*")},
      {"toml++", std::regex("^toml\\+\\+/.*")}, {"VTK", std::regex("^vtk[A-Z].*\\.h")}};
  std::map<std::string, std::set<std::string>> users;  // library and folder -> files
  for (const Source& source : sources_below(layers)) {
    if (source.path == "tools/benchmarks/bare_cholmod.cpp") continue;  // what we are measured against
    for (const std::string& name : includes_of(source.text)) {
      for (const auto& [library, pattern] : heavy) {
        if (!std::regex_match(name, pattern)) continue;
        EXPECT_NE(source.path.extension(), ".h") << source.path << " includes " << name;
        users[library].insert(source.path.string());
      }
    }
  }
  for (const auto& [library, pattern] : heavy) {
    std::string files;
    for (const std::string& file : users[library]) files += " " + file;
    const std::size_t most = library == "VTK" ? 2 : 1;  // its data and files, and its renderer
    EXPECT_LE(users[library].size(), most) << library << " is included in" << files;
  }
}

}  // namespace
}  // namespace thermotwin::core
