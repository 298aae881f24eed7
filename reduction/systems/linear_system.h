// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Systems of other programs, E x' = (A + sum_j p_j A_film_j) x + B u, y = C x + D u, from a folder of
// Matrix Market files E.mtx (absent: identity), A.mtx, B.mtx, C.mtx, D.mtx (absent: none) and any
// A_film_NAME.mtx. Units are those of the writer. A names.toml in the folder, as
// `export --matrices` writes it, names inputs and outputs and states the values of the films.

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <filesystem>
#include <string>
#include <vector>

namespace thermotwin::reduction {

using Sparse = Eigen::SparseMatrix<double>;

/// One system with numbers for all parameters.
struct StateSpace {
  Sparse E, A;              ///< (n x n)
  Eigen::MatrixXd B, C, D;  ///< (n x inputs), (outputs x n), (outputs x inputs)
  bool identity = false;    ///< E is the identity
  bool symmetric = false;   ///< E and A are symmetric to rounding; stored exactly symmetric

  Eigen::Index size() const { return A.rows(); }
  Eigen::Index inputs() const { return B.cols(); }
  Eigen::Index outputs() const { return C.rows(); }
};

struct ParameterMatrix {
  std::string name;  ///< NAME of A_film_NAME.mtx
  Sparse matrix;
  double value = 1.0;  ///< default of its parameter
};

struct LinearSystem {
  std::filesystem::path folder;
  StateSpace base;                                     ///< without the films
  std::vector<ParameterMatrix> films;                  ///< by name
  bool has_feedthrough = false;                        ///< D.mtx is there
  std::vector<std::string> input_names, output_names;  ///< empty: none were given
  std::string names_text;                              ///< names.toml as it is; empty: there is none

  /// @param values  one per film
  StateSpace at(const std::vector<double>& values) const;
};

/// @throws InputError: missing or bad file, sizes that disagree, B or C without an entry, entries beyond 1e100
LinearSystem read_linear_system(const std::filesystem::path& folder);

/// The reduced system, of the same form. E is the identity in the results of reduce_system() and Identification.
struct ReducedLinearSystem {
  Eigen::MatrixXd E, A, B, C, D;
  std::vector<Eigen::MatrixXd> films;  ///< in the order of LinearSystem::films

  Eigen::Index order() const { return A.rows(); }
  /// With A + sum p_j A_film_j as its A.
  ReducedLinearSystem at(const std::vector<double>& values) const;
};

/// Projection: W^T E V, W^T A V, W^T A_film_j V, W^T B, C V. @param left,right  (n x r) W and V
ReducedLinearSystem project(const LinearSystem& system, const Eigen::MatrixXd& left, const Eigen::MatrixXd& right);

}  // namespace thermotwin::reduction
