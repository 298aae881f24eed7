// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/rational_krylov.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/progress.h"
#include "core/thread_pool.h"
#include "reduction/linear/orthonormal.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

/// Shifts, closed under conjugation, with a direction of the inputs and of the outputs each.
struct Points {
  VectorXcd shifts;
  MatrixXcd inputs, outputs;  ///< columns
};

struct Small {
  MatrixXd A, B, C;
};

/// Columns of the real span of columns that belong to shifts; of conjugates only one is kept.
MatrixXd real_span(const Points& points, const MatrixXcd& columns) {
  std::vector<Eigen::VectorXd> real_columns;
  for (Index k = 0; k < columns.cols(); ++k) {
    if (points.shifts(k).imag() < 0.0) continue;
    real_columns.push_back(columns.col(k).real());
    if (points.shifts(k).imag() > 0.0) real_columns.push_back(columns.col(k).imag());
  }
  MatrixXd span(columns.rows(), std::ssize(real_columns));
  for (std::size_t k = 0; k < real_columns.size(); ++k) span.col(k) = real_columns[k].normalized();
  return span;
}

struct Spans {
  MatrixXd right, left;
};

Spans spans_at(const Points& points, const StateSpace& system, const SystemSolver& solver) {
  const Index n = system.size(), count = points.shifts.size();
  MatrixXcd right = MatrixXcd::Zero(n, count), left = MatrixXcd::Zero(n, count);
  core::parallel_for(0, count, [&](std::size_t i) {
    core::check_interrupt();
    const Index k = i;
    if (points.shifts(k).imag() < 0.0) return;
    const auto both =
        solver.solve(points.shifts(k), system.B * points.inputs.col(k), system.C.transpose() * points.outputs.col(k));
    right.col(k) = both.right;
    left.col(k) = both.left;
  });
  return {real_span(points, right), real_span(points, left)};
}

Spans spans_at(const Points& points, const Small& system) {
  const Index n = system.A.rows(), count = points.shifts.size();
  MatrixXcd right = MatrixXcd::Zero(n, count), left = MatrixXcd::Zero(n, count);
  core::parallel_for(0, count, [&](std::size_t i) {
    const Index k = i;
    if (points.shifts(k).imag() < 0.0) return;
    MatrixXcd matrix = -system.A.cast<Complex>();
    matrix.diagonal().array() += points.shifts(k);
    const Eigen::PartialPivLU<MatrixXcd> lu(matrix);
    right.col(k) = lu.solve(system.B * points.inputs.col(k));
    left.col(k) = lu.transpose().solve(system.C.transpose() * points.outputs.col(k));
  });
  return {real_span(points, right), real_span(points, left)};
}

/// Spans of equal width, the smaller one's.
void make_orthonormal(Spans& spans) {
  constexpr double independent = 1e-12;
  spans.right = orthonormal(spans.right, independent);
  spans.left = orthonormal(spans.left, independent);
  const Index width = std::min(spans.right.cols(), spans.left.cols());
  spans.right.conservativeResize(Eigen::NoChange, width);
  spans.left.conservativeResize(Eigen::NoChange, width);
}

template <class E, class A>
Small projected(const Spans& spans, const E& e, const A& a, const MatrixXd& b, const MatrixXd& c) {
  const Eigen::PartialPivLU<MatrixXd> metric(spans.left.transpose() * (e * spans.right));
  return {metric.solve(spans.left.transpose() * (a * spans.right)), metric.solve(spans.left.transpose() * b),
          c * spans.right};
}

/// Mirrored poles and residues' directions of a small system.
Points points_of(const Small& system) {
  const Eigen::EigenSolver<MatrixXd> poles(system.A);
  Points points;
  points.inputs = poles.eigenvectors().partialPivLu().solve(system.B.cast<Complex>()).transpose();
  points.outputs = system.C * poles.eigenvectors();
  // A pole on the wrong side is mirrored too: the next model is drawn to the stable side.
  points.shifts = poles.eigenvalues().unaryExpr(
      [](Complex pole) { return Complex(std::max(std::abs(pole.real()), 1e-10 * std::abs(pole)), -pole.imag()); });
  for (Index k = 0; k < points.shifts.size(); ++k) {
    const auto unit = [](auto&& column) {
      if (const double length = column.norm(); length > 0.0) column /= length;
    };
    unit(points.inputs.col(k));
    unit(points.outputs.col(k));
  }
  return points;
}

