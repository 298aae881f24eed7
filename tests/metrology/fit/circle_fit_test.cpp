// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/fit/circle_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"

namespace thermotwin::metrology {
namespace {

using Eigen::Index;
using Eigen::MatrixX2d;

MatrixX2d arc(double x, double y, double radius, double degrees, Index n) {
  MatrixX2d points(n, 2);
  for (Index i = 0; i < n; ++i) {
    const double angle = degrees * std::numbers::pi / 180.0 * i / (n - 1);
    points.row(i) << x + radius * std::cos(angle), y + radius * std::sin(angle);
  }
  return points;
}

// Gander, Golub and Strebel (1994), table of the six points: the geometric circle is published to four decimals.
TEST(CircleFit, SixPublishedPoints) {
  MatrixX2d points(6, 2);
  points << 1, 7, 2, 6, 5, 8, 7, 7, 9, 5, 3, 7;
  const Circle geometric = fit_circle(points);
  EXPECT_TRUE(geometric.converged);
  EXPECT_NEAR(geometric.centre[0], 4.7398, 5e-5);
  EXPECT_NEAR(geometric.centre[1], 2.9835, 5e-5);
  EXPECT_NEAR(geometric.radius, 4.7142, 5e-5);
  EXPECT_LT(geometric.rms, fit_circle(points, CircleMethod::kasa).rms);
  EXPECT_LT(geometric.rms, fit_circle(points, CircleMethod::taubin).rms);
}

TEST(CircleFit, AllMethodsReturnAnExactCircleFarFromTheOrigin) {
  for (const double degrees : {5.0, 45.0, 300.0}) {
    const MatrixX2d points = arc(-120.5, 833.25, 0.19, degrees, 41);
    for (const CircleMethod method : {CircleMethod::kasa, CircleMethod::taubin, CircleMethod::geometric}) {
      const Circle circle = fit_circle(points, method);
      EXPECT_NEAR(circle.centre[0], -120.5, 1e-8) << degrees;
      EXPECT_NEAR(circle.centre[1], 833.25, 1e-8) << degrees;
      EXPECT_NEAR(circle.radius, 0.19, 1e-8) << degrees;
    }
  }
}

// A short arc with bumps: the algebraic fit makes the circle too small, the others do not share that bias.
TEST(CircleFit, KasaIsBiasedToSmallCircles) {
  MatrixX2d points = arc(0, 0, 1.0, 45, 200);
  for (Index i = 0; i < points.rows(); ++i) points.row(i) *= 1.0 + (i % 2 == 0 ? 0.02 : -0.02);
  const double kasa = fit_circle(points, CircleMethod::kasa).radius;
  const double taubin = fit_circle(points, CircleMethod::taubin).radius, geometric = fit_circle(points).radius;
  EXPECT_LT(kasa, 0.85);
  EXPECT_NEAR(taubin, 1.0, 0.05);
  EXPECT_NEAR(geometric, 1.0, 0.05);
}

// On a full circle the centre has twice the variance of the mean, the radius that of the mean.
TEST(CircleFit, CofactorOfAFullCircle) {
  const Index n = 360;
  MatrixX2d points = arc(3, -2, 5, 360.0 * (n - 1) / n, n);
  const Eigen::Matrix3d cofactor = fit_circle(points).cofactor;
  EXPECT_NEAR(cofactor(0, 0), 2.0 / n, 1e-9);
  EXPECT_NEAR(cofactor(1, 1), 2.0 / n, 1e-9);
  EXPECT_NEAR(cofactor(2, 2), 1.0 / n, 1e-9);
}

TEST(CircleFit, PointsThatAreNoArcAreRefused) {
  const auto refused = [](const MatrixX2d& points, const std::string& word) {
    try {
      fit_circle(points, CircleMethod::geometric, "cycle 4");
      ADD_FAILURE() << "accepted: " << word;
    } catch (const core::InputError& error) {
      EXPECT_NE(std::string(error.what()).find("cycle 4"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  refused(MatrixX2d::Zero(2, 2), "2 points");
  refused(MatrixX2d::Ones(5, 2), "one place");
  MatrixX2d line(5, 2);
  for (Index i = 0; i < 5; ++i) line.row(i) << 3.0 + i, 1.0 + 2.0 * i;
  refused(line, "on a line");
  line(3, 1) = std::numeric_limits<double>::quiet_NaN();
  refused(line, "point 4");
}

}  // namespace
}  // namespace thermotwin::metrology
