// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/hypothesis.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <unistd.h>

#include "core/error.h"
#include "core/file.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/machine_text.h"
#include "diagnosis/causes/machine_value.h"
#include "diagnosis/causes/offered_causes.h"
#include "diagnosis/causes/parameter.h"
#include "mesh/machine/file.h"
#include "mesh/machine/machine_keys.h"
#include "tests/machines/rods_record.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;
using diagnosis::Parameter;

std::vector<Parameter> all_parameters() {
  return diagnosis::candidate_parameters(lumped::machine(), lumped::measure({}, {.hours = 0.1}));
}

double number(const mesh::Machine& machine, const Parameter& parameter) {
  mesh::Machine copy = machine;
  return *diagnosis::machine_values(copy, parameter).front().value;
}

/// The three rods with one thing more of every kind: only read, never run.
mesh::Machine full_house() {
  std::string text = lumped::machine_text();
  const auto put = [&](const std::string& old, const std::string& with) {
    text.replace(text.find(old), old.size(), with);
  };
  put("id = \"air\"\n", "id = \"air\"\ngradient_K_m = 0.2\n");
  put("axis = \"Z\"\nconductance",
      "axis = \"Z\"\nstiffness_normal_N_mm3 = 300\nstiffness_tangential_N_mm3 = 200\npressure_MPa = 0.8\n"
      "nominal_pressure_MPa = 0.4\nconductance");
  text += R"(
[[body]]
id = "screw"
material = "iron"
cad = "screw.step"
element_size_mm = 30
parent = "column"
elastic = false
[[surface]]
id = "head.disc"
body = "head"
[[ambient]]
id = "fluid"
follows = "air"
[[film]]
id = "disc"
surfaces = ["head.disc"]
kind = "rotating_disc"
axis = "spindle"
radius_mm = 60
[[film]]
id = "wet"
surfaces = ["head.disc"]
ambient = "fluid"
state = "cutting_fluid.on"
film_coefficient_W_m2K = 100
[[coolant]]
id = "second"
flow_kg_s = 0.1
[[coolant.segment]]
id = "jacket"
surface = "head.channel"
film_coefficient_W_m2K = 60
[[source]]
id = "cut"
drive = "process"
place = [ { surface = "head.motor" } ]
[[scale]]
axis = "Z"
carrier = "column"
head_body = "head"
start_mm = [0, 0, 0]
end_mm = [0, 0, 500]
fixed_at_mm = [0, 0, 0]
head_mm = [0, 0, 200]
expansion_1_K = 8e-6
[[screw]]
axis = "Z"
body = "screw"
nut_body = "head"
fixed_bearing_mm = [0, 0, 0]
nut_mm = [0, 0, 200]
expansion_1_K = 11.5e-6
[[volume]]
id = "tank"
content_l = 20
[[volume.exchange]]
with = "air"
conductance_W_K = 3
[[volume]]
id = "cabinet"
heat_capacity_J_K = 5e4
[[volume.exchange]]
with = "tank"
conductance_W_K = 1
[[volume.exchange]]
with = "air"
conductance_W_K = { value = 4, std_percent = 30 }
[[volume.exchange]]
with = "air"
conductance_W_K = 6
state = "machine.on"
)";
  return mesh::parse_machine(text, "rods/machine.toml");
}

compensation::Measurement of_full_house() {
  compensation::Measurement m = lumped::measure({}, {.hours = 0.1});
  compensation::MeasuredChannel inlet = m.channels.back();
  inlet.id = inlet.input = "coolant.main.inlet_T_C";
  m.channels.push_back(inlet);
  return m;
}

std::vector<Parameter> full_parameters() {
  return diagnosis::candidate_parameters(full_house(), of_full_house(), true);
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) result.push_back(line);
  return result;
}

