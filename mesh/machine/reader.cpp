// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/reader.h"

#include "core/unique_id.h"

namespace thermotwin::mesh::reader {

using core::InputError;
using core::Node;

std::string Draft::define(const Node& node, const std::string& kind) {
  std::string id = node.text("id");
  core::require_unique_id(id, node.place("id"), ids[kind]);
  places[kind + " " + id] = node.place();
  return id;
}

std::string Draft::refer(const Node& node, const std::string& key, const std::string& kind) {
  std::string id = node.text(key);
  references.push_back({kind, id, node.place(key)});
  return id;
}

std::string Draft::refer_or_empty(const Node& node, const std::string& key, const std::string& kind) {
  return node.has(key) ? refer(node, key, kind) : std::string();
}

const std::string& Draft::place(const std::string& kind, const std::string& id) const {
  return places.at(kind + " " + id);
}

Eigen::Vector3d point_mm(const Node& node, const std::string& key) { return node.vector3(key) * millimetre; }

Eigen::Vector3d unit_vector(const Node& node, const std::string& key) {
  const Eigen::Vector3d vector = node.vector3(key);
  const double length = vector.norm();
  if (!(length > 1e-12)) throw InputError(node.place(key), "a vector of length 0", "a direction, of any length");
  return vector / length;
}

Uncertain scaled(Uncertain value, double factor) {
  value.value *= factor;  // the spread is relative
  return value;
}

void refuse(const Node& node, const std::string& key, const std::string& reason) {
  if (node.has(key)) throw InputError(node.place(key), "key '" + key + "' has no meaning here", reason);
}

}  // namespace thermotwin::mesh::reader
