// SPDX-License-Identifier: GPL-3.0-or-later
// What a user may get wrong in files: exit status 3, a message with the place, the value and what is
// allowed, and earlier results byte for byte as they were.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

struct Slip {
  std::string name;                    ///< of the test
  std::string file, old, with;         ///< the edit; no old text: the whole file is replaced
  std::vector<std::string> arguments;  ///< "@" stands for the case, "@/x" for what is in it
  std::vector<std::string> said;
};

class BadInput : public testing::TestWithParam<Slip> {};

TEST_P(BadInput, IsRefusedAndLeavesEarlierResults) {
  const Slip& slip = GetParam();
  const Toy toy;
  toy.take_results();
  toy.take_measurement();
  if (slip.old.empty())
    toy.write(slip.file, slip.with);
  else
    toy.edit(slip.file, slip.old, slip.with);
  const auto before = files_in(toy.out());

  std::vector<std::string> arguments = slip.arguments;
  for (std::string& word : arguments)
    if (word.starts_with("@")) word = toy.path() + word.substr(1);
  const Result result = toy.run(arguments);
  EXPECT_EQ(result.status, 3) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_SAYS(result.err, "allowed: ");
  for (const std::string& words : slip.said) EXPECT_SAYS(result.err, words);
  EXPECT_EQ(changes(before, files_in(toy.out())), std::vector<std::string>());
}

const std::vector<std::string> run{"run", "@"};
const std::vector<std::string> diagnose{"diagnose", "@", "--data", "@/measurement"};