TEST(Hypothesis, EveryKindIsOfferedOncePerItem) {
  std::multiset<Kind> kinds;
  std::set<std::string> names;
  for (const Parameter& p : all_parameters()) {
    kinds.insert(p.kind);
    EXPECT_TRUE(names.insert(name_of(p.kind) + " " + p.where).second) << name_of(p) << " twice";
    EXPECT_GT(p.nominal_std, 0.0);
    EXPECT_GT(p.cause_std, 2 * p.nominal_std);
    EXPECT_LE(p.low, p.nominal);
    EXPECT_GT(p.high, p.nominal);
    EXPECT_FALSE(diagnosis::needs_parts(p.kind));
  }
  EXPECT_EQ(kinds.count(Kind::source_power), 3u);
  EXPECT_EQ(kinds.count(Kind::source_speed_law), 2u);
  EXPECT_EQ(kinds.count(Kind::standstill_power), 2u) << "a pump that is on with the machine is one candidate, not two";
  EXPECT_FALSE(names.count("standstill_power pump"));
  EXPECT_EQ(kinds.count(Kind::film_coefficient), 3u);
  EXPECT_EQ(kinds.count(Kind::film_speed_law), 0u);
  EXPECT_EQ(kinds.count(Kind::contact_conductance), 3u);
  EXPECT_EQ(kinds.count(Kind::ambient_offset), 1u);
  EXPECT_EQ(kinds.count(Kind::foundation_temperature), 1u);
  EXPECT_EQ(kinds.count(Kind::coolant_flow), 1u);
  EXPECT_EQ(kinds.count(Kind::coolant_coupling), 1u);
  EXPECT_EQ(kinds.count(Kind::control_sensor_offset), 1u);
  for (const Kind kind : {Kind::sensor_offset, Kind::sensor_drift, Kind::sensor_lag, Kind::sensor_detached})
    EXPECT_EQ(kinds.count(kind), 6u);
  EXPECT_EQ(kinds.count(Kind::probe_drift), 6u);  // four displacements, and all dx and all dz
  EXPECT_EQ(kinds.count(Kind::clock_shift), 12u);
}

TEST(Hypothesis, AFullHouseOffersEveryKindThatIsListed) {
  std::set<std::string> offered, listed;
  for (const Parameter& p : full_parameters()) offered.insert(name_of(p.kind) + " " + p.name + " " + p.unit);
  offered.insert("source_missing power W");  // by the patches of a model: missing_source.h
  offered.insert("source_step factor 1");    // by a record that changes: changing_size.h
  offered.insert("contact_step factor 1");
  for (const auto& kind : diagnosis::known_kinds()) listed.insert(kind.name + " " + kind.amount + " " + kind.unit);
  EXPECT_EQ(offered, listed);
}

TEST(Hypothesis, StatedUncertaintyIsTheNominalPrior) {
  EXPECT_DOUBLE_EQ(lumped::find(Kind::film_coefficient, "base.film").nominal_std, 0.10);
  EXPECT_DOUBLE_EQ(lumped::find(Kind::source_power, "motor").nominal_std, 0.05);
  EXPECT_DOUBLE_EQ(lumped::find(Kind::sensor_offset, "T3_reading").nominal_std, 0.05);
}

/// What a key of machine.toml that takes an uncertainty is in a diagnosis.
struct UncertainKey {
  Kind kind;
  std::function<void(mesh::Machine&, double)> state;  ///< std_percent at every item
};

template <class Items, class Value>
std::function<void(mesh::Machine&, double)> each(Items mesh::Machine::*items, Value value) {
  return [=](mesh::Machine& machine, double percent) {
    for (auto& item : machine.*items) value(item).std_percent = percent;
  };
}

std::map<std::string, UncertainKey> uncertain_keys() {
  using mesh::Machine;
  const auto films = each(
      &Machine::films, [](auto& film) -> auto& { return film.coefficient; });
  const auto capacities = each(
      &Machine::volumes, [](auto& volume) -> auto& { return volume.capacity; });
  return {
      {"material.specific_heat_J_kgK",
       {Kind::heat_capacity, each(
                                 &Machine::materials, [](auto& m) -> auto& { return m.specific_heat; })}},
      {"material.expansion_1_K",
       {Kind::expansion_coefficient, each(
                                         &Machine::materials, [](auto& m) -> auto& { return m.expansion; })}},
      {"joint.conductance_W_m2K",
       {Kind::contact_conductance, each(
                                       &Machine::joints, [](auto& j) -> auto& { return j.conductance; })}},
      {"joint.pressure_MPa",
       {Kind::contact_pressure, each(
                                    &Machine::joints, [](auto& j) -> auto& { return j.law.pressure; })}},
      {"film.emissivity",
       {Kind::film_emissivity, each(
                                   &Machine::films, [](auto& f) -> auto& { return f.emissivity; })}},
      {"joint.stiffness_normal_N_mm3",
       {Kind::contact_stiffness, each(
                                     &Machine::joints, [](auto& j) -> auto& { return j.stiffness_normal; })}},
      {"joint.stiffness_tangential_N_mm3",
       {Kind::contact_stiffness, each(
                                     &Machine::joints, [](auto& j) -> auto& { return j.stiffness_tangential; })}},
      {"scale.expansion_1_K",
       {Kind::scale_expansion, each(
                                   &Machine::scales, [](auto& s) -> auto& { return s.expansion; })}},
      {"screw.expansion_1_K",
       {Kind::screw_expansion, each(
                                   &Machine::screws, [](auto& s) -> auto& { return s.expansion; })}},
      {"ambient.default_C",
       {Kind::foundation_temperature, each(
                                          &Machine::ambients, [](auto& a) -> auto& { return a.default_C; })}},
      {"ambient.gradient_K_m",
       {Kind::ambient_gradient, each(
                                    &Machine::ambients, [](auto& a) -> auto& { return a.gradient; })}},
      {"volume.content_l", {Kind::volume_capacity, capacities}},
      {"volume.heat_capacity_J_K", {Kind::volume_capacity, capacities}},
      {"volume.exchange.conductance_W_K",
       {Kind::volume_exchange,
        [](Machine& machine, double percent) {
          for (mesh::VolumeSpec& volume : machine.volumes)
            for (mesh::VolumeExchange& exchange : volume.exchanges) exchange.conductance.std_percent = percent;
        }}},
      {"film.film_coefficient_W_m2K", {Kind::film_coefficient, films}},
      {"film.factor", {Kind::film_coefficient, films}},
      {"coolant.flow_kg_s",
       {Kind::coolant_flow, each(
                                &Machine::coolants, [](auto& c) -> auto& { return c.flow; })}},
      {"coolant.segment.film_coefficient_W_m2K",
       {Kind::coolant_coupling,
        [](Machine& machine, double percent) {
          for (mesh::CoolantSpec& coolant : machine.coolants)
            for (mesh::CoolantSegment& segment : coolant.segments) segment.film_coefficient.std_percent = percent;
        }}},
      {"source.scale",
       {Kind::source_power, each(
                                &Machine::sources, [](auto& s) -> auto& { return s.scale; })}},
  };
}

