// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/next_measurement.h"

#include <gtest/gtest.h>

#include <limits>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/record/observations.h"

namespace {

using namespace thermotwin;
using diagnosis::Observations;

/// Two phases of a speed in equal steps, and an input that nobody states.
Observations load(double start, double hours, double speed, int steps) {
  Observations all;
  all.start = start;
  all.end = start + 3600.0 * hours;
  all.points = Eigen::VectorXd::LinSpaced(steps + 1, all.start, all.end);
  all.rows.setConstant(steps, 2, std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < steps; ++i) all.rows(i, 0) = 2 * i < steps ? speed : 0.0;
  return all;
}

TEST(NextMeasurement, TheLoadOfTheRecordIsKnownAgain) {
  const Observations record = load(100.0, 24.0, 5000.0, 288);
  EXPECT_TRUE(repeats(load(0.0, 24.0, 5000.0, 48), record)) << "in longer steps, from another time on";
  EXPECT_TRUE(repeats(load(0.0, 24.0, 5100.0, 48), record));
  EXPECT_FALSE(repeats(load(0.0, 24.0, 8000.0, 48), record)) << "another speed";
  EXPECT_FALSE(repeats(load(0.0, 12.0, 5000.0, 48), record)) << "half as long";
}

diagnosis::RankedCause ranked(diagnosis::Kind kind, const std::string& where, double probability) {
  diagnosis::RankedCause cause;
  cause.parameter = diagnosis::make_parameter(kind, where);
  cause.probability = probability;
  return cause;
}

std::vector<std::string> rivals(const diagnosis::Diagnosis& d) {
  std::vector<std::string> names;
  for (const diagnosis::Rival& rival : rivals_of(d)) names.push_back(rival.name());
  return names;
}

// Both of two named causes are true: a measurement that contrasts them decides nothing.
TEST(NextMeasurement, CausesNamedTogetherAreNoRivals) {
  using diagnosis::Kind;
  using Names = std::vector<std::string>;
  diagnosis::Diagnosis d;
  d.causes = {ranked(Kind::coolant_flow, "main", 1.0)};
  d.ambiguous_set = {ranked(Kind::clock_shift, "head_front", 0.97), ranked(Kind::unknown, "", 0.2)};
  EXPECT_EQ(rivals(d), (Names{"coolant_flow of main alone", "coolant_flow of main with clock_shift of head_front"}));
  d.causes.push_back(ranked(Kind::heat_capacity, "beam", 1.0));
  d.ambiguous_set.clear();
  EXPECT_EQ(rivals(d), (Names{"coolant_flow of main with heat_capacity of beam", "the machine as stated"}));
}

TEST(NextMeasurement, CausesThatShareAreRivals) {
  using diagnosis::Kind;
  using Names = std::vector<std::string>;
  diagnosis::Diagnosis d;
  d.ambiguous_set = {ranked(Kind::coolant_flow, "main", 0.5), ranked(Kind::heat_capacity, "beam", 0.4),
                     ranked(Kind::none, "", 0.1)};
  EXPECT_EQ(rivals(d), (Names{"coolant_flow of main", "heat_capacity of beam", "the machine as stated"}));
  d.ambiguous_set = {ranked(Kind::unknown, "", 1.0)};
  d.ranking = {ranked(Kind::unknown, "", 1.0), ranked(Kind::coolant_flow, "main", 0.5),
               ranked(Kind::heat_capacity, "beam", 0.4), ranked(Kind::heat_capacity, "head", 0.1)};
  EXPECT_EQ(rivals(d), (Names{"coolant_flow of main", "heat_capacity of beam"}));
}

}  // namespace
