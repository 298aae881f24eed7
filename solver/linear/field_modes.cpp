// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/linear/field_modes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <algorithm>

#include "core/dense_algebra.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index block_size = 32;
constexpr Index spare = 8;  ///< modes kept beyond the rank while states still come

Index FieldModes::add(const Eigen::Ref<const Eigen::VectorXd>& state) {
  if (block_.size() == 0) block_.resize(state.size(), block_size);
  block_.col(pending_++) = state;
  if (pending_ == block_size) merge();
  return count_++;
}

void FieldModes::merge() {
  if (pending_ == 0) return;
  const MatrixXd block = block_.leftCols(pending_);
  const Index known = modes_.cols(), before = coefficients_.cols();
  MatrixXd seen(known, pending_), rest = block;
  if (known > 0) {
    seen = modes_.transpose() * block;
    rest -= modes_ * seen;
  }
  const Index fresh = std::min<Index>(pending_, rest.rows());
  const Eigen::HouseholderQR<MatrixXd> qr(rest);
  MatrixXd directions = qr.householderQ() * MatrixXd::Identity(rest.rows(), fresh);
  MatrixXd triangle = qr.matrixQR().topRows(fresh).triangularView<Eigen::Upper>();
  if (known > 0) {
    // A rest of rounding errors has directions that are not at right angles to the modes: once more.
    const MatrixXd leaning = modes_.transpose() * directions;
    seen += leaning * triangle;
    const Eigen::HouseholderQR<MatrixXd> again(directions - modes_ * leaning);
    directions = again.householderQ() * MatrixXd::Identity(rest.rows(), fresh);
    triangle = MatrixXd(again.matrixQR().topRows(fresh).triangularView<Eigen::Upper>()) * triangle;
  }
  MatrixXd wide(rest.rows(), known + fresh);
  if (known > 0) wide.leftCols(known) = modes_;
  wide.rightCols(fresh) = directions;
  MatrixXd small = MatrixXd::Zero(known + fresh, before + pending_);
  if (known > 0) {
    small.topLeftCorner(known, before) = coefficients_;
    small.topRightCorner(known, pending_) = seen;
  }
  small.bottomRightCorner(fresh, pending_) = triangle;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> square(MatrixXd(small * small.transpose()));
  const double largest = square.eigenvalues().maxCoeff();
  Index kept = 0;  // eigenvalues rise
  while (kept < std::min(rank_ + spare, known + fresh) &&
         square.eigenvalues()[known + fresh - 1 - kept] > 1e-14 * largest)
    ++kept;
  const MatrixXd turn = square.eigenvectors().rightCols(kept).rowwise().reverse();
  modes_ = wide * turn;
  coefficients_ = turn.transpose() * small;
  pending_ = 0;
}

FieldModes::Result FieldModes::take() {
  merge();
  const Index kept = std::min(rank_, modes_.cols());
  return {modes_.leftCols(kept), coefficients_.topRows(kept)};
}

}  // namespace thermotwin::solver
