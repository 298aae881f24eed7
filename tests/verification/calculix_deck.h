// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Decks for CalculiX (ccx) of one body, and the tables of its .dat file: steady heat and static
// thermo-elasticity with linear or quadratic tetrahedra (C3D4, C3D10).

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "mesh/machine.h"
#include "mesh/shape.h"

namespace thermotwin::test {

inline bool have_ccx() { return std::system("command -v ccx > /dev/null 2>&1") == 0; }

/// Face number of ccx (F1: nodes 1 2 3, F2: 1 4 2, F3: 2 4 3, F4: 3 4 1) of a boundary triangle.
inline int ccx_face(const mesh::TetMesh& mesh, int face) {
  const int element = mesh.face_tet[face];
  for (int i = 0; i < 4; ++i) {
    const int node = mesh.tets(i, element);
    if (node == mesh.faces(0, face) || node == mesh.faces(1, face) || node == mesh.faces(2, face)) continue;
    constexpr int opposite[4] = {3, 4, 2, 1};  // of node 1, 2, 3, 4
    return opposite[i];
  }
  return 0;
}

inline std::string ccx_model(const mesh::TetMesh& mesh, const mesh::Material& material, double reference_C) {
  std::string text = "*NODE, NSET=NALL\n";
  for (Eigen::Index i = 0; i < mesh.nodes(); ++i)
    text += fmt::format("{}, {:.12e}, {:.12e}, {:.12e}\n", i + 1, mesh.points(0, i), mesh.points(1, i), mesh.points(2, i));
  text += fmt::format("*ELEMENT, TYPE={}, ELSET=EALL\n", mesh.order() == 2 ? "C3D10" : "C3D4");
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    text += fmt::format("{}", e + 1);
    for (const int node : mesh::tet_nodes(mesh, e)) text += fmt::format(", {}", node + 1);
    text += "\n";
  }
  text += "*MATERIAL, NAME=M\n";
  text += fmt::format("*ELASTIC\n{:.9e}, {:.9e}\n", material.young, material.poisson);
  text += fmt::format("*EXPANSION, ZERO={:.6f}\n{:.9e}\n", reference_C, material.expansion.value);
  text += fmt::format("*CONDUCTIVITY\n{:.9e}\n", material.conductivity);
  text += fmt::format("*DENSITY\n{:.9e}\n*SPECIFIC HEAT\n{:.9e}\n", material.density, material.specific_heat.value);
  text += "*SOLID SECTION, ELSET=EALL, MATERIAL=M\n";
  return text + fmt::format("*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNALL, {:.6f}\n", reference_C);
}

/// Runs folder/name.inp; @return rows of the numbers in folder/name.dat, by node (components x nodes)
inline Eigen::MatrixXd run_ccx(const std::string& folder, const std::string& name, const std::string& deck,
                               Eigen::Index nodes, int components) {
  std::ofstream(folder + "/" + name + ".inp") << deck;
  const std::string command = "cd '" + folder + "' && OMP_NUM_THREADS=1 ccx " + name + " > " + name + ".log 2>&1";
  Eigen::MatrixXd result(components, 0);
  if (std::system(command.c_str()) != 0) return result;
  std::ifstream file(folder + "/" + name + ".dat");
  result = Eigen::MatrixXd::Constant(components, nodes, std::nan(""));
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    long node = 0;
    Eigen::VectorXd values(components);
    if (!(words >> node) || node < 1 || node > nodes) continue;
    bool complete = true;
    for (int i = 0; i < components; ++i) complete = complete && static_cast<bool>(words >> values[i]);
    if (complete) result.col(node - 1) = values;
  }
  return result;
}

}  // namespace thermotwin::test
