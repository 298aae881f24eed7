// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/mandrel/mandrel.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

#include "core/error.h"
#include "core/units.h"
#include "tests/core/reference_page.h"

namespace thermotwin::metrology {
namespace {

using core::units::um;

/// Two probes along x, 100 mm apart (Mares et al. 2020). @param more  keys of the file, then of the second probe
MandrelRecord two_probes(const std::string& readings, const std::string& keys = "", const std::string& second = "") {
  return MandrelRecord::parse("schema = 1\n" + keys +
                                  "[[probe]]\nid = 'X1'\nat_mm = [0, 0, 100]\ndirection = [1, 0, 0]\nstd_um = 0.2\n"
                                  "[[probe]]\nid = 'X2'\nat_mm = [0, 0, 0]\ndirection = [1, 0, 0]\nstd_um = 0.2\n" +
                                  second,
                              core::parse_csv("time_s,X1_um,X2_um\n" + readings, "readings.csv"), "mandrel.toml");
}

TEST(Mandrel, AngleOfTwoProbes) {
  const Estimates found = analyse(two_probes("0,1,2\n60,8,4\n"));
  EXPECT_EQ(found.errors, (std::vector<std::string>{"dx", "rb"}));
  // Ten times the difference, for 100 mm.
  EXPECT_NEAR(found.cycles[1].value[1] / um, 10.0 * ((8.0 - 4.0) - (1.0 - 2.0)), 1e-9);
  EXPECT_NEAR(found.cycles[1].value[0] / um, 2.0, 1e-9);
  EXPECT_NEAR(found.cycles[1].std[1] / um, std::sqrt(2.0) * std::sqrt(2.0) * 0.2 / 0.1, 1e-9);
  EXPECT_EQ(found.not_observable.size(), 4u);
}

TEST(Mandrel, AnUncertainDistanceAddsToTheAngle) {
  const Estimates found = analyse(two_probes("0,0,0\n60,50,0\n", "", "place_std_mm = 1\n"));
  const double angle = found.cycles[1].value[1] / um, noise = 2.0 * 0.2 / 0.1;
  EXPECT_NEAR(angle, 500.0, 1e-9);
  EXPECT_NEAR(found.cycles[1].std[1] / um, std::hypot(noise, angle * 1.0 / 100.0), 1e-6);
}

TEST(Mandrel, OnTheTableItMovesAgainst) {
  const Estimates found = analyse(two_probes("0,0,0\n60,3,3\n", "mandrel = 'table'\n"));
  EXPECT_NEAR(found.cycles[1].value[0] / um, -3.0, 1e-9);
}

TEST(Mandrel, AQuantityThatIsAskedForHasToBeObservable) {
  EXPECT_NO_THROW(analyse(two_probes("0,1,2\n", "quantities = ['rb', 'dx']\n")));
  EXPECT_THROW(analyse(two_probes("0,1,2\n", "quantities = ['rb', 'dy']\n")), core::InputError);
}

TEST(Mandrel, ExpandedUncertaintyCovers) {
  MandrelRecord record = two_probes("0,0,0\n60,0,0\n");
  std::mt19937_64 engine(5);
  std::normal_distribution<double> noise(0.0, 0.2 * um);
  long inside = 0, all = 0;
  for (int draw = 0; draw < 500; ++draw) {
    for (double& value : record.readings.reshaped()) value = noise(engine);
    const CycleResult last = analyse(record).cycles.back();
    for (Eigen::Index e = 0; e < last.value.size(); ++e, ++all) inside += std::abs(last.value[e]) <= 2.0 * last.std[e];
  }
  const double covered = 100.0 * static_cast<double>(inside) / static_cast<double>(all);
  EXPECT_GT(covered, 90.0);
  EXPECT_LT(covered, 98.0);
}

TEST(Mandrel, ReferencePageIsThatOfTheReader) {
  core::expect_reference_page("mandrel", mandrel_keys(), "metrology_tests");
}

TEST(Mandrel, ProbesAlmostAtOnePlaceAreRefused) {
  const std::string other = "[[probe]]\nid = 'X3'\nat_mm = [0, 0, 1e-6]\ndirection = [1, 0, 0]\nstd_um = 0.2\n";
  try {
    MandrelRecord::parse(
        "schema = 1\n[[probe]]\nid = 'X1'\nat_mm = [0, 0, 0]\ndirection = [1, 0, 0]\nstd_um = 0.2\n" + other,
        core::parse_csv("time_s,X1_um,X3_um\n0,1,2\n", "readings.csv"), "mandrel.toml");
    ADD_FAILURE();
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'X1' and 'X3'"), std::string::npos) << error.what();
  }
}

// Three probes along x: the third one drifts against the others.
TEST(Mandrel, AProbeThatContradictsTheOthersIsNoticed) {
  const auto test = [](double drift_um) {
    std::string rows = "time_s,X1_um,X2_um,X3_um\n";
    for (int i = 0; i < 20; ++i)
      rows += fmt::format("{},{},{},{}\n", 60 * i, 5.0 + 0.5 * i + 0.2 * (i % 2), 1.0 + 0.3 * i,
                          -7.0 + 0.4 * i + drift_um * i / 19.0 - 0.2 * (i % 3 == 0));
    const MandrelRecord record = MandrelRecord::parse(
        "schema = 1\nquantities = ['dx', 'rb']\n"
        "[[probe]]\nid = 'X1'\nat_mm = [0, 0, 100]\ndirection = [1, 0, 0]\nstd_um = 0.2\n"
        "[[probe]]\nid = 'X2'\nat_mm = [0, 0, 0]\ndirection = [1, 0, 0]\nstd_um = 0.2\n"
        "[[probe]]\nid = 'X3'\nat_mm = [0, 0, 50]\ndirection = [1, 0, 0]\nstd_um = 0.2\n",
        core::parse_csv(rows, "readings.csv"), "mandrel.toml");
    return residual_test(record, analyse(record));
  };
  EXPECT_FALSE(test(0.0).exceeds) << "zeros of the probes are none";
  EXPECT_EQ(test(0.0).degrees, 19);
  EXPECT_TRUE(test(4.0).exceeds);
  EXPECT_GT(test(4.0).ratio, 2.0);
}

// A wrong place of a probe is one error in all rows, in which a rotation shows it.
TEST(Mandrel, WrongPlacesOfTheProbesAreNoContradiction) {
  for (const char* reference : {"absolute", "first"}) {
    int exceeds = 0, seen = 0;
    for (unsigned seed = 1; seed <= 200; ++seed) {
      std::mt19937_64 engine(seed);
      std::normal_distribution<double> normal;
      const double off_mm[] = {2.0 * normal(engine), 2.0 * normal(engine), 2.0 * normal(engine)};
      const auto found = [&](double jump_um) {
        std::string rows = "time_s,X1_um,X2_um,X3_um\n";
        for (int i = 0; i < 50; ++i) {
          const double per_mm = 0.1 + 0.002 * i;  // um/mm
          rows += fmt::format("{},{},{},{}\n", 60 * i, per_mm * (100.0 + off_mm[0]) + 0.1 * normal(engine),
                              per_mm * off_mm[1] + 0.1 * normal(engine),
                              per_mm * (50.0 + off_mm[2]) + 0.1 * normal(engine) + (i % 10 > 4 ? jump_um : 0.0));
        }
        std::string file = fmt::format("schema = 1\nreference = '{}'\nquantities = ['dx', 'rb']\n", reference);
        for (const int z : {100, 0, 50}) {
          file += fmt::format(
              "[[probe]]\nid = 'X{}'\nat_mm = [0, 0, {}]\ndirection = [1, 0, 0]\nstd_um = 0.1\nplace_std_mm = 2\n",
              z == 100 ? 1 : (z == 0 ? 2 : 3), z);
        }
        const MandrelRecord record = MandrelRecord::parse(file, core::parse_csv(rows, "readings.csv"), "mandrel.toml");
        return residual_test(record, analyse(record)).exceeds;
      };
      exceeds += found(0.0) ? 1 : 0;
      if (seed <= 20) seen += found(0.4) ? 1 : 0;
    }
    EXPECT_LE(exceeds, 2) << reference;
    EXPECT_GE(seen, 18) << reference;
  }
}

}  // namespace
}  // namespace thermotwin::metrology
