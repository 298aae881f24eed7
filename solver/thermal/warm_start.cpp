// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/warm_start.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/thread_pool.h"

namespace thermotwin::solver {

using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double smallest_share = 1e-20;   // of |r|^2: a smaller |A z|^2 is rounding
constexpr double smallest_pivot = 1e-12;   // of a scaled product: the solution is a combination of the others
constexpr Index rows_at_once = 128;        // stay in the nearest cache while all solutions pass
constexpr std::size_t rows_a_part = 4096;  // of sums

/// @return (loads x blocks) inner products of each column of a with those of the blocks
ArrayXXd products_with(const SideBySide& a, const std::vector<const SideBySide*>& blocks) {
  const Index stride = a.cols(), count = std::ssize(blocks);
  const ArrayXXd none = ArrayXXd::Zero(stride, count);
  return core::parallel_reduce<ArrayXXd>(
      0, a.rows(), rows_a_part, none,
      [&](std::size_t first, std::size_t last) {
        ArrayXXd sum = none;
        for (Index from = first; from < static_cast<Index>(last); from += rows_at_once) {
          const Index to = std::min<Index>(last, from + rows_at_once);
          for (Index j = 0; j < count; ++j) {
            const double *x = a.data(), *y = blocks[j]->data();
            over_columns(stride, [&](auto width, Index begin) {
              double part[decltype(width)::value] = {};
              for (Index i = from; i < to; ++i)
                for (int k = 0; k < width; ++k) part[k] += x[i * stride + begin + k] * y[i * stride + begin + k];
              for (int k = 0; k < width; ++k) sum(begin + k, j) += part[k];
            });
          }
        }
        return sum;
      },
      [](ArrayXXd left, const ArrayXXd& right) -> ArrayXXd { return left += right; });
}

/// x of G x = t by Cholesky's factor of the scaled G; 0 for what the solutions before it tell already.
VectorXd solve_normal(const MatrixXd& g, const VectorXd& t, double least_square) {
  const Index n = t.size();
  VectorXd scale(n);
  for (Index i = 0; i < n; ++i) scale[i] = g(i, i) > least_square ? 1.0 / std::sqrt(g(i, i)) : 0.0;
  MatrixXd factor = MatrixXd::Zero(n, n);
  VectorXd y = VectorXd::Zero(n);
  for (Index i = 0; i < n; ++i) {
    if (scale[i] == 0.0) continue;
    for (Index k = 0; k < i; ++k) {
      if (factor(k, k) == 0.0) continue;
      factor(i, k) = (g(i, k) * scale[i] * scale[k] - factor.row(i).head(k).dot(factor.row(k).head(k))) / factor(k, k);
    }
    const double pivot = 1.0 - factor.row(i).head(i).squaredNorm();
    if (!(pivot > smallest_pivot)) {
      factor.row(i).setZero();
      continue;
    }
    factor(i, i) = std::sqrt(pivot);
    y[i] = (t[i] * scale[i] - factor.row(i).head(i).dot(y.head(i))) / factor(i, i);
  }
  VectorXd x = VectorXd::Zero(n);
  for (Index i = n - 1; i >= 0; --i)
    if (factor(i, i) != 0.0) x[i] = (y[i] - factor.col(i).tail(n - 1 - i).dot(x.tail(n - 1 - i))) / factor(i, i);
  return x.cwiseProduct(scale);
}

}  // namespace

