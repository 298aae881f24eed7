// SPDX-License-Identifier: GPL-3.0-or-later
// Materials of machine.toml.

#include "mesh/machine/material_file.h"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

using core::InputError;
using core::Node;

namespace {

/// Three numbers: the diagonal; six: xx, yy, zz, xy, yz, zx.
Eigen::Matrix3d read_tensor(const Node& node, const std::string& key) {
  std::vector<double> v = node.numbers(key);
  if (v.size() == 3) v.resize(6, 0.0);
  const std::string allowed = "[xx, yy, zz] or [xx, yy, zz, xy, yz, zx], positive definite, main values up to 5000";
  if (v.size() != 6) throw InputError(node.place(key), fmt::format("{} numbers", v.size()), allowed);
  Eigen::Matrix3d tensor;
  tensor << v[0], v[3], v[5], v[3], v[1], v[4], v[5], v[4], v[2];
  const Eigen::Vector3d main = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tensor).eigenvalues();
  if (!(main[0] >= 1e-3 && main[2] <= 5000.0)) {
    throw InputError(node.place(key), fmt::format("main values {:.4g}, {:.4g}, {:.4g}", main[0], main[1], main[2]),
                     allowed);
  }
  return tensor;
}

/// { T_C = [rising], <unit> = [...] }
Curve read_temperature_table(const Node& node, const std::string& unit) {
  Curve table{node.numbers("T_C"), node.numbers(unit)};
  node.finish();
  if (table.at.empty() || table.at.size() != table.value.size()) {
    throw InputError(node.place(unit),
                     fmt::format("{} values for {} temperatures", table.value.size(), table.at.size()),
                     "as many numbers as in T_C, one or more");
  }
  for (std::size_t i = 0; i < table.at.size(); ++i) {
    if (i > 0 && !(table.at[i] > table.at[i - 1])) {
      throw InputError(node.place("T_C"), fmt::format("{} after {}", table.at[i], table.at[i - 1]),
                       "rising temperatures");
    }
  }
  return table;
}

}  // namespace

Material read_material(const Node& node, Draft& draft) {
  Material material;
  material.id = draft.define(node, "material");
  material.density = node.number("density_kg_m3");
  if (const auto table = node.table_if("specific_heat_table")) {
    refuse(node, "specific_heat_J_kgK", "either specific_heat_J_kgK or specific_heat_table");
    material.specific_heat_table = read_temperature_table(*table, "J_kgK");
    material.specific_heat.value = material.specific_heat_table(draft.machine.reference_C);
  } else {
    material.specific_heat = node.uncertain("specific_heat_J_kgK");
  }
  if (const auto table = node.table_if("conductivity_table")) {
    refuse(node, "conductivity_W_mK", "either conductivity_W_mK or conductivity_table");
    refuse(node, "conductivity_tensor_W_mK", "either conductivity_tensor_W_mK or conductivity_table");
    material.conductivity_table = read_temperature_table(*table, "W_mK");
    material.conductivity = material.conductivity_table(draft.machine.reference_C);
  } else if (node.has("conductivity_tensor_W_mK")) {
    refuse(node, "conductivity_W_mK", "either conductivity_W_mK or conductivity_tensor_W_mK");
    material.conductivity_tensor = read_tensor(node, "conductivity_tensor_W_mK");
    material.conductivity = material.conductivity_tensor->trace() / 3.0;
  } else {
    material.conductivity = node.number("conductivity_W_mK");
  }
  material.expansion = node.uncertain("expansion_1_K");
  material.young = node.number("young_GPa") * 1e9;
  material.poisson = node.number("poisson");
  node.finish();
  return material;
}

}  // namespace thermotwin::mesh::reader
