// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Systems as other programs give them, from their published definitions.

#include <Eigen/SparseCore>

#include <cmath>
#include <random>
#include <vector>

#include "reduction/systems/linear_system.h"

namespace thermotwin::reduction::test {

using Triplets = std::vector<Eigen::Triplet<double>>;

inline Sparse sparse(int rows, int columns, const Triplets& entries) {
  Sparse matrix(rows, columns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  matrix.makeCompressed();
  return matrix;
}

inline LinearSystem make_system(Sparse a, Eigen::MatrixXd b, Eigen::MatrixXd c, bool symmetric = false) {
  LinearSystem system;
  system.folder = "system";
  const auto n = a.rows();
  system.base.A = std::move(a);
  system.base.E = Sparse(n, n);
  system.base.E.setIdentity();
  system.base.identity = true;
  system.base.symmetric = symmetric;
  system.base.D = Eigen::MatrixXd::Zero(c.rows(), b.cols());
  system.base.B = std::move(b);
  system.base.C = std::move(c);
  return system;
}

/// T. Penzl's FOM: 1006 states, three lightly damped pairs and a diagonal.
inline LinearSystem penzl() {
  constexpr int n = 1006;
  Triplets a;
  const double frequency[] = {100, 200, 400};
  for (int k = 0; k < 3; ++k) {
    a.emplace_back(2 * k, 2 * k, -1.0);
    a.emplace_back(2 * k + 1, 2 * k + 1, -1.0);
    a.emplace_back(2 * k, 2 * k + 1, frequency[k]);
    a.emplace_back(2 * k + 1, 2 * k, -frequency[k]);
  }
  for (int k = 6; k < n; ++k) a.emplace_back(k, k, 5.0 - k);
  Eigen::MatrixXd b = Eigen::MatrixXd::Ones(n, 1);
  b.topRows(6).setConstant(10.0);
  return make_system(sparse(n, n, a), b, b.transpose());
}

/// Linear elements on a rod: E and A tridiagonal, heated at one end, with a film at the other.
inline LinearSystem rod(int n) {
  const double h = 1.0 / n;
  Triplets e, a;
  for (int k = 0; k < n; ++k) {
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        e.emplace_back(k + i, k + j, h / 6 * (i == j ? 2 : 1));
        a.emplace_back(k + i, k + j, (i == j ? -1 : 1) / h);
      }
    }
  }
  a.emplace_back(n, n, -1.0);
  Eigen::MatrixXd b = Eigen::MatrixXd::Zero(n + 1, 1), c = Eigen::MatrixXd::Zero(2, n + 1);
  b(0) = 1;
  c(0, 0) = c(1, n / 3) = 1;
  LinearSystem system = make_system(sparse(n + 1, n + 1, a), b, c, true);
  system.base.E = sparse(n + 1, n + 1, e);
  system.base.identity = false;
  return system;
}

/// Heat in a plate of (m+1) x (m+1) nodes of bilinear elements, convected along x with `speed` (then A
/// is not symmetric), films on all sides, `inputs` heated strips of the rim, three outputs.
inline LinearSystem plate(int m, int inputs, double speed = 0.0) {
  const int side = m + 1, n = side * side;
  const double h = 1.0 / m;
  const auto node = [side](int i, int j) { return i * side + j; };
  Triplets e, a;
  // Of a line element; the plate's are products.
  const double mass[2][2] = {{h / 3, h / 6}, {h / 6, h / 3}}, stiff[2][2] = {{1 / h, -1 / h}, {-1 / h, 1 / h}},
               along[2][2] = {{-0.5, 0.5}, {-0.5, 0.5}};
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j < m; ++j) {
      for (int p = 0; p < 4; ++p) {
        for (int q = 0; q < 4; ++q) {
          const int row = node(i + p / 2, j + p % 2), column = node(i + q / 2, j + q % 2);
          const auto product = [&](const double(&x)[2][2], const double(&y)[2][2]) {
            return x[p / 2][q / 2] * y[p % 2][q % 2];
          };
          e.emplace_back(row, column, product(mass, mass));
          a.emplace_back(row, column, -product(stiff, mass) - product(mass, stiff) - speed * product(along, mass));
        }
      }
    }
  }
  Eigen::MatrixXd b = Eigen::MatrixXd::Zero(n, inputs), c = Eigen::MatrixXd::Zero(3, n);
  for (int k = 0; k < m; ++k) {
    for (const bool first : {true, false}) {
      for (const auto& [low, high] : {std::pair(node(k, 0), node(k + 1, 0)), std::pair(node(k, m), node(k + 1, m)),
                                      std::pair(node(0, k), node(0, k + 1)), std::pair(node(m, k), node(m, k + 1))}) {
        // Out of the plate the stream carries heat too: the film keeps x^T A x < 0.
        a.emplace_back(first ? low : high, first ? low : high, -(1.0 + speed) * h / 2);
      }
      b(node(0, first ? k : k + 1), k * inputs / m) += h / 2;
    }
  }
  c(0, node(m, m / 2)) = c(1, node(m / 2, m / 2)) = c(2, node(m / 4, m / 3)) = 1.0;
  LinearSystem system = make_system(sparse(n, n, a), b, c, speed == 0.0);
  system.base.E = sparse(n, n, e);
  system.base.identity = false;
  return system;
}

/// Masses in a chain with proportional damping: x = (position, velocity), damping ratios about 1e-3 to 1e-2.
inline LinearSystem chain(int masses, bool with_masses) {
  Triplets e, a;
  for (int k = 0; k < masses; ++k) {
    const double stiffness = 1.0 + 0.1 * k, mass = with_masses ? 1.0 + 0.5 * (k % 3) : 1.0, damping = 2e-3;
    e.emplace_back(k, k, 1.0);
    e.emplace_back(masses + k, masses + k, mass);
    a.emplace_back(k, masses + k, 1.0);
    for (const int j : {k, k - 1}) {
      if (j < 0) continue;
      const double sign = j == k ? -1.0 : 1.0;
      a.emplace_back(masses + k, j, sign * stiffness);
      a.emplace_back(masses + k, masses + j, sign * stiffness * damping);
      if (j == k) continue;
      a.emplace_back(masses + j, k, stiffness);
      a.emplace_back(masses + j, masses + k, stiffness * damping);
      a.emplace_back(masses + j, j, -stiffness);
      a.emplace_back(masses + j, masses + j, -stiffness * damping);
    }
  }
  Eigen::MatrixXd b = Eigen::MatrixXd::Zero(2 * masses, 2), c = Eigen::MatrixXd::Zero(2, 2 * masses);
  b(masses, 0) = b(masses + masses / 2, 1) = 1.0;
  c(0, masses - 1) = c(1, masses / 3) = 1.0;
  LinearSystem system = make_system(sparse(2 * masses, 2 * masses, a), b, c);
  if (with_masses) {
    system.base.E = sparse(2 * masses, 2 * masses, e);
    system.base.identity = false;
  }
  return system;
}

/// A film on the last node of the rod beside the one that it has.
inline LinearSystem rod_with_film(int n) {
  LinearSystem system = rod(n);
  system.films.push_back({"end", sparse(n + 1, n + 1, {{n, n, -1.0}})});
  return system;
}

}  // namespace thermotwin::reduction::test