void collect_uncertain(const core::KeyTable& table, std::set<std::string>& names) {
  for (const core::Key& key : table.keys) {
    if (key.kind == core::KeyKind::uncertain) names.insert(table.name + "." + key.name);
    if (key.keys != nullptr) collect_uncertain(*key.keys, names);
  }
}

double widest(const mesh::Machine& machine, Kind kind) {
  double most = 0.0;
  for (const Parameter& p : diagnosis::candidate_parameters(machine, of_full_house(), true))
    if (p.kind == kind) most = std::max(most, p.nominal_std);
  return most;
}

/// A key whose uncertainty no diagnosis reads would be absorbed by something else, with full confidence.
TEST(Hypothesis, EveryKeyThatTakesAnUncertaintyIsANuisanceAndACause) {
  std::set<std::string> in_file;
  collect_uncertain(mesh::machine_keys(), in_file);
  const std::map<std::string, UncertainKey> known = uncertain_keys();
  for (const auto& [name, key] : known) EXPECT_TRUE(in_file.count(name)) << name;
  for (const std::string& name : in_file) {
    const auto found = known.find(name);
    ASSERT_NE(found, known.end()) << name << " takes std_percent, but no diagnosis reads it";
    mesh::Machine exact = full_house(), vague = exact;
    found->second.state(exact, 0.0);
    found->second.state(vague, 150.0);
    EXPECT_GT(widest(vague, found->second.kind), widest(exact, found->second.kind)) << name;
  }
}

TEST(Hypothesis, AVolumesExchangeAndContentAreWrittenWhereTheyStand) {
  const mesh::Machine machine = full_house();
  const auto written = [&](Kind kind, const std::string& where, double value) {
    const Parameter p = diagnosis::make_parameter(kind, where);
    return mesh::parse_machine(diagnosis::extended_text(machine, p, value, 0.05, "why"), machine.path).volumes;
  };
  const auto leaking = written(Kind::volume_exchange, "cabinet.air", 2.5);
  EXPECT_DOUBLE_EQ(leaking[1].exchanges[1].conductance.value, 10.0);
  EXPECT_DOUBLE_EQ(leaking[1].exchanges[1].conductance.std_percent, 30.0);
  EXPECT_DOUBLE_EQ(leaking[1].exchanges[0].conductance.value, 1.0);
  EXPECT_DOUBLE_EQ(leaking[0].exchanges[0].conductance.value, 3.0);
  // Another one with the same partner has its state in its name.
  EXPECT_DOUBLE_EQ(leaking[1].exchanges[2].conductance.value, 6.0);
  const auto open = written(Kind::volume_exchange, "cabinet.air.machine.on", 2.0);
  EXPECT_DOUBLE_EQ(open[1].exchanges[1].conductance.value, 4.0);
  EXPECT_DOUBLE_EQ(open[1].exchanges[2].conductance.value, 12.0);
  EXPECT_DOUBLE_EQ(written(Kind::volume_capacity, "tank", 1.5)[0].capacity.value, 30.0 * 4180.0);
  EXPECT_DOUBLE_EQ(written(Kind::volume_capacity, "cabinet", 0.5)[1].capacity.value, 2.5e4);
  const Parameter p = diagnosis::make_parameter(Kind::volume_capacity, "tank");
  EXPECT_DOUBLE_EQ(diagnosis::with_parameter(machine, p, 1.5).volumes[0].capacity.value, 30.0 * 4180.0);
}

