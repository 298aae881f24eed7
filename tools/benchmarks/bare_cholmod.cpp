// SPDX-License-Identifier: GPL-3.0-or-later
// The alternative that tools/bench names "bare CHOLMOD": what one would write for one body in an
// afternoon, with nothing of thermotwin in it. Linear tetrahedra, one factorisation for all steps or
// loads, METIS on the graph of the nodes and its order applied to their degrees of freedom.
// usage: bench_cholmod FILE heat STEPS | FILE elastic       FILE as body_case.cpp writes it

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <suitesparse/cholmod.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "tools/benchmarks/stopwatch.h"

using thermotwin::bench::print;
using thermotwin::bench::Watch;
using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

namespace {

struct Triangle {
  int node[3];
  double film, ambient, flux;
};
struct Problem {
  double conductivity, density, heat_capacity, young, poisson, expansion, step;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 4>> tets;
  std::vector<Triangle> triangles;
  int fixed[6];
  std::vector<int> loaded;
};

Problem read(const char* name) {
  std::ifstream in(name);
  Problem p;
  std::size_t count = 0;
  in >> p.conductivity >> p.density >> p.heat_capacity >> p.young >> p.poisson >> p.expansion >> p.step >> count;
  p.points.resize(count);
  for (auto& x : p.points) in >> x[0] >> x[1] >> x[2];
  in >> count;
  p.tets.resize(count);
  for (auto& t : p.tets) in >> t[0] >> t[1] >> t[2] >> t[3];
  in >> count;
  p.triangles.resize(count);
  for (auto& t : p.triangles) in >> t.node[0] >> t.node[1] >> t.node[2] >> t.film >> t.ambient >> t.flux;
  for (int& dof : p.fixed) in >> dof;
  in >> count;
  p.loaded.resize(count);
  for (int& node : p.loaded) in >> node;
  if (!in) throw std::runtime_error(std::string(name) + " is no problem file");
  return p;
}

/// Gradients of the shape functions in the columns; @return the volume
double gradients(const Problem& p, const std::array<int, 4>& tet, Eigen::Matrix<double, 3, 4>& g) {
  Eigen::Matrix3d j;
  for (int i = 1; i < 4; ++i) j.col(i - 1) = p.points[tet[i]] - p.points[tet[0]];
  g.rightCols<3>() = j.inverse().transpose();
  g.col(0) = -g.rightCols<3>().rowwise().sum();
  return j.determinant() / 6.0;
}

Sparse matrix(Eigen::Index rows, Eigen::Index cols, const Triplets& entries) {
  Sparse m(rows, cols);
  m.setFromTriplets(entries.begin(), entries.end());
  return m;
}

class Factor {
public:
  Factor(const Sparse& a, int block) {
    cholmod_start(&common_);
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_GIVEN;
    common_.postorder = 1;
    cholmod_sparse view = look_at(a);
    // Pattern of the nodes: every block-th row and column.
    Triplets node_entries;
    for (Eigen::Index c = 0; c < a.cols(); c += block) {
      for (Sparse::InnerIterator it(a, c); it; ++it)
        if (it.row() % block == 0) node_entries.emplace_back(it.row() / block, c / block, 1.0);
    }
    const Sparse nodes = matrix(a.rows() / block, a.cols() / block, node_entries);
    cholmod_sparse node_view = look_at(nodes);
    std::vector<int> order(nodes.cols()), dofs;
    cholmod_metis(&node_view, nullptr, 0, 1, order.data(), &common_);
    for (const int node : order)
      for (int k = 0; k < block; ++k) dofs.push_back(node * block + k);
    factor_ = cholmod_analyze_p(&view, dofs.data(), nullptr, 0, &common_);
    cholmod_factorize(&view, factor_, &common_);
    if (common_.status != CHOLMOD_OK) throw std::runtime_error("not positive definite");
  }
  ~Factor() {
    cholmod_free_dense(&x_, &common_);
    cholmod_free_dense(&y_, &common_);
    cholmod_free_dense(&e_, &common_);
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  Factor(const Factor&) = delete;
  Factor& operator=(const Factor&) = delete;
  double nonzeros() const { return common_.lnz; }

  Eigen::Map<const Eigen::MatrixXd> solve(const Eigen::MatrixXd& b) {
    cholmod_dense rhs{};
    rhs.nrow = rhs.d = b.rows();
    rhs.ncol = b.cols();
    rhs.nzmax = rhs.nrow * rhs.ncol;
    rhs.x = const_cast<double*>(b.data());
    rhs.xtype = CHOLMOD_REAL;
    cholmod_solve2(CHOLMOD_A, factor_, &rhs, nullptr, &x_, nullptr, &y_, &e_, &common_);
    return {static_cast<const double*>(x_->x), b.rows(), b.cols()};
  }

private:
  static cholmod_sparse look_at(const Sparse& a) {
    cholmod_sparse view{};
    view.nrow = a.rows();
    view.ncol = a.cols();
    view.nzmax = a.nonZeros();
    view.p = const_cast<int*>(a.outerIndexPtr());
    view.i = const_cast<int*>(a.innerIndexPtr());
    view.x = const_cast<double*>(a.valuePtr());
    view.stype = -1;
    view.xtype = CHOLMOD_REAL;
    view.sorted = view.packed = 1;
    return view;
  }
  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense *x_ = nullptr, *y_ = nullptr, *e_ = nullptr;
};

void heat(const Problem& p, int steps) {
  Watch time;
  const auto n = std::ssize(p.points);
  Triplets capacity, conduction;
  Eigen::VectorXd source = Eigen::VectorXd::Zero(n);
  Eigen::Matrix<double, 3, 4> g;
  for (const auto& tet : p.tets) {
    const double volume = gradients(p, tet, g);
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 4; ++k) {
        const int row = tet[i], column = tet[k];
        capacity.emplace_back(row, column, p.density * p.heat_capacity * volume * (i == k ? 0.1 : 0.05));
        conduction.emplace_back(row, column, p.conductivity * volume * g.col(i).dot(g.col(k)));
      }
    }
  }
  for (const Triangle& t : p.triangles) {
    const Eigen::Vector3d a = p.points[t.node[0]];
    const double area = 0.5 * (p.points[t.node[1]] - a).cross(p.points[t.node[2]] - a).norm();
    for (int i = 0; i < 3; ++i) {
      source[t.node[i]] += area / 3.0 * (t.flux + t.film * t.ambient);
      for (int k = 0; k < 3; ++k)
        conduction.emplace_back(t.node[i], t.node[k], t.film * area / 12.0 * (i == k ? 2.0 : 1.0));
    }
  }
  const Sparse e = matrix(n, n, capacity), k = matrix(n, n, conduction);
  print("assembly", time.seconds());
  // SDIRK2 (Alexander 1977): both stages solve with E/(gamma h) + K.
  time.restart();
  const double gamma = 1.0 - std::sqrt(0.5), shift = 1.0 / (gamma * p.step), a = (1.0 - gamma) / gamma;
  Factor factor(shift * e + k, 1);
  print("factor", time.seconds());
  Eigen::VectorXd temperature = Eigen::VectorXd::Zero(n);
  std::vector<double> each;
  for (int i = 0; i < steps; ++i) {
    time.restart();
    const Eigen::VectorXd imbalance = source - k * temperature;
    const Eigen::VectorXd first = factor.solve(imbalance);
    const Eigen::VectorXd second = factor.solve(imbalance - a * (k * first));
    temperature += a * first + second;
    each.push_back(time.seconds());
  }
  std::nth_element(each.begin(), each.begin() + steps / 2, each.end());
  print("step", each[steps / 2]);
  print("largest_K", temperature.maxCoeff());
  print("mean_K", temperature.mean());
}