std::vector<Slip> slips_in_machines() {
  const std::string file = "machine.toml";
  return {
      {"MissingKey",
       file,
       "density_kg_m3 = 7200\n",
       "",
       run,
       {"machine.toml:13 material[1].density_kg_m3", "missing", "a number from 1 to 30000"}},
      {"NewerSchema",
       file,
       "schema = 1",
       "schema = 2",
       {"mesh", "@"},
       {"machine.toml:3 schema", "schema 2, of a newer thermotwin", "schema 1"}},
      {"AirThatItsOffsetHeats",
       file,
       "offset_K = 2.0\n",
       "offset_K = 150.0\n",
       {"mesh", "@"},
       {"machine.toml:372 ambient[3] default_C with offset_K", "170 degC", "-40 to 150 degC"}},
      {"ChainThatIsNone",
       file,
       "\"V [w C' B' b Y X Z (C1) t]\"",
       "\"rubbish\"",
       {"mesh", "@"},
       {"machine.toml:5 kinematic_chain", "'rubbish' without [ ]", "ISO 10791-1"}},
      {"ChainOnTheWrongSide",
       file,
       "\"V [w C' B' b Y X Z (C1) t]\"",
       "\"V [w C' B' X' b Y Z (C1) t]\"",
       {"mesh", "@"},
       {"machine.toml:5 kinematic_chain", "axis 'X' carries the workpiece; by the bodies it carries the tool",
        "[w C' B' b Y X Z t]"}},
      {"ChainInAnotherOrder",
       file,
       "\"V [w C' B' b Y X Z (C1) t]\"",
       "\"V [w B' C' b Y X Z (C1) t]\"",
       {"mesh", "@"},
       {"machine.toml:5 kinematic_chain", "from the bed to the workpiece: C, B; by the bodies: B, C",
        "[w C' B' b Y X Z t]"}},
      {"SingleBrackets",
       "cad.toml",
       "",
       "schema = 1\nname = \"own\"\nreference_C = 20\n[material]\nid = \"steel\"\n",
       {"mesh", "@/cad.toml"},
       {"cad.toml:4 material", "one table [material]", "[[material]]"}},
      {"IdWithoutQuotes",
       file,
       "id = \"x_slide\"",
       "id = x_slide",
       {"mesh", "@"},
       {"machine.toml:", "a text in quotes: id = \"x_slide\""}},
      {"DecimalComma", file, "poisson = 0.26", "poisson = 0,26", {"mesh", "@"}, {"a decimal point: poisson = 0.26"}},
      {"SpreadWithoutPercent",
       file,
       "film_coefficient_W_m2K = {value = 9, std_percent = 10}",
       "film_coefficient_W_m2K = {value = 9, std = 10}",
       {"mesh", "@"},
       {"film_coefficient_W_m2K.std_percent", "missing (found: std)", "{value = 9, std_percent = 10}"}},
      {"MisnamedKey",
       file,
       "conductivity_W_mK = 46",
       "conductivty_W_mK = 46",
       run,
       {"material[1].conductivity_W_mK", "found: conductivty_W_mK"}},
      {"MisnamedOptionalKey",
       file,
       "divide = [2, 2, 1]",
       "divde = [2, 2, 1]",
       run,
       {"joint[1].divde", "unknown key", "nearest is divide"}},
      {"UnknownUnit",
       file,
       "element_size_mm = 160",
       "element_size_mm = 160\nunit = \"inch\"",
       run,
       {"body[1].unit", "\"inch\"", "one of: mm, m, in"}},
      {"TextForANumber",
       file,
       "young_GPa = 120",
       "young_GPa = \"120\"",
       run,
       {"material[1].young_GPa", "\"120\"", "a number from", "without quotes"}},
      {"NumberOutOfRange", file, "poisson = 0.26", "poisson = 0.5", run, {"material[1].poisson", "0.5", "0.499"}},
      {"NotANumber",
       file,
       "reference_C = 20.0",
       "reference_C = nan",
       run,
       {"machine.toml:6 reference_C", "nan", "-50 to 100"}},
      {"RangeWithoutTheReference",
       file,
       "reference_C = 20.0",
       "reference_C = 20.0\nplausible_C = [30, 150]",
       run,
       {"machine.toml:7 plausible_C", "[30, 150]", "one on each side of reference_C = 20"}},
      {"ScaleOffItsAxis",
       file,
       "end_mm = [180, 90, 260]",
       "end_mm = [180, 190, 260]",
       {"mesh", "@"},
       {"machine.toml:361 scale[1].end_mm", "a tape from start_mm that is 15.5 deg off axis X",
        "at most 8 deg off it: [193.63"}},
      {"BrokenToml", file, "schema = 1", "schema = = 1", run, {"machine.toml:3:10", "TOML"}},
      {"UnknownSurface",
       file,
       "slave = \"post.foot\"",
       "slave = \"post.fot\"",
       run,
       {"joint[3].slave", "'post.fot'", "nearest: post.foot"}},
      {"UnknownMaterial",
       file,
       "material = \"steel\"",
       "material = \"stel\"",
       run,
       {"'stel'", "iron, steel", "nearest: steel"}},
      {"NoSuchCadFile", file, "cad/bed.stl", "cad/bde.stl", run, {"body[1].cad", "cad/bde.stl"}},
      {"GroupThatTheMeshLacks",
       file,
       "group = \"RAILS\"",
       "group = \"RAIL\"",
       run,
       {"surface[", "'RAIL'", "CARRIAGES, NUT, RAILS", "nearest: RAILS"}},
      {"RuleThatMatchesNothing",
       file,
       "plane_point_mm = [0, 0, 250]",
       "plane_point_mm = [0, 0, 900]",
       run,
       {"surface[5].rule", "no triangle", "650 mm from the plane", "tolerance_mm = 0.5", "one or more triangles"}},
      {"SensorOutsideItsBody",
       file,
       "point_mm = [0, -30, 200]",
       "point_mm = [0, -30, 900]",
       run,
       {"machine.toml sensor 'T1'", "[0, -30, 900], 480 mm outside body 'z_slide'", "element_size_mm = 50"}},
      {"UnknownChannelOfALaw",
       file,
       "axis.C.feed_deg_min",
       "axis.C.feed_dg_min",
       run,
       {"source[3].law[1].input", "axis.C.feed_dg_min", "nearest: axis.C.feed_deg_min"}},
      {"InvertedElement",
       "cad/x_slide.inp",
       "\n5, 1, 13, 10, 14\n",
       "\n5, 1, 10, 13, 14\n",
       run,
       {"body 'x_slide'", "x_slide.inp:70", "element 5", "inverted", "positive volume"}},
      {"NodeThatIsNoNumber",
       "cad/x_slide.inp",
       "61, -50, 90, 450",
       "61, -50, nan, 450",
       run,
       {"x_slide.inp:62", "'nan'", "a number"}},
      {"OpenSurface",
       "cad/bed.stl",
       "facet normal 0 0 0\nouter loop\nvertex -250 -150 -350\nvertex -250 500 -350\nvertex 250 500 "
       "-350\nendloop\nendfacet\n",
       "",
       run,
       {"body 'bed'"}},
  };
}

