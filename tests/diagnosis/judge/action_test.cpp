// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/action.h"

#include <gtest/gtest.h>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/missing_source.h"
#include "tests/diagnosis/judge/boxed_column.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;

diagnosis::RankedCause cause(Kind kind, const std::string& where, double value) {
  diagnosis::RankedCause ranked;
  ranked.parameter = diagnosis::make_parameter(kind, where);
  ranked.value = value;
  return ranked;
}

TEST(Action, AMissingSourceIsLookedForWhereItIs) {
  diagnosis::RankedCause ranked = cause(Kind::source_missing, "column (-200, 100, 800) mm", 35.2);
  auto missing = std::make_shared<diagnosis::MissingSource>();
  missing->body = "column";
  missing->centre = {-0.2, 0.1, 0.8};
  missing->follows = "coolant.main.on";
  ranked.parameter.missing = missing;
  EXPECT_EQ(diagnosis::action_of(ranked, diagnosis::boxed_column()),
            "Look at the top left rear of column, 800 mm above the table, near sensor T3: about 35 W enter there in "
            "proportion to coolant.main.on.");
}

TEST(Action, EveryKindHasOneOfItsOwn) {
  const reduction::ReducedModel model = diagnosis::boxed_column();
  std::set<std::string> actions;
  for (const diagnosis::KindRow& row : diagnosis::known_kinds()) {
    if (row.kind == Kind::source_missing) continue;
    const std::string action = diagnosis::action_of(cause(row.kind, "item", 1.5), model);
    EXPECT_TRUE(actions.insert(action).second) << row.name << ": " << action;
    EXPECT_TRUE(action.find("item") != std::string::npos || action.find("1.5") != std::string::npos) << action;
    EXPECT_TRUE(action.ends_with(".")) << action;
  }
  EXPECT_EQ(diagnosis::action_of(cause(Kind::source_power, "motor", 1.6), model),
            "Check the power of motor (head.motor): its heat is 1.6 times the stated one. Measure the drive's power, "
            "and feel for friction.");
}

TEST(Action, OneChannelIsAskedForItsLoggerADeviceForItsClock) {
  const reduction::ReducedModel model = diagnosis::boxed_column();
  EXPECT_EQ(diagnosis::action_of(cause(Kind::clock_shift, "head_front", -52.0), model),
            "Ask first whether head_front comes from another logger: it is recorded 52 s too early. If so, synchronise "
            "the clocks. If not, check its place and mounting: it reacts earlier than the model predicts.");
  EXPECT_EQ(diagnosis::action_of(cause(Kind::clock_shift, "day/temperature", 314.0), model),
            "Synchronise the clocks: day/temperature is recorded 314 s too late.");
}

TEST(Action, AMaterialInAllItsBodiesIsCheckedByItsData) {
  EXPECT_EQ(diagnosis::action_of(cause(Kind::expansion_coefficient, "iron", 1.3), diagnosis::boxed_column()),
            "Check the data of material iron (base, column, head): in all of them its expansion is 1.3 times the "
            "stated one.");
  EXPECT_EQ(diagnosis::action_of(cause(Kind::heat_capacity, "head", 1.3), diagnosis::boxed_column()),
            "Check mass and material of head (ribs, fillings, attached parts): its heat capacity is 1.3 times the "
            "stated one.");
}

TEST(Action, AnotherLawIsRecordedOrLookedFor) {
  diagnosis::Diagnosis d;
  d.causes = {cause(Kind::source_power, "motor", 1.6)};
  d.ambiguous_set = {cause(Kind::other_law, "motor", 0.0), cause(Kind::unknown, "", 0.0)};
  std::vector<std::string> actions = diagnosis::actions_of(d, diagnosis::boxed_column());
  ASSERT_EQ(actions.size(), 2U);
  EXPECT_TRUE(actions[1].starts_with("Record the power of motor over time")) << actions[1];
  d.causes = {cause(Kind::contact_conductance, "foot", 0.4)};
  d.ambiguous_set[0] = cause(Kind::other_law, "foot", 0.0);
  actions = diagnosis::actions_of(d, diagnosis::boxed_column());
  ASSERT_EQ(actions.size(), 2U);
  EXPECT_TRUE(actions[1].starts_with("Check foot for loss of preload and hysteresis")) << actions[1];
}

TEST(Action, WhatComesNearestIsAPlaceToLookAt) {
  diagnosis::Diagnosis d;
  d.nearest = "source_step of motor";
  d.verdict = diagnosis::Verdict::no_discrepancy;
  EXPECT_EQ(diagnosis::nearest_action(d), "") << "of no discrepancy";
  d.verdict = diagnosis::Verdict::unexplained;
  EXPECT_TRUE(diagnosis::nearest_action(d).starts_with("Then look at source_step of motor: it comes nearest"));
  d.connection = "T1 and T2 seem exchanged";
  EXPECT_EQ(diagnosis::nearest_action(d), "") << "that comes first";
}

/// The reading that something unknown is in alone, not the one that is furthest off; what happened, where it steps.
TEST(Action, SomethingUnknownIsLookedForWhereItIs) {
  diagnosis::Diagnosis d;
  d.verdict = diagnosis::Verdict::unexplained;
  d.analysis.resize(2);
  d.analysis[0].id = "T8", d.analysis[0].ratio = 0.9;
  d.analysis[1].id = "dz@1", d.analysis[1].ratio = 0.7;
  EXPECT_NE(diagnosis::actions_of(d, diagnosis::boxed_column()).at(0).find("Begin with T8"), std::string::npos);
  d.unknown_in = {"dz@1"};
  EXPECT_NE(diagnosis::actions_of(d, diagnosis::boxed_column()).at(0).find("Begin with dz@1"), std::string::npos);
  d.steps.channels = {"dz@1", "dz@2"};
  d.steps.unit = "um";
  d.steps.steps = {{.from_s = 37044.0, .size = -3.44, .std = 0.21}};
  EXPECT_NE(diagnosis::actions_of(d, diagnosis::boxed_column())
                .at(0)
                .find("dz@1 and dz@2 changed suddenly by -3.44 +- 0.21 um at 10.29 h of the record"),
            std::string::npos)
      << diagnosis::actions_of(d, diagnosis::boxed_column()).at(0);
}

TEST(Action, FirstOfThoseThatShareWhereNoneIsNamed) {
  diagnosis::Diagnosis d;
  d.ambiguous_set = {cause(Kind::coolant_flow, "main", 0.45), cause(Kind::none, "", 0.0)};
  const std::vector<std::string> actions = diagnosis::actions_of(d, diagnosis::boxed_column());
  ASSERT_EQ(actions.size(), 1U);
  EXPECT_NE(actions[0].find("flow of coolant main (filter, pump, valves): it is 0.45 times"), std::string::npos);
  d.ambiguous_set = {cause(Kind::unknown, "", 0.0)};
  EXPECT_TRUE(diagnosis::actions_of(d, diagnosis::boxed_column()).empty());
}

}  // namespace
