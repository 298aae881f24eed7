// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/element_matrix.h"

#include <algorithm>
#include <iterator>

namespace thermotwin::solver {

ElementMatrix::ElementMatrix(const mesh::TetMesh& mesh, int row_block, int column_block)
    : row_block_(row_block),
      column_block_(column_block) {
  const std::size_t nodes = mesh.nodes();
  std::vector<int> start(nodes + 1, 0), elements;
  for (Eigen::Index e = 0; e < mesh.elements(); ++e)
    for (const int node : mesh::tet_nodes(mesh, e)) ++start[node + 1];
  for (std::size_t i = 0; i < nodes; ++i) start[i + 1] += start[i];
  elements.resize(start.back());
  std::vector<int> next = start;
  for (int e = 0; e < mesh.elements(); ++e)
    for (const int node : mesh::tet_nodes(mesh, e)) elements[next[node]++] = e;

  first_.push_back(0);
  std::vector<int> row;
  for (std::size_t i = 0; i < nodes; ++i) {
    row.clear();
    for (int k = start[i]; k < start[i + 1]; ++k)
      for (const int node : mesh::tet_nodes(mesh, elements[k])) row.push_back(node);
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    neighbour_.insert(neighbour_.end(), row.begin(), row.end());
    first_.push_back(neighbour_.size());
  }
  values_.assign(neighbour_.size() * row_block * column_block, 0.0);
}

void ElementMatrix::add(const mesh::TetNodes& nodes, const Eigen::MatrixXd& values) {
  const Eigen::Index rows = row_block_, columns = column_block_;
  for (Eigen::Index b = 0; b < nodes.size(); ++b) {
    const Eigen::Index before = first_[nodes[b]], count = first_[nodes[b] + 1] - before;
    const int* neighbour = neighbour_.data() + before;
    for (Eigen::Index a = 0; a < nodes.size(); ++a) {
      // Counted, not searched: so few are compared faster than a branch is foretold.
      int place = 0;
      for (Eigen::Index k = 0; k < count; ++k) place += neighbour[k] < nodes[a] ? 1 : 0;
      for (Eigen::Index j = 0; j < columns; ++j) {
        for (Eigen::Index i = 0; i < rows; ++i)
          values_[rows * (columns * before + j * count + place) + i] += values(rows * a + i, columns * b + j);
      }
    }
  }
}

SparseMatrix ElementMatrix::take() {
  const auto nodes = std::ssize(first_) - 1;
  std::vector<int> outer{0}, inner;
  outer.reserve(column_block_ * nodes + 1);
  inner.reserve(values_.size());
  for (std::size_t node = 0; node + 1 < first_.size(); ++node) {
    for (int j = 0; j < column_block_; ++j) {
      for (int k = first_[node]; k < first_[node + 1]; ++k)
        for (int i = 0; i < row_block_; ++i) inner.push_back(row_block_ * neighbour_[k] + i);
      outer.push_back(inner.size());
    }
  }
  SparseMatrix matrix = Eigen::Map<const SparseMatrix>(row_block_ * nodes, column_block_ * nodes, std::ssize(inner),
                                                       outer.data(), inner.data(), values_.data());
  values_.clear();
  return matrix;
}

}  // namespace thermotwin::solver