TEST(Hypothesis, AnEmissivityAndAPressureAreWrittenWhereTheyStand) {
  const mesh::Machine machine = full_house();
  const auto written = [&](Kind kind, const std::string& where, double value) {
    const Parameter p = diagnosis::make_parameter(kind, where);
    return mesh::parse_machine(diagnosis::extended_text(machine, p, value, 0.05, "why"), machine.path);
  };
  EXPECT_DOUBLE_EQ(written(Kind::film_emissivity, "head.film", 0.5).films[2].emissivity.value, 0.45);
  const mesh::Machine loose = written(Kind::contact_pressure, "Z_guide", 0.25);
  const mesh::ContactLaw& law = loose.joints[loose.joint_index("Z_guide")].law;
  EXPECT_DOUBLE_EQ(law.pressure.value, 0.2e6);
  EXPECT_DOUBLE_EQ(law.nominal_pressure, 0.4e6);
  for (const Parameter& p : full_parameters()) {
    if (p.kind != Kind::film_emissivity) continue;
    EXPECT_DOUBLE_EQ(p.high, 1.0 / 0.9) << "no surface is blacker than black";
  }
}

TEST(Hypothesis, AStepIsAFactorFromItsTimeOnAndAScaleInTheFile) {
  const mesh::Machine machine = lumped::machine();
  Parameter p = diagnosis::make_parameter(Kind::source_step, "motor");
  p.from_s = 7200.0;
  p.from_std_s = 600.0;
  const diagnosis::MachineInTime changed = diagnosis::with_parameter(machine, p, 1.7);
  ASSERT_EQ(changed.later.size(), 1u);
  EXPECT_EQ(changed.sources[0].scale.value, 1.0) << "before the step it is as stated";
  EXPECT_EQ(changed.later[0].item, "motor");
  EXPECT_FALSE(changed.later[0].joint);
  EXPECT_EQ(changed.later[0].factor, 1.7);
  EXPECT_EQ(changed.later[0].from_s, 7200.0);
  const std::string text = diagnosis::extended_text(machine, p, 1.7, 0.1, "why");
  EXPECT_NE(text.find("since 2.00 +- 0.17 h of the record; why"), std::string::npos) << text;
  EXPECT_DOUBLE_EQ(mesh::parse_machine(text, machine.path).sources[0].scale.value, 1.7);
  Parameter ever = diagnosis::make_parameter(Kind::source_step, "motor");
  EXPECT_DOUBLE_EQ(diagnosis::with_parameter(machine, ever, 1.7).sources[0].scale.value, 1.7) << "since ever";
  p.where = "no such source";
  EXPECT_THROW(diagnosis::with_parameter(machine, p, 1.7), core::InputError);
}

TEST(Hypothesis, AClockIsAsSureAsTheInputsTimesAre) {
  const auto clock_std = [](const compensation::Measurement& m, double told_row_s) {
    for (const Parameter& p : diagnosis::candidate_parameters(lumped::machine(), m, false, told_row_s))
      if (p.kind == Kind::clock_shift && p.where == "temperature") return p.nominal_std;
    return -1.0;
  };
  EXPECT_NEAR(clock_std(lumped::measure({}, {.hours = 8, .sample_s = 60}), 0), 30, 0.5) << "half a row";
  compensation::Measurement slow = lumped::measure({}, {.hours = 8, .sample_s = 300});
  EXPECT_NEAR(clock_std(slow, 0), 150, 2);
  EXPECT_NEAR(clock_std(slow, 300), 100, 0.5) << "each change has its own time, but all may be late alike by a row";
  const auto lag = [&](double told_row_s) {
    for (const Parameter& p : diagnosis::candidate_parameters(lumped::machine(), slow, false, told_row_s))
      if (p.kind == Kind::sensor_lag) return p.nominal_std;
    return 0.0;
  };
  EXPECT_NEAR(lag(300), 100, 0.5) << "nor does a sensor lag by so much beside changes that all may be late";
  slow.rows_at_changes = true;
  EXPECT_NEAR(clock_std(slow, 0), 5, 0.5);
  slow.rows_at_changes = false;
  const auto channel = [&](const std::string& input) {
    return *std::find_if(slow.channels.begin(), slow.channels.end(), [&](const auto& c) { return c.input == input; });
  };
  const auto blank = [&](Eigen::Index column, Eigen::Index every) {
    for (Eigen::Index i = 0; i < slow.data.rows(); i += every) slow.data.values(i, column) = std::nan("");
  };
  // Where an axis swings is blank while it stands.
  compensation::MeasuredChannel range = channel("axis.Z.position_mm");
  range.id = range.input = "axis.Z.low_mm";
  range.column = slow.data.values.cols();
  slow.data.values.conservativeResize(Eigen::NoChange, range.column + 1);
  slow.data.values.col(range.column).setConstant(50);
  slow.channels.push_back(range);
  blank(range.column, 2);
  EXPECT_NEAR(clock_std(slow, 300), 100, 0.5);
  blank(channel("spindle.speed_rpm").column, 3);
  EXPECT_NEAR(clock_std(slow, 300), 175, 2) << "values 450 s apart in rows of 300 s";
}

