// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reduced systems out of random numbers, with the time constants of a machine.

#include <Eigen/Dense>

#include <cmath>
#include <iterator>
#include <random>

#include "reduction/model/reduced_model.h"
#include "solver/operation/layout.h"

namespace thermotwin::test {

class Numbers {
public:
  explicit Numbers(unsigned seed) : engine_(seed) {}
  double operator()(double low = -1.0, double high = 1.0) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [this](Eigen::Index, Eigen::Index) { return (*this)(); });
  }

private:
  std::mt19937 engine_;
};

/// Time constants from a minute to a day; terms of low rank, one of them not symmetric.
inline reduction::ReducedSystem random_system(Eigen::Index order, Eigen::Index terms, Eigen::Index inputs,
                                              unsigned seed) {
  Numbers number(seed);
  reduction::ReducedSystem system;
  system.capacity = Eigen::MatrixXd::Identity(order, order);
  const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(number.matrix(order, order)).householderQ();
  const Eigen::VectorXd rates =
      Eigen::VectorXd::NullaryExpr(order, [&](Eigen::Index i) { return std::pow(10.0, -4.9 + 3.1 * i / order); });
  system.conduction = q * rates.asDiagonal() * q.transpose();
  for (Eigen::Index j = 0; j < terms; ++j) {
    const Eigen::MatrixXd b = number.matrix(order, 3);
    system.terms.push_back(b * b.transpose() * (1e-5 / order));
    system.layout.terms.push_back({solver::TermKind::film, static_cast<int>(j), 0});
  }
  const Eigen::MatrixXd skew = number.matrix(order, order) * 1e-5;
  system.terms.back() += skew - skew.transpose();
  system.inputs = number.matrix(order, inputs);
  system.layout.inputs.resize(inputs);
  system.sensors = number.matrix(3, order);
  system.one_kelvin = number.matrix(order, 1);
  return system;
}

inline solver::Coefficients random_coefficients(const reduction::ReducedSystem& system, unsigned seed) {
  Numbers number(seed);
  solver::Coefficients c;
  c.p = Eigen::VectorXd::NullaryExpr(std::ssize(system.terms), [&](Eigen::Index) { return number(0.5, 20.0); });
  c.q = Eigen::VectorXd::NullaryExpr(system.inputs.cols(), [&](Eigen::Index) { return number() * 1e-3; });
  return c;
}

inline Eigen::MatrixXd operator_of(const reduction::ReducedSystem& system, const solver::Coefficients& c) {
  Eigen::MatrixXd a = system.conduction;
  for (Eigen::Index j = 0; j < c.p.size(); ++j) a += c.p(j) * system.terms[j];
  return a;
}

/// E x' + A x = f from `start`, exactly: through the eigenvectors of E^-1 A.
inline Eigen::VectorXd exact(const reduction::ReducedSystem& system, const solver::Coefficients& c,
                             const Eigen::VectorXd& start, double time) {
  const Eigen::MatrixXd a = operator_of(system, c);
  const Eigen::VectorXd steady = a.partialPivLu().solve(system.inputs * c.q);
  const Eigen::EigenSolver<Eigen::MatrixXd> eigen(system.capacity.partialPivLu().solve(a));
  const Eigen::VectorXcd shares =
      eigen.eigenvectors().partialPivLu().solve((start - steady).cast<std::complex<double>>());
  const Eigen::VectorXcd decay = (-time * eigen.eigenvalues()).array().exp() * shares.array();
  return steady + (eigen.eigenvectors() * decay).real();
}

}  // namespace thermotwin::test
