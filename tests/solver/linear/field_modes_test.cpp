// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/linear/field_modes.h"

#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "solver/campaign/load_fields.h"

namespace thermotwin::solver {
namespace {

using Eigen::MatrixXd;

/// Fields whose singular values fall by ten.
MatrixXd falling(Eigen::Index size, Eigen::Index count) {
  std::srand(3);
  MatrixXd sum = MatrixXd::Zero(size, count);
  double scale = 100.0;
  for (int k = 0; k < 9; ++k, scale /= 10.0)
    sum += scale * Eigen::VectorXd::Random(size).normalized() * Eigen::VectorXd::Random(count).normalized().transpose();
  return sum;
}

TEST(FieldModes, AreAsGoodAsTheDecompositionOfAllFieldsAtOnce) {
  const MatrixXd fields = falling(400, 150);
  for (const Eigen::Index rank : {2, 5}) {
    FieldModes modes(rank);
    for (Eigen::Index i = 0; i < fields.cols(); ++i) EXPECT_EQ(modes.add(fields.col(i)), i);
    const FieldModes::Result found = modes.take();
    ASSERT_EQ(found.modes.cols(), rank);
    EXPECT_LT((found.modes.transpose() * found.modes - MatrixXd::Identity(rank, rank)).norm(), 1e-10);
    const Eigen::JacobiSVD<MatrixXd> svd(fields, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const double best = svd.singularValues().tail(svd.singularValues().size() - rank).norm();
    EXPECT_LT((fields - found.modes * found.coefficients).norm(), 1.01 * best + 1e-9);
  }
}

TEST(FieldModes, OfFewOrNoFields) {
  FieldModes none(4);
  EXPECT_EQ(none.take().modes.cols(), 0);
  FieldModes one(4);
  const Eigen::VectorXd field = Eigen::VectorXd::LinSpaced(6, 1.0, 2.0);
  one.add(field);
  const FieldModes::Result found = one.take();
  ASSERT_EQ(found.modes.cols(), 1);
  EXPECT_LT((found.modes * found.coefficients - field).norm(), 1e-12);
}

TEST(LoadFields, KeepFirstAndLastTimeAndShareModesBetweenLoads) {
  EXPECT_EQ(thinned(3, 72), (std::vector<Eigen::Index>{0, 1, 2}));
  const std::vector<Eigen::Index> many = thinned(1000, 72);
  EXPECT_EQ(many.size(), 72U);
  EXPECT_EQ(many.front(), 0);
  EXPECT_EQ(many.back(), 999);
  const MatrixXd first = falling(60, 40), second = 3.0 * falling(60, 50).rightCols(12);
  const LoadFields a = compressed(first, 9), none, b = compressed(second, 9);
  const CommonFields common = in_common({&a, &none, &b}, 60, 9);
  ASSERT_EQ(common.coefficients.size(), 3U);
  EXPECT_EQ(common.coefficients[1].cols(), 0);
  const MatrixXd both = (MatrixXd(60, 52) << first, second).finished();
  const Eigen::JacobiSVD<MatrixXd> svd(both);
  const double best = svd.singularValues().tail(svd.singularValues().size() - 9).norm();
  const double missed = std::hypot((first - common.modes * common.coefficients[0]).norm(),
                                   (second - common.modes * common.coefficients[2]).norm());
  EXPECT_LT(missed, 1.5 * best + 1e-9);
  EXPECT_EQ(in_common({&none}, 60, 9).modes.rows(), 60);
}

}  // namespace
}  // namespace thermotwin::solver
