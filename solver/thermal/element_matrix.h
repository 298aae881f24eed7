// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Sparse matrix of one body that is summed up from its elements. The pattern, all pairs of nodes
// of an element, is made first and the values are added in place: a quadratic mesh would need
// several times the matrix in triplets.

#include <Eigen/SparseCore>

#include <vector>

#include "mesh/body/shape.h"

namespace thermotwin::solver {

using SparseMatrix = Eigen::SparseMatrix<double>;  ///< column major, both triangles stored

class ElementMatrix {
public:
  /// @param row_block, column_block  unknowns a node, numbered block * node + i
  explicit ElementMatrix(const mesh::TetMesh& mesh, int row_block = 1, int column_block = 1);

  /// Adds a matrix of one element of the mesh. @param nodes  of the element
  /// @param values (row_block * n x column_block * n), unknowns block * place of the node + i
  void add(const mesh::TetNodes& nodes, const Eigen::MatrixXd& values);

  SparseMatrix take();

private:
  int row_block_, column_block_;
  std::vector<int> first_, neighbour_;  ///< nodes that share an element with node i, rising
  std::vector<double> values_;
};

}  // namespace thermotwin::solver
