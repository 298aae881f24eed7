// SPDX-License-Identifier: GPL-3.0-or-later
// docs/rooms.svg, the map of layers and rooms, is drawn from the includes; THERMOTWIN_ROOMS=FILE writes it anew.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>

#include "core/file.h"
#include "tests/core/house.h"

namespace thermotwin::core {
namespace {

/// For each layer which rooms (index, the layer's own folder last) include which.
std::map<int, std::set<std::pair<int, int>>> arrows() {
  std::map<int, std::set<std::pair<int, int>>> found;
  for (const Source& source : sources_below(layer_names())) {
    for (const std::string& name : includes_of(source.text)) {
      if (const int layer = layer_of(source.path);
          layer >= 0 && layer_of(name) == layer && room_of(name) != room_of(source.path))
        found[layer].insert({room_of(source.path), room_of(name)});
    }
  }
  return found;
}

/// Whether a layer has files outside of its rooms.
bool has_files_on_top(const std::string& layer) {
  const std::vector<Source> sources = sources_below({layer});
  return std::any_of(sources.begin(), sources.end(), [&](const Source& source) {
    return source.path.parent_path() == layer && source.path.extension() == ".cpp";
  });
}

std::string figure() {
  constexpr int left = 150, wide = 104, gap = 14, high = 34, width = 1230;
  std::string body;
  int y = 64;
  const auto all = arrows();
  for (std::size_t l = 0; l < house.size(); ++l) {
    const Layer& layer = house[l];
    std::vector<std::string> boxes = layer.rooms;
    const bool files_on_top = has_files_on_top(layer.name);
    if (files_on_top) boxes.push_back(boxes.empty() ? "all files" : "on top");
    const auto own = all.find(l);
    int longest = 0;
    if (own != all.end())
      for (const auto& [from, to] : own->second) longest = std::max(longest, from - to);
    const int deep = longest > 0 ? 16 + 11 * longest : 0, band = high + 24 + deep;
    body += fmt::format("<rect x=\"10\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"8\" fill=\"{}\"/>\n", y, width - 20,
                        band, l % 2 ? "#f3f6f9" : "#e9eff4");
    body += fmt::format("<text x=\"24\" y=\"{}\" class=\"layer\">{}</text>\n", y + 12 + high / 2 + 5, layer.name);
    const auto centre = [&](int box) { return left + box * (wide + gap) + wide / 2; };
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      const bool top = files_on_top && b + 1 == boxes.size();
      body += fmt::format(
          "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"5\" fill=\"#fff\" stroke=\"#47607a\"{}/>\n",
          centre(b) - wide / 2, y + 12, wide, high, top ? " stroke-dasharray=\"4 3\"" : "");
      body +=
          fmt::format("<text x=\"{}\" y=\"{}\" class=\"room\">{}</text>\n", centre(b), y + 12 + high / 2 + 4, boxes[b]);
    }
    if (own != all.end()) {
      for (const auto& [from, to] : own->second) {
        const int foot = y + 12 + high, down = 14 * (from - to) + 8, x0 = centre(from) - 12, x1 = centre(to) + 12;
        body += fmt::format("<path d=\"M{} {} C{} {} {} {} {} {}\" marker-end=\"url(#tip)\"/>\n", x0, foot, x0 - 10,
                            foot + down, x1 + 10, foot + down, x1, foot + 2);
      }
    }
    y += band + 8;
  }
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" "
             "font-size=\"13\">\n"
             "<!-- drawn from the includes by tests/core/rooms_figure_test.cpp -->\n"
             "<style>.layer{{font-weight:bold;font-size:14px}}.room{{text-anchor:middle}}path{{fill:none;stroke:#"
             "7d93a8;stroke-width:1.2}}</style>\n"
             "<defs><marker id=\"tip\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" markerWidth=\"6\" markerHeight=\"6\" "
             "orient=\"auto\"><path d=\"M0 0L8 4L0 8z\" style=\"fill:#7d93a8;stroke:none\"/></marker></defs>\n"
             "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
             "<text x=\"14\" y=\"26\" font-size=\"17\" font-weight=\"bold\">Layers and rooms</text>\n"
             "<text x=\"14\" y=\"48\">A layer may use the layers above it, a room the rooms to its left: each arrow is "
             "a use. No arrow points the other way.</text>\n",
             width, y + 4) +
         body + "</svg>\n";
}

TEST(Rooms, FigureShowsWhatIsThere) {
  if (const char* file = std::getenv("THERMOTWIN_ROOMS")) write_file(file, figure());
  EXPECT_TRUE(read_file(THERMOTWIN_SOURCE_DIR "/docs/rooms.svg") == figure())
      << "draw it anew: THERMOTWIN_ROOMS=docs/rooms.svg build/tests/core_tests --gtest_filter=Rooms.*";
}

}  // namespace
}  // namespace thermotwin::core
