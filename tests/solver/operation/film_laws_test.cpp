// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/film_laws.h"

#include <gtest/gtest.h>

#include <cmath>

namespace thermotwin::solver {

using mesh::Orientation;

TEST(FilmLaws, NusseltNumbersOfWallAndPlates) {
  EXPECT_NEAR(natural_nusselt(Orientation::vertical, 1e9), 123.0, 0.5);  // Churchill-Chu with its square
  EXPECT_NEAR(natural_nusselt(Orientation::up, 1e6), 0.54 * 31.6228, 1e-3);
  EXPECT_NEAR(natural_nusselt(Orientation::up, 1e9), 150.0, 1e-9);
  EXPECT_NEAR(natural_nusselt(Orientation::down, 1e8), 27.0, 1e-9);
}

TEST(FilmLaws, FreeConvectionOfAWallOfOneMetre) {
  // Ra = 9.81 * 1 * 3 / (16.1e-6^2 * 293.15) * 0.7 = 2.711e8
  const double h = free_convection(Orientation::vertical, 1.0, 3.0, 293.15);
  EXPECT_NEAR(h, natural_nusselt(Orientation::vertical, 2.7112e8) * 0.0268, 1e-3);
  EXPECT_GT(h, 1.5);
  EXPECT_LT(h, 3.0);
  EXPECT_DOUBLE_EQ(h, free_convection(Orientation::vertical, 1.0, -3.0, 293.15));
}

TEST(FilmLaws, DiscKeepsThePrintedLawsOutsideOfTheTransition) {
  EXPECT_NEAR(rotating_disc_nusselt(1e5), 0.355 * std::sqrt(1e5), 1e-9);
  EXPECT_NEAR(rotating_disc_nusselt(260e3), 0.355 * std::sqrt(260e3), 1e-9);
  EXPECT_NEAR(rotating_disc_nusselt(320e3), 0.0163 * std::pow(320e3, 0.8), 1e-9);
  EXPECT_NEAR(rotating_disc_nusselt(5e5), 0.0163 * std::pow(5e5, 0.8), 1e-9);
}

TEST(FilmLaws, DiscIsContinuousAndNeverFalls) {
  // The printed laws jump from 181 to 116 at 260,000 and from 208 to 413 at 320,000.
  for (double re = 1e3; re < 1e6; re *= 1.0005) {
    const double low = rotating_disc_nusselt(re), high = rotating_disc_nusselt(re * 1.0005);
    EXPECT_GT(high, low) << re;
    EXPECT_LT(high - low, 0.0025 * low) << re;
  }
}

TEST(FilmLaws, DiscIgnoresTheSignAndStandsWithoutFilm) {
  EXPECT_EQ(rotating_disc(0.0, 0.4), 0.0);
  EXPECT_DOUBLE_EQ(rotating_disc(-20.0, 0.4), rotating_disc(20.0, 0.4));
  // Laminar: independent of the radius.
  EXPECT_NEAR(rotating_disc(5.0, 0.1), rotating_disc(5.0, 0.3), 1e-9);
}

TEST(FilmLaws, RadiationAtRoomTemperature) { EXPECT_NEAR(radiation(1.0, 293.15), 5.714, 1e-3); }

}  // namespace thermotwin::solver