std::vector<Slip> slips_in_programs() {
  const std::string file = "loads/warm_up.toml";
  return {
      {"FeedAboveTheRapid",
       file,
       "feed_mm_min = 20000",
       "feed_mm_min = 30001",
       {"simulate", "@", "--load", "warm_up"},
       {"feed_mm_min", "30001", "a number from 0 to 30000\n"}},
      {"UnknownDrive",
       file,
       "spindle_rpm = 9000",
       "spindle_rpm = 9000\nfront_W = 20",
       {"simulate", "@", "--load", "warm_up"},
       {"warm_up.toml:12 phase[1].front_W", "no drive of this name", "one of: "}},
      {"BeyondTheTravel",
       file,
       "high_mm = 120",
       "high_mm = 121",
       run,
       {"warm_up.toml:17", "phase[1].axis[1].high_mm", "121", "120"}},
      {"TooFastASpindle",
       file,
       "spindle_rpm = 9000",
       "spindle_rpm = 90000",
       run,
       {"phase[1].spindle_rpm", "90000", "12000"}},
      {"TwoDurations",
       file,
       "duration_h = 1.5",
       "duration_h = 1.5\nduration_s = 5",
       run,
       {"phase[1]", "more than one duration", "one of: duration_h"}},
      {"AirInKelvin",
       file,
       "air_C = 20\n",
       "air_C = [293.15, 295]\n",
       run,
       {"warm_up.toml:10", "phase[1].air_C", "293.15 degC (20 degC if in kelvin)", "-40 to 150 degC"}},
      {"StartInKelvin",
       file,
       "initial_C = 20.0",
       "initial_C = 293.15",
       run,
       {"warm_up.toml:4 initial_C", "293.15 degC (20 degC if in kelvin)", "plausible_C"}},
      {"BeyondALimitWithoutSlack",
       "loads/mixed.toml",
       "Z_mm = 50",
       "Z_mm = -5",
       {"simulate", "@", "--load", "mixed"},
       {"mixed.toml:", "Z_mm: -5", "a number from 0 to 100"}},
      {"MachineInPlaceOfItsCase",
       "note.txt",
       "",
       "",
       {"simulate", "@/machine.toml", "--load", "warm_up"},
       {"machine.toml: a machine.toml, not a case", "the case's folder"}},
      {"FolderInPlaceOfAModel",
       "note.txt",
       "",
       "",
       {"export", "@", "--c", "@/source"},
       {"a folder, where a reduced model is read", "model.rom.h5"}},
      {"HalfWidthWithoutDistribution",
       "budget.toml",
       "",
       "schema = 1\n[[input]]\nname = \"a\"\nvalue = 1\nhalf_width = 2\n[[quantity]]\nname = \"b\"\nformula = \"a\"\n",
       {"measure", "uncertainty", "@/budget.toml"},
       {"budget.toml:5 input[1].half_width", "half_width without distribution", "rectangular"}},
      {"UnknownAxis", file, "id = \"X\"", "id = \"W\"", run, {"phase[1].axis[1].id", "'W'", "X, Y, Z, B, C"}},
      {"MisnamedPhaseKey",
       file,
       "cutting_fluid = true",
       "cuting_fluid = true",
       run,
       {"phase[1].cuting_fluid", "nearest is cutting_fluid"}},
      {"UnknownProgram",
       "case.toml",
       "\"warm_up\"]",
       "\"warmup\"]",
       run,
       {"case.toml:4 train", "'warmup'", "ambient, day_and_night, mixed, warm_up"}},
      {"ProgramTwice", "case.toml", "\"warm_up\"]", "\"ambient\"]", run, {"'ambient'", "twice"}},
      {"HeldOutAndTrained",
       "case.toml",
       "holdout = [\"mixed\"]",
       "holdout = [\"ambient\"]",
       run,
       {"case.toml:5 holdout", "'ambient'"}},
      {"NothingHeldOut", "case.toml", "holdout = [\"mixed\"]", "", run, {"case.toml holdout", "missing"}},
      {"NothingToTrainOn", "case.toml", "train = [\"ambient\", \"warm_up\"]", "", run, {"case.toml train", "missing"}},
      {"NoCheckPoints",
       "case.toml",
       "[\"X=-60,Y=20,Z=30,B=0\", \"X=80,Y=-25,Z=70,B=90\"]",
       "[]",
       run,
       {"case.toml check_points", "missing"}},
      {"CheckPointOffTheTravel", "case.toml", "Z=30", "Z=300", run, {"case.toml", "Z=300", "0 .. 100"}},
      {"UnknownEffect",
       "case.toml",
       "where = \"spindle.bearings\"",
       "where = \"spindle.bearing\"",
       run,
       {"case.toml:", "measured_machine.where", "spindle.bearing'", "spindle.bearings"}},
      {"UnknownSize",
       "case.toml",
       "machine = ",
       "size = \"huge\"\nmachine = ",
       run,
       {"'huge'", "coarse, standard, fine"}},
      {"LoadOnTheCommandLine",
       "note.txt",
       "",
       "",
       {"simulate", "@", "--load", "warm-up"},
       {"'warm-up'", "did you mean 'warm_up'"}},
      {"PoseOnTheCommandLine",
       "note.txt",
       "",
       "",
       {"simulate", "@", "--load", "warm_up", "--pose", "X=130"},
       {"--pose", "X=130", "-120 .. 120"}},
      {"NoSuchCase", "note.txt", "", "", {"campaign", "@/nosuch"}, {"nosuch"}},
  };
}

