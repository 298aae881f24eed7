// SPDX-License-Identifier: GPL-3.0-or-later
// Rules of the house that no compiler checks: includes point back along the order of the folders,
// every source file names its licence, and a heavy library stays behind one .cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/file.h"

namespace thermotwin::core {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> layers = {"core",         "mesh",      "solver", "reduction",
                                         "compensation", "diagnosis", "tools"};

struct Source {
  fs::path path;  // from the root of the tree
  std::string text;
};

bool is_source(const fs::path& path) {
  const std::set<std::string> extensions = {".h", ".cpp", ".c", ".py", ".sh", ".cmake", ".toml"};
  return extensions.count(path.extension().string()) > 0 || path.filename() == "CMakeLists.txt";
}

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

/// Position of the first folder of a path in the order of the layers; -1 for other folders.
int layer_of(const fs::path& path) {
  const auto found = std::find(layers.begin(), layers.end(), path.begin()->string());
  return found == layers.end() ? -1 : static_cast<int>(found - layers.begin());
}

TEST(Layers, ReaderOfIncludesWorks) {
  EXPECT_EQ(includes_of("#include \"core/a.h\"\n  # include <mesh/b.h>\n// #include \"c.h\"\n"),
            (std::vector<std::string>{"core/a.h", "mesh/b.h"}));
  EXPECT_LT(layer_of("core/a.h"), layer_of("tools/b.h"));
  EXPECT_EQ(layer_of("vector"), -1);
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

TEST(Layers, EverySourceFileNamesItsLicence) {
  std::vector<std::string> folders = layers;
  folders.insert(folders.end(), {"tests", "cases", "cmake"});
  for (const Source& source : sources_below(folders)) {
    const std::string head = source.text.substr(0, 200);
    EXPECT_NE(head.find("SPDX-License-Identifier: GPL-3.0-or-later"), std::string::npos) << source.path;
  }
}

TEST(Layers, HeavyLibrariesStayOutOfHeadersAndInOneFile) {
  const std::map<std::string, std::regex> heavy = {
      {"assimp", std::regex("^assimp/.*")},     {"gmsh", std::regex("^gmsh\\.h.*")},
      {"cholmod", std::regex(".*cholmod\\.h")}, {"umfpack", std::regex(".*umfpack\\.h")}, {"HDF5", std::regex("^(H5.*|hdf5)\\.h")},
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
  for (const char* library : {"assimp", "gmsh", "cholmod", "umfpack", "HDF5", "toml++"}) {
    std::string files;
    for (const std::string& file : users[library]) files += " " + file;
    EXPECT_LE(users[library].size(), 1U) << library << " is included in" << files;
  }
}

}  // namespace
}  // namespace thermotwin::core