void elastic(const Problem& p) {
  Watch time;
  const auto n = std::ssize(p.points);
  const double lambda = p.young * p.poisson / ((1 + p.poisson) * (1 - 2 * p.poisson)),
               mu = p.young / (2 * (1 + p.poisson));
  std::vector<char> held(3 * n, 0);
  for (const int dof : p.fixed) held[dof] = 1;
  Triplets stiffness, load;
  Eigen::Matrix<double, 3, 4> g;
  for (const auto& tet : p.tets) {
    const double volume = gradients(p, tet, g);
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 4; ++k) {
        const Eigen::Vector3d gi = g.col(i), gk = g.col(k);
        const Eigen::Matrix3d block = volume * (lambda * gi * gk.transpose() + mu * gk * gi.transpose() +
                                                mu * gi.dot(gk) * Eigen::Matrix3d::Identity());
        const int row = 3 * tet[i], column = 3 * tet[k];
        for (int r = 0; r < 3; ++r) {
          load.emplace_back(row + r, column / 3, 0.25 * volume * p.young * p.expansion / (1 - 2 * p.poisson) * gi[r]);
          for (int c = 0; c < 3; ++c) {
            const bool free = held[row + r] == 0 && held[column + c] == 0;
            stiffness.emplace_back(row + r, column + c,
                                   free                    ? block(r, c)
                                   : row + r == column + c ? std::abs(block(r, c))
                                                           : 0.0);
          }
        }
      }
    }
  }
  const Sparse k = matrix(3 * n, 3 * n, stiffness), f = matrix(3 * n, n, load);
  print("assembly", time.seconds());
  time.restart();
  Factor factor(k, 3);
  print("factor", time.seconds());
  print("factor_nonzeros", factor.nonzeros());
  time.restart();
  Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(3 * n, 3 * std::ssize(p.loaded));
  for (std::size_t i = 0; i < p.loaded.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const int dof = 3 * p.loaded[i] + c;
      if (held[dof] == 0) forces(dof, 3 * i + c) = 1.0;
    }
  }
  const Eigen::MatrixXd rows = f.transpose() * factor.solve(forces);
  print("rows", time.seconds());
  print("rows_norm", rows.norm());
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 2 ? argv[2] : "";
  if (!(what == "elastic" && argc == 3) && !(what == "heat" && argc == 4)) {
    std::cerr << "usage: bench_cholmod FILE heat STEPS | FILE elastic\n";
    return 2;
  }
  try {
    const Problem problem = read(argv[1]);
    if (what == "heat") {
      heat(problem, std::max(2, std::atoi(argv[3])));
    } else {
      elastic(problem);
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 4;
  }
  return 0;
}
