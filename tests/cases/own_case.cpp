// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cases/own_case.h"

#include <fmt/format.h>

#include <fstream>

namespace thermotwin::cases {

namespace fs = std::filesystem;

std::string stl_of(const std::vector<Block>& blocks) {
  // Corner i has the high end along x, y, z where bit 0, 1, 2 of i is set; outward triangles.
  constexpr int triangles[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  std::string text = "solid blocks\n";
  for (const Block& block : blocks) {
    for (const auto& triangle : triangles) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int corner : triangle) {
        text += "vertex";
        for (std::size_t k = 0; k < 3; ++k)
          text += fmt::format(" {}", (corner >> k & 1) != 0 ? block.high[k] : block.low[k]);
        text += "\n";
      }
      text += "endloop\nendfacet\n";
    }
  }
  return text + "endsolid blocks\n";
}

std::string body_text(const std::string& id, double element_size_mm, const std::string& more) {
  return fmt::format(
      "[[body]]\nid = \"{0}\"\nmaterial = \"steel\"\ncad = \"cad/{0}.stl\"\nelement_size_mm = {1}\n{2}\n", id,
      element_size_mm, more);
}

OwnCase::OwnCase(const std::string& machine) {
  write(
      "machine.toml",
      "schema = 1\nname = \"own\"\nreference_C = 20\n[[material]]\nid = \"steel\"\ndensity_kg_m3 = 7850\n"
      "specific_heat_J_kgK = 470\nconductivity_W_mK = 45\nexpansion_1_K = 11.5e-6\nyoung_GPa = 208\npoisson = 0.29\n" +
          machine);
  write("case.toml", "schema = 1\nmachine = \"machine.toml\"\ntrain = [\"hour\"]\n");
  write(
      "loads/hour.toml",
      "schema = 1\ntitle = \"an hour\"\ninitial_C = 20\ntime_step_s = 60\noutput_s = 600\n[[phase]]\nduration_h = 1\n");
}

void OwnCase::write(const std::string& name, const std::string& text) const {
  const fs::path file = fs::path(path()) / name;
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

void OwnCase::blocks(const std::string& id, const std::vector<Block>& of) const {
  write("cad/" + id + ".stl", stl_of(of));
}

Result OwnCase::run(std::vector<std::string> arguments) const {
  arguments.insert(arguments.end(), {"--out", (folder_ / "out").string()});
  return thermotwin(arguments);
}

}  // namespace thermotwin::cases
