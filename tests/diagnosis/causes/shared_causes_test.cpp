// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/shared_causes.h"

#include <gtest/gtest.h>

#include <set>

#include "diagnosis/causes/hypothesis.h"
#include "mesh/machine/file.h"
#include "tests/machines/rods_record.h"

namespace {

using namespace thermotwin;
using compensation::Measurement;
using diagnosis::Kind;
using diagnosis::Parameter;

struct Two {
  std::vector<Measurement> records;
  diagnosis::Observations observations;
};

Two two_records() {
  Two two;
  Measurement first = lumped::measure({}, {.hours = 3}), second = lumped::measure({}, {.hours = 3, .noise_K = 0.2});
  first.folder = "monday";
  second.folder = "friday";
  two.records = diagnosis::with_record_names({first, second});
  std::vector<diagnosis::Observations> each;
  for (const Measurement& m : two.records)
    each.push_back(diagnosis::observe(m, lumped::machine(), solver::Channels(lumped::machine()), {}));
  two.observations = diagnosis::joined(std::move(each), diagnosis::record_names(two.records));
  return two;
}

TEST(SharedCauses, TheMachineIsOneAndReadingsAreSharedOrNot) {
  const Two two = two_records();
  const mesh::Machine machine = lumped::machine();
  const std::vector<Parameter> all = diagnosis::candidates_of_records(machine, two.records, two.observations, false),
                               alone = diagnosis::candidate_parameters(machine, two.records[0]);
  std::multiset<std::string> names;
  for (const Parameter& p : all) names.insert(name_of(p));
  for (const std::string& name : names) EXPECT_EQ(names.count(name), 1U) << name;
  for (const Parameter& p : alone) {
    if (!diagnosis::acts_on_readings(p.kind)) {
      EXPECT_TRUE(names.count(name_of(p))) << name_of(p);
    }
  }
  for (const char* name :
       {"sensor_offset of T1_reading", "sensor_offset of monday/T1_reading", "sensor_offset of friday/T1_reading",
        "sensor_lag of T1_reading", "probe_drift of dx_low", "probe_drift of friday/dx_low",
        "clock_shift of temperature", "clock_shift of friday/temperature"})
    EXPECT_TRUE(names.count(name)) << name;
  EXPECT_FALSE(names.count("sensor_lag of friday/T1_reading"));
  for (const Parameter& p : all) {
    if (name_of(p) == "sensor_offset of T1_reading") {
      EXPECT_DOUBLE_EQ(p.nominal_std, 0.2) << "the widest of both";
    } else if (name_of(p) == "sensor_offset of monday/T1_reading") {
      EXPECT_DOUBLE_EQ(p.nominal_std, 0.05);
    }
  }
}

TEST(SharedCauses, WhatOneRecordAloneIsOffByIsAReadingOfIt) {
  const Two two = two_records();
  const mesh::Machine machine = lumped::machine();
  int found = 0;
  for (const Parameter& p : diagnosis::candidates_of_records(machine, two.records, two.observations, false)) {
    if (p.where != "friday/T1_reading") continue;
    ++found;
    const mesh::Machine changed = diagnosis::with_parameter(machine, p, 0.5);
    EXPECT_EQ(changed.sensors.front().offset, machine.sensors.front().offset) << name_of(p);
    EXPECT_EQ(changed.sensors.front().drift, machine.sensors.front().drift) << name_of(p);
    const mesh::Machine written =
        mesh::parse_machine(diagnosis::extended_text(machine, p, 0.5, 0.1, "why"), machine.path);
    ASSERT_EQ(written.readings.size(), 1U) << name_of(p);
    EXPECT_EQ(written.readings[0].id, "friday/T1_reading");
    EXPECT_EQ(written.readings[0].offset, p.kind == Kind::sensor_offset ? 0.5 : 0.0);
    EXPECT_NEAR(3600.0 * written.readings[0].drift, p.kind == Kind::sensor_drift ? 0.5 : 0.0, 1e-12);
    EXPECT_EQ(written.readings[0].shift, p.kind == Kind::clock_shift ? 0.5 : 0.0);
  }
  EXPECT_EQ(found, 3) << "offset, drift and clock";
}

}  // namespace