std::vector<Slip> slips_in_measurements() {
  const std::string data = "measurement/data.csv", channels = "measurement/channels.toml";
  return {
      {"EmptyCsv", data, "", "", diagnose, {"measurement/data.csv", "empty file", "column names"}},
      {"EmptyCsvOfEvaluate",
       data,
       "",
       "",
       {"evaluate", "--data", "@/measurement"},
       {"measurement/data.csv", "empty file"}},
      {"NoTime", data, "\n480,", "\nnan,", diagnose, {"data.csv:4 time_s", "missing value", "a number in every row"}},
      {"TimeRunsBackwards",
       data,
       "\n480,",
       "\n120,",
       diagnose,
       {"data.csv:4 time_s", "runs backwards: 120 s after 240 s", "rise"}},
      {"TimeStandsStill", data, "\n480,", "\n240,", diagnose, {"data.csv:4 time_s", "stands still"}},
      {"TextInACell",
       data,
       "\n480,1,",
       "\n480,on,",
       diagnose,
       {"data.csv:4 machine.on", "'on'", "a finite number, blank or nan"}},
      {"TooFewCells", data, "\n480,1,", "\n480,", diagnose, {"data.csv:4", "cells", "one for each column"}},
      {"DecimalComma", data, "\n480,1,", "\n480,1,5,", diagnose, {"data.csv:4", "a decimal comma makes two cells"}},
      {"Semicolons", data, "\n480,", "\n480;", diagnose, {"data.csv:4 time_s", "cells are parted by commas"}},
      {"ColumnWithoutChannel",
       data,
       ",T1,",
       ",T9,",
       diagnose,
       {"data.csv:1", "T1", "nearest: T9", "or no [[channel]] of this id"}},
      {"UnknownUnitOfAChannel",
       channels,
       "unit = \"degC\"",
       "unit = \"Celsius\"",
       diagnose,
       {"channels.toml:", "unit", "\"Celsius\"", "degC, K"}},
      {"UnitThatDoesNotFit",
       channels,
       "unit = \"rpm\"",
       "unit = \"mm_min\"",
       diagnose,
       {"channel 'spindle.speed_rpm'", "'mm_min'", "'rpm'"}},
      {"UnknownSensor",
       channels,
       "sensor = \"T4\"",
       "sensor = \"T5\"",
       diagnose,
       {"channels.toml:", " channel 'T4'", "'T5'", "T1, T2, T3, T4"}},
      {"UnknownQuantity", channels, "quantity = \"dz\"", "quantity = \"dq\"", diagnose, {"\"dq\"", "dx, dy, dz"}},
      {"NoMeasurement",
       "note.txt",
       "",
       "",
       {"diagnose", "@", "--data", "@/loads"},
       {"channels.toml", "channels.toml and data.csv"}},
      {"ModelThatIsNone",
       "model.rom.h5",
       "",
       "no model",
       {"diagnose", "--model", "@/model.rom.h5", "--data", "@/measurement"},
       {"model.rom.h5", "no HDF5 file", "a model.rom.h5 that `thermotwin reduce` wrote"}},
      {"NoSuchModel",
       "note.txt",
       "",
       "",
       {"diagnose", "--model", "@/none.rom.h5", "--data", "@/measurement"},
       {"none.rom.h5"}},
  };
}

std::string name_of(const testing::TestParamInfo<Slip>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Machine, BadInput, testing::ValuesIn(slips_in_machines()), name_of);
INSTANTIATE_TEST_SUITE_P(Program, BadInput, testing::ValuesIn(slips_in_programs()), name_of);
INSTANTIATE_TEST_SUITE_P(Measurement, BadInput, testing::ValuesIn(slips_in_measurements()), name_of);