TEST(Hypothesis, AMeasuredInletLeavesNoControlSensorToDoubt) {
  compensation::Measurement m = lumped::measure({}, {.hours = 0.1});
  compensation::MeasuredChannel inlet = m.channels.back();
  inlet.id = inlet.input = "coolant.main.inlet_T_C";
  m.channels.push_back(inlet);
  for (const Parameter& p : diagnosis::candidate_parameters(lumped::machine(), m))
    EXPECT_NE(p.kind, Kind::control_sensor_offset);
}

TEST(Hypothesis, AValueIsAppliedWithAllItsDigits) {
  const mesh::Machine machine = full_house();
  const Parameter p = diagnosis::make_parameter(Kind::source_power, machine.sources[0].id);
  const double value = 1.00000000512345, nominal = machine.sources[0].scale.value;
  EXPECT_DOUBLE_EQ(diagnosis::with_parameter(machine, p, value).sources[0].scale.value, value * nominal);
}

TEST(Hypothesis, ExtendedTextParsesToTheMachineWithTheParameter) {
  const mesh::Machine machine = full_house();
  for (const Parameter& p : full_parameters()) {
    SCOPED_TRACE(name_of(p));
    const double value = std::min(p.ratio ? 1.37 : p.low < 0 ? -0.83 : 0.6, 0.95 * p.high);
    const mesh::Machine changed = diagnosis::with_parameter(machine, p, value);
    const std::string text = diagnosis::extended_text(machine, p, value, 0.04, "a test");
    const mesh::Machine parsed = mesh::parse_machine(text, machine.path);
    EXPECT_NE(number(parsed, p), number(machine, p));
    for (const Parameter& other : full_parameters())
      EXPECT_DOUBLE_EQ(number(parsed, other), number(changed, other)) << name_of(other);
    for (std::size_t i = 0; i < machine.ambients.size(); ++i)
      EXPECT_DOUBLE_EQ(parsed.ambients[i].default_C.value, changed.ambients[i].default_C.value);
    for (std::size_t i = 0; i < machine.films.size(); ++i)
      EXPECT_EQ(parsed.films[i].coefficient.std_percent, machine.films[i].coefficient.std_percent);
  }
}

TEST(Hypothesis, ExtendedTextTouchesOneKeyAndSaysWhy) {
  const mesh::Machine machine = lumped::machine();
  const auto before = lines(machine.text);
  for (const Parameter& p : all_parameters()) {
    SCOPED_TRACE(name_of(p));
    const auto after = lines(diagnosis::extended_text(machine, p, p.ratio ? 2.0 : 0.5, 0.1, "because of a test"));
    const bool guides = p.kind == Kind::sensor_offset && p.item == machine.coolants.front().guide_sensor;
    if (p.kind == Kind::probe_drift || p.kind == Kind::clock_shift || guides) {  // a table of its own at the end
      ASSERT_EQ(after.size(), before.size() + 5);
      EXPECT_TRUE(std::equal(before.begin(), before.end(), after.begin()));
      EXPECT_EQ(after[before.size() + 1], "[[reading]]");
      EXPECT_NE(after[before.size() + 3].find("# diagnosis: " + name_of(p.kind)), std::string::npos);
      continue;
    }
    // Without the changed line and the comment above it, both files are the same.
    std::size_t first = 0, last = 0;
    while (first < before.size() && before[first] == after[first]) ++first;
    while (last + first < before.size() && before[before.size() - 1 - last] == after[after.size() - 1 - last]) ++last;
    EXPECT_LE(before.size() - first - last, 1u);
    ASSERT_EQ(after.size() - first - last, before.size() - first - last + (before.size() == first + last ? 2u : 1u));
    EXPECT_NE(after[first].find("# diagnosis: " + name_of(p.kind)), std::string::npos);
    EXPECT_NE(after[first].find("because of a test"), std::string::npos);
  }
}