/// Shifts over the band, inputs and outputs in turn.
Points starting_points(const StateSpace& system, Band band, Index count) {
  Points points{VectorXcd(count), MatrixXcd::Zero(system.inputs(), count), MatrixXcd::Zero(system.outputs(), count)};
  for (Index k = 0; k < count; ++k) {
    points.shifts(k) = band.low * std::pow(band.high / band.low, count > 1 ? 1.0 * k / (count - 1) : 0.0);
    points.inputs(k % system.inputs(), k) = 1.0;
    points.outputs(k % system.outputs(), k) = 1.0;
  }
  return points;
}

/// The least damped of known frequencies, where shifts on the real axis see little.
void add_peaks(Points& points, const std::vector<double>& peaks, Index count) {
  const Index pairs = std::min<Index>(std::ssize(peaks), count), before = points.shifts.size();
  points.shifts.conservativeResize(before + pairs);
  points.inputs.conservativeResize(Eigen::NoChange, before + pairs);
  points.outputs.conservativeResize(Eigen::NoChange, before + pairs);
  for (Index k = 0; k < pairs; ++k) {
    const double w = peaks[k * std::ssize(peaks) / pairs];
    points.shifts(before + k) = Complex(0.05 * w, w);
    points.inputs.col(before + k).setZero();
    points.outputs.col(before + k).setZero();
    points.inputs(k % points.inputs.rows(), before + k) = 1.0;
    points.outputs(k % points.outputs.rows(), before + k) = 1.0;
  }
}

/// Largest relative distance of a shift to the nearest one of before.
double change(const VectorXcd& now, const VectorXcd& before) {
  double largest = 0;
  for (const Complex& a : now) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Complex& b : before) nearest = std::min(nearest, std::abs(a - b) / std::abs(a));
    largest = std::max(largest, nearest);
  }
  return largest;
}

/// The iteration on a small system.
Points settled(const Small& system, Points points) {
  constexpr int most = 60;
  constexpr double stays = 1e-5;
  for (int k = 0; k < most; ++k) {
    Spans spans = spans_at(points, system);
    make_orthonormal(spans);
    Points next =
        points_of(projected(spans, MatrixXd::Identity(system.A.rows(), system.A.rows()), system.A, system.B, system.C));
    const double moved = change(next.shifts, points.shifts);
    points = std::move(next);
    if (moved < stays) break;
  }
  return points;
}

void append(Spans& spans, const Spans& more) {
  const auto side_by_side = [](MatrixXd& a, const MatrixXd& b) {
    MatrixXd both(b.rows(), a.cols() + b.cols());
    both << a, b;
    a = std::move(both);
  };
  side_by_side(spans.right, more.right);
  side_by_side(spans.left, more.left);
}

}  // namespace

KrylovBases rational_krylov(const StateSpace& system, const SystemSolver& solver, Index order) {
  constexpr int most_rounds = 8;
  constexpr double stays = 1e-3;
  constexpr Index widest = 600;
  Points start = starting_points(system, solver.band(), std::min(order + order / 2 + 2, system.size()));
  add_peaks(start, solver.peaks(), (order + 1) / 2);
  Spans wide = spans_at(start, system, solver);
  KrylovBases result;
  Points points;
  Spans at_points;
  for (int round = 0; round < most_rounds; ++round) {
    make_orthonormal(wide);
    const Small small = projected(wide, system.E, system.A, system.B, system.C);
    // Begin with the dominant poles of what is known so far.
    if (round == 0) {
      points = points_of(small);
      const Eigen::EigenSolver<MatrixXd> poles(small.A);
      const MatrixXcd b = poles.eigenvectors().partialPivLu().solve(small.B.cast<Complex>()),
                      c = small.C * poles.eigenvectors();
      const Eigen::VectorXd dominance =
          c.colwise().norm().transpose().array() * b.rowwise().norm().array() / points.shifts.real().array();
      std::vector<Index> chosen = by_dominance(points.shifts, dominance, order);
      points = {points.shifts(chosen), points.inputs(Eigen::all, chosen), points.outputs(Eigen::all, chosen)};
    }
    const VectorXcd before = points.shifts;
    points = settled(small, std::move(points));
    at_points = spans_at(points, system, solver);
    result.converged = round > 0 && change(points.shifts, before) < stays;
    if (result.converged || wide.right.cols() + at_points.right.cols() > std::min(widest, system.size())) break;
    append(wide, at_points);
  }
  make_orthonormal(at_points);
  result.right = std::move(at_points.right);
  result.left = std::move(at_points.left);
  return result;
}

}  // namespace thermotwin::reduction
