// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The order of the house: layers, and the rooms in them. Includes point back along it; tests of this folder
// hold it, docs/rooms.svg shows it and tools/house reads it.

#include <filesystem>
#include <string>
#include <vector>

namespace thermotwin::core {

struct Layer {
  std::string name;
  std::vector<std::string> rooms;  ///< first to last; what lies in the layer's own folder comes after them
};

inline const std::vector<Layer> house = {
    {"core", {}},
    {"mesh", {"machine", "body", "surface", "import"}},
    {"solver", {"operation", "linear", "contact", "thermal", "elastic", "campaign", "export"}},
    {"reduction", {"linear", "model", "systems", "basis", "bound"}},
    {"compensation", {"measurement", "models", "online", "control", "linuxcnc", "evaluation", "chain"}},
    {"diagnosis", {"record", "statistics", "causes", "response", "inference", "judge", "report", "data"}},
    {"metrology", {"fit", "budget", "probe", "rtest", "mandrel", "surface", "iso230", "plan", "twin"}},
    {"nc", {"rs274", "control", "dialect", "program", "motion", "load", "prediction", "rewrite", "report"}},
    {"study", {"plan", "statistics", "units", "variants", "placement", "tests"}},
    {"tools", {}}};

/// Casts in every spelling, in a line without comments and literals: static_cast<T>(x) and matrix.cast<T>(); double(x)
/// and int{x}, where x is no number; (T)x. (void)x converts nothing, it states that x is not used.
inline const std::vector<std::string> casts = {
    R"(\w*cast<)",
    R"((?:^|[^\w<:.>])(?:std::|Eigen::)?(?:[a-z]*(?:size|ptrdiff|int\d+|intptr|time)_t|Index|bool|char|short|int|long|unsigned|float|double)(?:\((?![)*])|\{(?=[A-Za-z_(*&])))",
    R"((?:^|[^\w)\]>])\((?!void\))(?:\w+::)*\w+(?: \w+)*[ *&]*(?:const)?[ *]*\)(?=[\w(*&~!\-"]))"};

struct Source {
  std::filesystem::path path;  ///< from the root of the tree
  std::string text;
};
std::vector<Source> sources_below(const std::vector<std::string>& folders);
std::vector<std::string> includes_of(const std::string& text);
/// The text without comments and literals of characters and texts; breaks of lines stay.
std::string bare(const std::string& text);
std::vector<std::string> layer_names();

/// Position of the first folder of a path in the order of the layers; -1 for other folders.
int layer_of(const std::filesystem::path& path);
/// Position of the path's room in its layer; as many as the layer has rooms: the layer's own folder; -1: unknown.
int room_of(const std::filesystem::path& path);

}  // namespace thermotwin::core
