// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/surface/surface.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/error.h"
#include "core/units.h"
#include "tests/core/reference_page.h"

namespace thermotwin::metrology {
namespace {

using core::units::um;

SurfaceRecord flat(const std::vector<double>& radii_mm, int spokes, int order) {
  std::string text = "time_s,cycle,x_mm,y_mm,height_um\n";
  int time = 0;
  for (int cycle = 1; cycle <= 2; ++cycle)
    for (const double r : radii_mm)
      for (int k = 0; k < (r > 0 ? spokes : 1); ++k) {
        const double phi = 2.0 * std::numbers::pi * k / spokes;
        text += fmt::format("{},{},{:.9f},{:.9f},0\n", time += 5, cycle, r * std::cos(phi), r * std::sin(phi));
      }
  return SurfaceRecord::parse(fmt::format("schema = 1\nradius_mm = 300\nstd_um = 0.5\norder = {}\n", order),
                              core::parse_csv(text, "points.csv"), "surface.toml");
}

TEST(Surface, ModesAreNormalToEachOther) {
  constexpr double radius = 0.25;
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(10, 10);
  for (int i = -40; i <= 40; ++i)
    for (int k = -40; k <= 40; ++k) {
      const Eigen::Vector2d at = radius / 40.5 * Eigen::Vector2d(i, k);
      if (at.norm() > radius) continue;
      const Eigen::VectorXd modes = surface_modes(at, radius, 3);
      product += modes * modes.transpose();
    }
  const Eigen::VectorXd scale = product.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd off = scale.asDiagonal() * product * scale.asDiagonal() - Eigen::MatrixXd::Identity(10, 10);
  EXPECT_LT(off.cwiseAbs().maxCoeff(), 0.02);
}

TEST(Surface, ACircleHidesTheDome) {
  const Estimates found = analyse(flat({200}, 8, 2));
  ASSERT_EQ(found.not_observable.size(), 2u);
  EXPECT_NE(found.not_observable[0].find("Z0T: not observable"), std::string::npos);
  EXPECT_NE(found.not_observable[0].find("dome"), std::string::npos);
  EXPECT_EQ(found.observed().size(), 4u);
}

TEST(Surface, ExpandedUncertaintyCovers) {
  SurfaceRecord record = flat({0, 120, 280}, 8, 3);
  std::mt19937_64 engine(3);
  std::normal_distribution<double> noise(0.0, record.std);
  long inside = 0, all = 0;
  for (int draw = 0; draw < 200; ++draw) {
    for (SurfaceCycle& cycle : record.cycles)
      for (double& height : cycle.height) height = noise(engine);
    const CycleResult last = analyse(record).cycles.back();
    for (Eigen::Index e = 0; e < last.value.size(); ++e, ++all) inside += std::abs(last.value[e]) <= 2.0 * last.std[e];
  }
  const double covered = 100.0 * static_cast<double>(inside) / static_cast<double>(all);
  EXPECT_GT(covered, 90.0);
  EXPECT_LT(covered, 98.0);
}

TEST(Surface, ReferencePageIsThatOfTheReader) {
  core::expect_reference_page("surface", surface_keys(), "metrology_tests");
}

}  // namespace
}  // namespace thermotwin::metrology