// A sensor logged in kelvin under a channel that says degC.
TEST(Measurement, TemperaturesInKelvinAreNamed) {
  const Toy toy;
  toy.take_measurement();
  core::Table data = core::read_csv(toy.file("measurement/data.csv"));
  const Eigen::Index column = data.find("T1").value();
  data.values.col(column).array() += 273.15;
  core::write_csv(toy.file("measurement/data.csv"), data);
  for (const char* verb : {"diagnose", "evaluate"}) {
    const Result result = toy.run(
        {verb, toy.path(), "--data", toy.file("measurement"), "--model", (toy_run() / "model.rom.h5").string()});
    EXPECT_EQ(result.status, 3) << verb;
    EXPECT_SAYS(result.err, "data.csv:2 column " + std::to_string(column + 1) + " 'T1'");
    EXPECT_SAYS(result.err, "degC if in kelvin)");
    EXPECT_SAYS(result.err, "-40 to 150 degC (plausible_C of machine.toml)");
  }
}

// What a logger writes where a sensor's cable is open: that reading is missing, the record stays.
TEST(Measurement, AFaultCodeIsAMissingReading) {
  const Toy toy;
  toy.take_measurement();
  const std::string file = toy.file("measurement/data.csv");
  core::Table data = core::read_csv(file);
  const Eigen::Index column = data.find("T1").value();
  const auto judged = [&](const char* verb, double reading) {
    data.values(5, column) = reading;
    core::write_csv(file, data);
    return toy.run({verb, toy.path(), "--data", toy.file("measurement"), "--model",
                    (toy_run() / "model.rom.h5").string(), "--json"});
  };
  for (const char* verb : {"diagnose", "evaluate"}) {
    const Result coded = judged(verb, 850.0), blank = judged(verb, std::nan(""));
    ASSERT_EQ(coded.status, 0) << verb << coded.err;
    EXPECT_EQ(coded.out, blank.out) << verb;
    const std::string found = "data.csv: column " + std::to_string(column + 1) + " 'T1': 1 of ";
    EXPECT_SAYS(coded.err, found);
    EXPECT_EQ(coded.err.find(found), coded.err.rfind(found)) << "said once: " << coded.err;
    EXPECT_SAYS(coded.err, "-40 to 150 degC (plausible_C of machine.toml), the first 850 degC at 1200 s (line 7)");
    EXPECT_EQ(blank.err.find("'T1'"), std::string::npos) << blank.err;
  }
  data.values.col(column).segment(5, data.rows() / 10).setConstant(850.0);
  const Result many = judged("diagnose", 850.0);
  EXPECT_EQ(many.status, 3);
  EXPECT_SAYS(many.err, "data.csv:7 column " + std::to_string(column + 1) + " 'T1': 850 degC; allowed: ");
}

TEST(Measurement, TemperaturesInKelvinAreNamedWithoutAMachine) {
  const Toy toy;
  toy.take_measurement();
  core::Table data = core::read_csv(toy.file("measurement/data.csv"));
  const Eigen::Index column = data.find("T1").value();
  data.values.col(column).array() += 273.15;
  core::write_csv(toy.file("measurement/data.csv"), data);
  for (const char* verb : {"diagnose", "evaluate"}) {
    const Result result = toy.run({verb, "--data", toy.file("measurement")});
    EXPECT_EQ(result.status, 3) << verb;
    EXPECT_SAYS(result.err, "data.csv:2 column " + std::to_string(column + 1) + " 'T1'");
    EXPECT_SAYS(result.err, "degC if in kelvin)");
    EXPECT_SAYS(result.err, "allowed: -40 to 150 degC");
    EXPECT_EQ(result.err.find("machine.toml"), std::string::npos) << result.err;
  }
}

// A place that cannot hold results is refused before the long work, not after it.
TEST(Output, FolderThatCannotBe) {
  const Toy toy;
  toy.write("taken", "a file");
  for (const char* verb : {"run", "mesh", "campaign"}) {
    const Result result = thermotwin({verb, toy.path(), "--out", toy.file("taken")});
    EXPECT_EQ(result.status, 3) << result.err;
    EXPECT_SAYS(result.err, "taken");
    EXPECT_SAYS(result.err, "allowed: ");
    EXPECT_EQ(result.err.find("warning"), std::string::npos) << result.err;
  }
  EXPECT_EQ(read(toy.file("taken")), "a file");
}

}  // namespace
}  // namespace thermotwin::cases