bool WarmStart::guess(SideBySide& d, SideBySide& r) {
  if (most_ == 0) return false;
  if (count_ > 0 && (earlier_.front().z.cols() != r.cols() || earlier_.front().z.rows() != r.rows())) clear();
  std::vector<const SideBySide*> blocks;
  for (Index j = 0; j < count_; ++j) blocks.push_back(&earlier_[j].az);
  blocks.push_back(&r);
  const ArrayXXd along = products_with(r, blocks);
  squares_ = along.col(count_).matrix();
  if (count_ == 0 || count_ == most_) given_ = r;
  if (count_ == 0) return false;
  const Index stride = r.cols(), solutions = count_;
  SideBySide factors(solutions, stride);
  for (Index l = 0; l < stride; ++l) {
    factors.col(l) = solve_normal(products_[l].topLeftCorner(solutions, solutions),
                                  along.row(l).head(solutions).matrix().transpose(), smallest_share * squares_[l]);
  }
  guessed_.resize(r.rows(), stride);
  left_.resize(r.rows(), stride);
  over_rows(
      r.rows(),
      [&](Index first, Index last) {
        for (Index j = 0; j < solutions; ++j) {
          const double *z = earlier_[j].z.data(), *az = earlier_[j].az.data();
          over_columns(stride, [&](auto width, Index begin) {
            double factor[decltype(width)::value];
            for (int k = 0; k < width; ++k) factor[k] = factors(j, begin + k);
            for (Index i = first; i < last; ++i) {
              double *to = d.data() + i * stride + begin, *rest = r.data() + i * stride + begin;
              for (int k = 0; k < width; ++k) {
                to[k] += factor[k] * z[i * stride + begin + k];
                rest[k] -= factor[k] * az[i * stride + begin + k];
              }
            }
          });
        }
        guessed_.middleRows(first, last - first) = d.middleRows(first, last - first);
        left_.middleRows(first, last - first) = r.middleRows(first, last - first);
      },
      rows_at_once);
  return true;
}

void WarmStart::remember(const SideBySide& d, const SideBySide& r) {
  if (most_ == 0) return;
  const bool whole = count_ == 0 || count_ == most_;
  if (whole) clear();
  if (std::ssize(earlier_) <= count_) earlier_.resize(count_ + 1);
  Earlier& fresh = earlier_[count_];
  fresh.z.resize(d.rows(), d.cols());
  fresh.az.resize(r.rows(), r.cols());
  const SideBySide& before = whole ? given_ : left_;
  over_rows(d.rows(), [&](Index first, Index last) {
    const Index rows = last - first;
    if (whole)
      fresh.z.middleRows(first, rows) = d.middleRows(first, rows);
    else
      fresh.z.middleRows(first, rows) = d.middleRows(first, rows) - guessed_.middleRows(first, rows);
    fresh.az.middleRows(first, rows) = before.middleRows(first, rows) - r.middleRows(first, rows);
  });
  ++count_;
  complete_products();
}

void WarmStart::complete_products() {
  const Index last = count_ - 1, loads = earlier_[last].az.cols();
  std::vector<const SideBySide*> blocks;
  for (Index j = 0; j < count_; ++j) blocks.push_back(&earlier_[j].az);
  const ArrayXXd of = products_with(earlier_[last].az, blocks);
  products_.resize(loads);
  for (Index l = 0; l < loads; ++l) {
    if (products_[l].rows() != most_) products_[l].setZero(most_, most_);
    products_[l].row(last).head(count_) = of.row(l).matrix();
    products_[l].col(last).head(count_) = of.row(l).matrix().transpose();
  }
}

void WarmStart::save(core::BinaryWriter& out) const {
  out.count(count_);
  for (Index j = 0; j < count_; ++j) {
    out.matrix(earlier_[j].z);
    out.matrix(earlier_[j].az);
  }
  for (const MatrixXd& of : products_)
    if (count_ > 0) out.matrix(of);
}

void WarmStart::load(core::BinaryReader& in) {
  count_ = in.count();
  earlier_.resize(std::max<std::size_t>(earlier_.size(), count_));
  for (Index j = 0; j < count_; ++j) {
    earlier_[j].z = in.matrix();
    earlier_[j].az = in.matrix();
  }
  products_.resize(count_ > 0 ? earlier_.front().z.cols() : 0);
  for (MatrixXd& of : products_) of = in.matrix();
}

}  // namespace thermotwin::solver
