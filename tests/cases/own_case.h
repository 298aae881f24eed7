// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A small case such as a user writes by hand: blocks of steel as STL files in millimetres, a few lines of machine.toml.

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/cases/toy.h"

namespace thermotwin::cases {

struct Block {
  std::array<double, 3> low, high;  ///< mm
};

/// STL of blocks side by side: one closed shell each.
std::string stl_of(const std::vector<Block>& blocks);

/// [[body]] "id" of steel from cad/id.stl; more: further lines.
std::string body_text(const std::string& id, double element_size_mm, const std::string& more = "");

class OwnCase {
public:
  /// @param machine  what comes after name and material "steel" in machine.toml
  explicit OwnCase(const std::string& machine);
  /// cad/<id>.stl
  void blocks(const std::string& id, const std::vector<Block>& of) const;
  void write(const std::string& name, const std::string& text) const;

  std::string path() const { return (folder_ / "own").string(); }
  std::filesystem::path result(const std::string& name) const { return folder_ / "out" / name; }
  /// thermotwin VERB ... --out of this case
  Result run(std::vector<std::string> arguments) const;

private:
  core::TemporaryFolder folder_;
};

}  // namespace thermotwin::cases
