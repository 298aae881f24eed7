// SPDX-License-Identifier: GPL-3.0-or-later
// A short selection of the bank, on the toy machine of tests/cases.
#include <gtest/gtest.h>

#include <algorithm>

#include "bank.h"
#include "reduction/reduce.h"

namespace {

using namespace thermotwin;

struct Bench {
  solver::Case machine_case = solver::read_case(THERMOTWIN_SOURCE_DIR "/tests/cases/toy");
  reduction::ReducedModel model;
  hidden::Specimen specimen{machine_case, other_mesh()};

  static hidden::SpecimenOptions other_mesh() {
    hidden::SpecimenOptions options;
    options.size_factor = 0.7;
    return options;
  }

  Bench() {
    const solver::FullModel full = solver::build_full_model(machine_case.machine, {1.0, {}});
    std::vector<solver::LoadProgram> loads;
    for (const std::string& name : machine_case.train) loads.push_back(machine_case.load(name));
    solver::CampaignOptions with_snapshots;
    with_snapshots.keep_snapshots = true;
    reduction::ReduceOptions order_80;
    order_80.order = 80;
    model = reduction::reduce(full, loads, solver::run_campaign(full, loads, with_snapshots), order_80);
  }
};

Bench& bench() {
  static Bench one;
  return one;
}

hidden::Line run(hidden::Group group, const hidden::Draw& draw) {
  return hidden::diagnose_set("test", group, draw, bench().specimen.measure(draw), bench().model);
}

TEST(HiddenEffects, CleanMachinesRaiseNoAlarm) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    hidden::Draw draw;
    draw.load = "mixed";
    draw.seed = seed;
    const hidden::Line line = run(hidden::Group::clean, draw);
    EXPECT_EQ(line.verdict, "no_discrepancy") << line.text();
  }
}

hidden::Truth truth(const std::string& kind, const std::string& where, double value) {
  for (const diagnosis::Parameter& p : diagnosis::candidate_parameters(bench().specimen.nominal(), bench().specimen.blank("mixed")))
    if (p.kind == kind && p.where == where) return {p, value};
  throw std::runtime_error("no " + kind + " of " + where);
}

TEST(HiddenEffects, WhatIsHiddenIsNamed) {
  std::uint64_t seed = 30;
  for (const hidden::Truth& t : {truth("source_power", "spindle.bearings", 2.0), truth("ambient_offset", "air", 2.2), truth("sensor_offset", "T3", -1.5)}) {
    hidden::Draw draw;
    draw.load = "mixed";
    draw.seed = ++seed;
    draw.truths = {t};
    const hidden::Line line = run(hidden::Group::single, draw);
    EXPECT_TRUE(line.identifiable()) << line.text();
    EXPECT_TRUE(line.verdict == "explained" || (line.verdict == "ambiguous" && line.named_probability > 0.9)) << line.text();
    EXPECT_EQ(line.named_kind + " of " + line.named_where, t.parameter.kind + " of " + t.parameter.where) << line.text();
  }
}

TEST(HiddenEffects, WhatNoKindDescribesIsNotNamed) {
  for (const char* sensor : {"T2", "T4"}) {
    hidden::Draw draw;
    draw.load = "mixed";
    draw.seed = 21;
    const compensation::Measurement clean = bench().specimen.measure(draw);
    draw.outside = hidden::Outside::slipping_cable;
    draw.outside_where = sensor;
    const compensation::Measurement spoilt = bench().specimen.measure(draw);
    const hidden::Line line = hidden::diagnose_set("test", hidden::Group::outside, draw, spoilt, bench().model, &clean);
    EXPECT_TRUE(line.visible()) << line.text();
    EXPECT_EQ(line.verdict, "unexplained") << line.text();
    const std::vector<std::string> notes = diagnosis::diagnose(bench().model, spoilt, {}).notes;
    EXPECT_EQ(std::count(notes.begin(), notes.end(), std::string("What no kind describes shows best in one channel alone: ") + sensor + "."), 1);
  }
}

TEST(HiddenEffects, LinesAreReadAsTheyWereWritten) {
  hidden::Line line;
  line.id = "a_1";
  line.group = "single";
  line.kind = "film_coefficient";
  line.where = "table";
  line.value = 1.5;
  line.verdict = "explained";
  line.against_none = 40;
  line.against_rival = 12;
  line.second_named = true;
  EXPECT_EQ(hidden::Line::parse(line.text()).text(), line.text());
  EXPECT_TRUE(hidden::Line::parse(line.text()).identifiable());
}

TEST(HiddenEffects, TheScoreCountsWhatItSays) {
  const auto line = [](const char* group, const char* verdict, const char* named, double against_none, double probability) {
    hidden::Line l;
    l.id = "x";
    l.group = group;
    l.kind = "source_power", l.where = "motor", l.value = 2.0, l.estimate = 2.1, l.std = 0.1;
    l.verdict = verdict;
    l.named_kind = named, l.named_where = "motor";
    l.against_none = against_none, l.against_rival = against_none;
    l.probability = l.named_probability = probability;
    l.rank = 1;
    return l;
  };
  const std::string table = hidden::score({line("single", "explained", "source_power", 50, 0.95), line("single", "explained", "film_coefficient", 50, 0.95),
                                           line("single", "no_discrepancy", "source_power", 5, 0.3), line("clean", "explained", "source_power", 0, 0.95)});
  EXPECT_NE(table.find("| >= 60 % | 66.7 % (2 of 3) |"), std::string::npos) << table;
  EXPECT_NE(table.find("| >= 95 % | 50.0 % (1 of 2) |"), std::string::npos) << table;
  EXPECT_NE(table.find("| 0 of 200 | 100.0 % (1 of 1) |"), std::string::npos) << table;
  // Claimed 0.95 three times, right once (a clean set has no cause).
  EXPECT_NE(table.find("expected calibration error"), std::string::npos) << table;
}

}  // namespace