TEST(Hypothesis, ExtendedTextKeepsFormAndCommentOfTheLine) {
  const mesh::Machine machine = lumped::machine();
  const std::string text =
      diagnosis::extended_text(machine, lumped::find(Kind::film_coefficient, "base.film"), 1.5, 0.1, "");
  EXPECT_NE(text.find("film_coefficient_W_m2K = {value = 13.5, std_percent = 10} # still air"), std::string::npos);
  const std::string joint =
      diagnosis::extended_text(machine, lumped::find(Kind::contact_conductance, "mounts"), 0.5, 0.1, "");
  EXPECT_NE(joint.find("conductance_W_m2K = { value = 200, std_percent = 10 }"), std::string::npos);
  const std::string sensor =
      diagnosis::extended_text(machine, lumped::find(Kind::sensor_offset, "T3_reading"), 0.7, 0.1, "");
  EXPECT_NE(sensor.find("offset_K = 0.8   # calibrated"), std::string::npos);
}

TEST(Hypothesis, AbsentKeysAreAddedToTheirOwnTable) {
  const mesh::Machine machine = lumped::machine();
  const mesh::Machine parsed =
      mesh::parse_machine(diagnosis::extended_text(machine, lumped::find(Kind::source_power, "guide_friction"), 0.4,
                                                   0.1, "line one\nline two"),
                          machine.path);
  EXPECT_DOUBLE_EQ(parsed.sources[1].scale.value, 0.4);
  EXPECT_DOUBLE_EQ(parsed.sources[0].scale.value, 1.0);
  EXPECT_EQ(parsed.sources[0].laws.size(), 1u);
}

TEST(Hypothesis, AnOffsetOfAGuidingSensorIsTheRecordsAlone) {
  const mesh::Machine machine = lumped::machine();
  const Parameter p = lumped::find(Kind::sensor_offset, "T1_reading");
  ASSERT_EQ(p.item, machine.coolants.front().guide_sensor);
  const mesh::Machine changed = diagnosis::with_parameter(machine, p, 0.7);
  ASSERT_EQ(changed.readings.size(), 1u);
  EXPECT_EQ(changed.readings[0].id, "T1_reading");
  EXPECT_DOUBLE_EQ(changed.readings[0].offset, 0.7);
  EXPECT_DOUBLE_EQ(changed.sensors[changed.sensor_index("T1")].offset, 0.0);
}

TEST(Hypothesis, ColumnsHaveNamesThatNoItemMayHave) {
  mesh::Machine machine = lumped::machine();
  Parameter p = diagnosis::make_parameter(Kind::clock_shift, "dx@1+x");
  const mesh::Machine read = mesh::parse_machine(diagnosis::extended_text(machine, p, 120.0, 5.0, ""), machine.path);
  ASSERT_EQ(read.readings.size(), 1u);
  EXPECT_EQ(read.readings[0].id, "dx@1+x");
  EXPECT_DOUBLE_EQ(read.readings[0].shift, 120.0);
  EXPECT_THROW(mesh::parse_machine(machine.text + "\n[[reading]]\nid = \"a b\"\n", machine.path), core::InputError);
  EXPECT_THROW(mesh::parse_machine(machine.text + "\n[[reading]]\nid = \"a\"\n[[reading]]\nid = \"a\"\n", machine.path),
               core::InputError);
}

TEST(Hypothesis, TwoChangesFollowEachOther) {
  const mesh::Machine machine = lumped::machine();
  const Parameter a = lumped::find(Kind::source_power, "pump"), b = lumped::find(Kind::sensor_offset, "T5_reading");
  const mesh::Machine one = mesh::parse_machine(diagnosis::extended_text(machine, a, 2.0, 0.1, ""), machine.path);
  const mesh::Machine two = mesh::parse_machine(diagnosis::extended_text(one, b, 1.0, 0.1, ""), machine.path);
  EXPECT_DOUBLE_EQ(two.sources[2].scale.value, 2.0);
  EXPECT_DOUBLE_EQ(two.sensors[4].offset, 1.0);
}

