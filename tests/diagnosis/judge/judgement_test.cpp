// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/judgement.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "diagnosis/causes/parameter.h"
#include "mesh/machine/file.h"
#include "tests/machines/rods_record.h"

namespace {

using namespace thermotwin;

diagnosis::Diagnosis heat_found_in(const std::string& body) {
  auto missing = std::make_shared<diagnosis::MissingSource>();
  missing->body = body;
  diagnosis::RankedCause cause;
  cause.parameter.kind = diagnosis::Kind::source_missing;
  cause.parameter.missing = missing;
  diagnosis::Diagnosis d;
  d.causes = {cause};
  return d;
}

// Heat of a cut whose power nobody recorded looks like a source that machine.toml does not have.
TEST(Judgement, AMissingSourceWhereAnUnrecordedOneHeatsIsDoubted) {
  const std::string cut = "[[source]]\nid = \"cut\"\ndrive = \"process\"\nplace = [ { surface = \"head.motor\" } ]\n";
  const mesh::Machine machine = mesh::parse_machine(lumped::machine_text() + cut, "rods/machine.toml");
  compensation::Measurement record = lumped::measure({}, {.hours = 0.1});
  const std::string doubt = diagnosis::perhaps_unrecorded(machine, record, heat_found_in("head"));
  EXPECT_NE(doubt.find("process.power_W is not recorded"), std::string::npos) << doubt;
  EXPECT_EQ(diagnosis::perhaps_unrecorded(machine, record, heat_found_in("base")), "");
  EXPECT_EQ(diagnosis::perhaps_unrecorded(lumped::machine(), record, heat_found_in("head")), "");
  diagnosis::Diagnosis film = heat_found_in("head");
  film.causes.front().parameter = diagnosis::make_parameter(diagnosis::Kind::film_coefficient, "skin");
  EXPECT_EQ(diagnosis::perhaps_unrecorded(machine, record, film), "");

  compensation::MeasuredChannel power = record.channels.back();
  power.id = power.input = "process.power_W";
  record.channels.push_back(power);
  EXPECT_EQ(diagnosis::perhaps_unrecorded(machine, record, heat_found_in("head")), "");
}

}  // namespace
