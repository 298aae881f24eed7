// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Helpers that the readers of machine.toml share. Ids are looked up after all tables are read, because a table may
// refer to one further down the file. Until then a reference is kept with its place.

#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "core/config.h"
#include "core/error.h"
#include "core/units.h"
#include "mesh/machine/machine.h"

namespace thermotwin::mesh::reader {

inline constexpr double millimetre = core::units::mm;
inline constexpr double degree = core::units::deg;

/// A machine that is being read, with the ids found so far.
struct Draft {
  struct Reference {
    std::string kind, id, place;  ///< kind: "material", "body", "axis", "surface", ...
  };
  Machine machine;
  std::vector<Reference> references;
  std::map<std::string, std::vector<std::string>> ids;  ///< kind -> ids that exist
  std::map<std::string, std::string> places;            ///< "joint X_guide" -> where it stands

  /// Reads and registers the id of a table. @throws InputError if another table of the kind has it
  std::string define(const core::Node& node, const std::string& kind);
  /// Reads a required id of that kind, which check_references() looks up later.
  std::string refer(const core::Node& node, const std::string& key, const std::string& kind);
  std::string refer_or_empty(const core::Node& node, const std::string& key, const std::string& kind);
  const std::string& place(const std::string& kind, const std::string& id) const;
};

Eigen::Vector3d point_mm(const core::Node& node, const std::string& key);
/// @throws InputError if the vector is zero
Eigen::Vector3d unit_vector(const core::Node& node, const std::string& key);
Uncertain scaled(Uncertain value, double factor);
/// @throws InputError with the reason if the key is present
void refuse(const core::Node& node, const std::string& key, const std::string& reason);

}  // namespace thermotwin::mesh::reader