TEST(Hypothesis, ExtendedTextFindsItsCadFilesFromElsewhere) {
  const auto folder = std::filesystem::temp_directory_path() / ("thermotwin_cad_" + std::to_string(::getpid()));
  core::write_file(folder / "cad/bed \"old\".stl", "solid");
  core::write_file(folder / "cad/ram.gltf", "{}");  // names its buffers by paths beside it
  const std::string text =
      "[[body]]\nid = \"bed\"\ncad = 'cad/bed \"old\".stl'  # kept\n[[body]]\nid = \"slide\"\ncad = \"cad/none.stl\"\n"
      "[[body]]\nid = \"ram\"\ncad = \"cad/ram.gltf\"\n";
  mesh::Machine machine;
  machine.bodies.resize(3);
  machine.bodies[2].id = "ram";
  machine.bodies[2].cad = folder / "cad/ram.gltf";
  machine.bodies[0].id = "bed";
  machine.bodies[0].cad = folder / "cad/bed \"old\".stl";
  machine.bodies[1].id = "slide";
  machine.bodies[1].cad = folder / "cad/none.stl";
  const diagnosis::MovableText found = diagnosis::movable_text(text, machine);
  std::filesystem::remove_all(folder);
  EXPECT_EQ(found.text,
            "[[body]]\nid = \"bed\"\ncad = \"cad/bed \\\"old\\\".stl\"  # kept\n[[body]]\nid = \"slide\"\ncad = "
            "\"cad/none.stl\"\n[[body]]\nid = \"ram\"\ncad = \"" +
                machine.bodies[2].cad.string() + "\"\n");
  ASSERT_EQ(found.files.size(), 1u);
  EXPECT_EQ(found.files[0].first, machine.bodies[0].cad);
  EXPECT_EQ(found.files[0].second, "cad/bed \"old\".stl");
}

TEST(Hypothesis, ABodyOfASharedMaterialGetsItsOwn) {
  const mesh::Machine machine = lumped::machine();
  Parameter p = diagnosis::make_parameter(Kind::expansion_coefficient, "column");
  const mesh::Machine one = mesh::parse_machine(diagnosis::extended_text(machine, p, 1.2, 0.05, "why"), machine.path);
  ASSERT_EQ(one.materials.size(), 2u);
  EXPECT_EQ(one.bodies[1].material, "iron.column");
  EXPECT_EQ(one.bodies[0].material, "iron");
  EXPECT_DOUBLE_EQ(one.material("iron.column").expansion.value, 13.2e-6);
  EXPECT_DOUBLE_EQ(one.material("iron").expansion.value, 11e-6);
  p.kind = Kind::heat_capacity;
  const mesh::Machine two = mesh::parse_machine(diagnosis::extended_text(one, p, 2.0, 0.05, "why"), machine.path);
  EXPECT_EQ(two.materials.size(), 2u);
  EXPECT_DOUBLE_EQ(two.material("iron.column").specific_heat.value, 1000.0);
  EXPECT_DOUBLE_EQ(two.material("iron.column").expansion.value, 13.2e-6);
}

/// What is wrong with a material in all its bodies is one cause, also where a body has got a copy before.
TEST(Hypothesis, AMaterialOfSeveralBodiesChangesInAllOfThem) {
  const mesh::Machine machine = lumped::machine();
  const Parameter body = diagnosis::make_parameter(Kind::expansion_coefficient, "column"),
                  all = diagnosis::make_parameter(Kind::expansion_coefficient, "iron");
  const auto expansions = [](const mesh::Machine& m) {
    std::vector<double> values;
    for (const mesh::BodySpec& b : m.bodies) values.push_back(m.material(b.material).expansion.value);
    return values;
  };
  const std::vector<double> grown{13.2e-6, 13.2e-6, 13.2e-6}, both{13.2e-6, 19.8e-6, 13.2e-6};
  EXPECT_EQ(expansions(diagnosis::with_parameter(machine, all, 1.2)), grown);
  const mesh::Machine written =
      mesh::parse_machine(diagnosis::extended_text(machine, all, 1.2, 0.05, "why"), machine.path);
  EXPECT_EQ(expansions(written), grown);
  EXPECT_EQ(written.materials.size(), 1u);
  using diagnosis::with_parameter;
  EXPECT_EQ(expansions(with_parameter(with_parameter(machine, all, 1.2), body, 1.5)), both);
  EXPECT_EQ(expansions(with_parameter(with_parameter(machine, body, 1.5), all, 1.2)), both) << "in any order";
  const mesh::Machine own =
      mesh::parse_machine(diagnosis::extended_text(machine, body, 1.5, 0.05, "why"), machine.path);
  EXPECT_EQ(expansions(mesh::parse_machine(diagnosis::extended_text(own, all, 1.2, 0.05, "why"), machine.path)), both);
}

