// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/field_modes.h"

#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "solver/export/field_record.h"

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

TEST(FieldRecord, KeepsFirstAndLastTimeAndNothingOfLoadsThatWereNotSeenWhole) {
  EXPECT_EQ(thinned(3, 72), (std::vector<Eigen::Index>{0, 1, 2}));
  const std::vector<Eigen::Index> many = thinned(1000, 72);
  EXPECT_EQ(many.size(), 72U);
  EXPECT_EQ(many.front(), 0);
  EXPECT_EQ(many.back(), 999);
  FieldRecord record(3);
  const Eigen::VectorXd field = Eigen::VectorXd::LinSpaced(8, 0.0, 1.0);
  for (Eigen::Index i = 0; i < 5; ++i) record.add("whole", i, 5, i * field);
  for (Eigen::Index i = 2; i < 5; ++i) record.add("part", i, 5, field);
  record.close();
  EXPECT_EQ(record.coefficients("part", 5).cols(), 0);
  EXPECT_EQ(record.coefficients("unknown", 5).cols(), 0);
  const MatrixXd coefficients = record.coefficients("whole", 5);
  ASSERT_EQ(coefficients.cols(), 5);
  EXPECT_LT((record.modes() * coefficients.col(3) - 3.0 * field).norm(), 1e-10);
}

}  // namespace
}  // namespace thermotwin::solver