TEST(Hypothesis, AMaterialOfSeveralBodiesIsOfferedBesideThem) {
  std::map<std::string, double> spread;
  mesh::Machine machine = full_house();
  machine.materials[0].expansion.std_percent = machine.materials[0].specific_heat.std_percent = 4.0;
  const auto offered = [&](Kind kind) {
    spread.clear();
    for (const Parameter& p : diagnosis::candidate_parameters(machine, of_full_house(), true))
      if (p.kind == kind) spread[p.where] = p.nominal_std;
    return spread;
  };
  EXPECT_EQ(offered(Kind::heat_capacity),
            (std::map<std::string, double>{
                {"iron", 0.04}, {"base", 0.02}, {"column", 0.02}, {"head", 0.02}, {"screw", 0.02}}));
  EXPECT_EQ(offered(Kind::expansion_coefficient).count("screw"), 0u);
  for (std::size_t b = 1; b < machine.bodies.size(); ++b) {
    machine.materials.push_back(machine.materials[0]);
    machine.bodies[b].material = machine.materials.back().id = "material" + std::to_string(b);
  }
  EXPECT_EQ(offered(Kind::heat_capacity),
            (std::map<std::string, double>{{"base", 0.04}, {"column", 0.04}, {"head", 0.04}, {"screw", 0.04}}));
  machine = full_house();
  machine.materials[0].id = "base";
  for (mesh::BodySpec& body : machine.bodies) body.material = "base";
  EXPECT_EQ(offered(Kind::heat_capacity).size(), 4u) << "by its id a material would be a body";
}

TEST(Hypothesis, UnusualTextsAreReadOrRefused) {
  const mesh::Machine machine = lumped::machine();
  const Parameter motor = lumped::find(Kind::source_power, "motor");
  mesh::Machine crlf = machine;
  std::string windows;
  for (const char c : machine.text) windows += c == '\n' ? "\r\n" : std::string(1, c);
  crlf = mesh::parse_machine(windows, machine.path);
  EXPECT_DOUBLE_EQ(
      mesh::parse_machine(diagnosis::extended_text(crlf, motor, 1.25, 0.1, ""), machine.path).sources[0].scale.value,
      1.25);

  mesh::Machine tricky = machine;
  const std::string head = "name = \"rods\"";
  tricky.text.replace(tricky.text.find(head), head.size(), "name = '''\n[[source]]\nid = \"motor\"\nscale = 3'''");
  tricky = mesh::parse_machine(tricky.text, machine.path);
  EXPECT_DOUBLE_EQ(
      mesh::parse_machine(diagnosis::extended_text(tricky, motor, 1.25, 0.1, ""), machine.path).sources[0].scale.value,
      1.25);

  mesh::Machine gone = machine;
  gone.text = "schema = 1\n";
  EXPECT_THROW(diagnosis::extended_text(gone, motor, 1.25, 0.1, ""), core::InputError);
}

TEST(Hypothesis, UnknownKindsAndItemsAreRefused) {
  Parameter p = lumped::find(Kind::source_power, "motor");
  p.where = "moter";
  EXPECT_THROW(diagnosis::with_parameter(lumped::machine(), p, 1.1), core::InputError);
  EXPECT_THROW(diagnosis::kind_named("sorce_power"), core::InputError);
  EXPECT_EQ(diagnosis::kind_named("source_power"), Kind::source_power);
  p.kind = Kind::unknown;
  EXPECT_THROW(diagnosis::with_parameter(lumped::machine(), p, 1.1), core::InputError);
}

TEST(Hypothesis, ReadmeListsTheKindsThatTheCodeKnows) {
  std::ifstream file(THERMOTWIN_SOURCE_DIR "/diagnosis/README.md");
  ASSERT_TRUE(file) << "diagnosis/README.md";
  std::vector<std::vector<std::string>> table;
  bool of_kinds = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("| kind ")) of_kinds = true;
    if (!line.starts_with("|")) of_kinds = false;
    if (!of_kinds || !line.starts_with("| `")) continue;
    std::vector<std::string> cells;
    std::istringstream stream(line.substr(1));
    for (std::string cell; std::getline(stream, cell, '|');) {
      const auto first = cell.find_first_not_of(" `"), last = cell.find_last_not_of(" `");
      if (first != std::string::npos) cells.push_back(cell.substr(first, last - first + 1));
    }
    table.push_back(cells);
  }
  const auto& kinds = diagnosis::known_kinds();
  ASSERT_EQ(table.size(), kinds.size());
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    EXPECT_EQ(table[i], (std::vector<std::string>{kinds[i].name, kinds[i].where, kinds[i].amount, kinds[i].unit,
                                                  kinds[i].sense == diagnosis::Sense::ratio ? "ratio" : "absolute"}));
  }
}

}  // namespace
