// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/measurement.h"

#include <cmath>

#include "compensation/measurement/measurement_check.h"
#include "tests/compensation/scratch.h"
#include "tests/core/temporary_folder.h"
#include "tests/machines/five_axis.h"

namespace thermotwin::compensation {
namespace {

using test::expect_input_error;
using test::Scratch;

const char* const channels_text = R"(
[[channel]]
id = "T1"
kind = "temperature"
unit = "degC"
uncertainty = 0.05
sensor = "T_nose"
[[channel]]
id = "n"
kind = "speed"
unit = "rpm"
uncertainty = 1
input = "spindle.speed_rpm"
[[channel]]
id = "dz@1"
kind = "displacement"
unit = "um"
uncertainty = 0.3
quantity = "dz"
pose = {X_mm = -100, B_deg = 45}
frame = "machine"
zero = "first"
)";
const char* const data_text = "time_s,T1,n,dz@1\n0,20.5,,1.5\n10,nan,6000,2.5\n25,21,,3\n";

struct Folder : Scratch {
  explicit Folder(const std::string& channels = channels_text, const std::string& data = data_text) {
    write("channels.toml", channels);
    write("data.csv", data);
  }
  Measurement read() const { return read_measurement(path()); }
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(Measurement, IsReadAsWritten) {
  const Folder folder;
  const Measurement m = folder.read();
  ASSERT_EQ(m.channels.size(), 3U);
  EXPECT_EQ(m.channels[0].kind, ChannelKind::temperature);
  EXPECT_EQ(m.channels[0].sensor, "T_nose");
  EXPECT_EQ(m.channels[1].input, "spindle.speed_rpm");
  EXPECT_EQ(m.channels[2].pose_text, "X=-100,B=45");
  EXPECT_EQ(m.channels[2].zero, Zero::first);
  EXPECT_EQ(m.channels[2].uncertainty, 0.3);
  EXPECT_EQ(m.time()[2], 25.0);
  EXPECT_TRUE(std::isnan(m.values(m.channels[0])[1]));
  EXPECT_EQ(m.values(m.channels[2])[2], 3.0);
}

TEST(Measurement, AGradientIsNoStateOf0To1) {
  const std::string gradient =
      "[[channel]]\nid = \"g\"\nkind = \"state\"\nunit = \"K/m\"\ninput = \"air.gradient_K_m\"\n";
  const std::string data = "time_s,g\n0,1.8\n10,-0.5\n";
  EXPECT_EQ(Folder(gradient, data).read().channels.size(), 1U);
  const Folder state(replaced(gradient, "K/m", "1"), data);
  expect_input_error([&] { state.read(); }, {"data.csv:2 g", "1.8", "a state: 0 (off) to 1 (on)"});
}

TEST(Measurement, TellsTheTimeOfDayOfEachRow) {
  const Folder night("[record]\nstarts_at = \"23:30\"\n" + std::string(channels_text));
  mesh::Machine machine = test::five_axis_machine();
  machine.asks_time_of_day = true;
  const solver::Channels channels(machine);
  const Eigen::MatrixXd rows = channel_rows(night.read(), channels);
  const int hour = channels.index("day.time_h");
  ASSERT_GE(hour, 0);
  EXPECT_DOUBLE_EQ(rows(0, hour), 23.5);
  EXPECT_DOUBLE_EQ(rows(2, hour), 23.5 + 25.0 / 3600.0) << "it runs on beyond midnight";
  EXPECT_TRUE(std::isnan(channel_rows(Folder().read(), channels)(2, hour))) << "not stated";
  const Folder wrong("[record]\nstarts_at = \"25:00\"\n" + std::string(channels_text));
  expect_input_error([&] { wrong.read(); }, {"starts_at", "'25:00'", "23:59"});
}

TEST(Measurement, ARecordOfAnotherMachineIsRefusedByBothNames) {
  const mesh::Machine machine = test::five_axis_machine();
  const auto of = [](const std::string& name) {
    return Folder("[record]\nmachine = \"" + name + "\"\n" + std::string(channels_text));
  };
  const Folder own = of(machine.name), other = of("the \\\"other\\\" one");
  const std::string allowed = "'" + machine.name + "'";
  EXPECT_NO_THROW(require_fits(own.read(), machine));
  EXPECT_NO_THROW(require_fits(Folder().read(), machine)) << "not stated";
  expect_input_error([&] { require_fits(other.read(), machine); },
                     {"channels.toml [record] machine", "'the \"other\" one'", allowed.c_str()});
  const core::TemporaryFolder written;
  write_measurement(written / "copy", other.read());
  EXPECT_EQ(read_measurement(written / "copy").machine, "the \"other\" one");
}

TEST(Measurement, AClockRunsOnOverMidnightAndThroughRowsWithoutIt) {
  const Folder folder("[record]\nstarts_at = \"12:00\"\n" + std::string(channels_text) +
                          "[[channel]]\nid = \"clock\"\nkind = \"state\"\nunit = \"h\"\ninput = \"day.time_h\"\n",
                      "time_s,T1,n,dz@1,clock\n0,20,0,0,\n1800,20,0,0,23.5\n3600,20,0,0,\n5400,20,0,0,0.5\n"
                      "178200,20,0,0,0.5\n");
  mesh::Machine machine = test::five_axis_machine();
  machine.asks_time_of_day = true;
  const Measurement m = folder.read();
  require_fits(m, machine);
  const solver::Channels channels(machine);
  const Eigen::VectorXd hours = channel_rows(m, channels).col(channels.index("day.time_h"));
  const double expected[] = {23.0, 23.5, 24.0, 24.5, 72.5};
  for (Eigen::Index i = 0; i < hours.size(); ++i) EXPECT_DOUBLE_EQ(hours[i], expected[i]) << "row " << i;
}

// A location error of a test: three weights for each point.
const std::string arrangement_text = R"(
[[arrangement]]
id = "rtest"
[[arrangement.point]]
pose = {X_mm = 100, C_deg = 0}
[[arrangement.point]]
pose = {X_mm = -100, C_deg = 180}
[[channel]]
id = "A0C"
kind = "displacement"
unit = "um/m"
uncertainty = 2
quantity = "A0C"
arrangement = "rtest"
weights = [0, 0, -5.0123456789, 0, 0.25, 5]
zero = "first"
)";

TEST(Measurement, APointsWeightsAreReadAsWritten) {
  const Folder folder(arrangement_text, "time_s,A0C\n0,0\n10,3\n");
  const Scratch other;
  write_measurement(other.path() / "copy", folder.read());
  const Measurement m = read_measurement(other.path() / "copy");
  require_fits(m, test::five_axis_machine());
  ASSERT_EQ(m.channels[0].points.size(), 2U);
  EXPECT_EQ(m.channels[0].arrangement, "rtest");
  EXPECT_EQ(m.channels[0].points[1].pose_text, "X=-100,C=180");
  EXPECT_NEAR(m.channels[0].points[0].weight[2], -5.0123456789, 1e-9);
  EXPECT_EQ(m.channels[0].points[1].weight, Eigen::Vector3d(0, 0.25, 5));
  EXPECT_EQ(m.channels[0].zero, Zero::first);
}

TEST(Measurement, PointsThatDoNotFitTheirChannelAreRefused) {
  const auto refused = [](const std::string& from, const std::string& to, std::initializer_list<const char*> words) {
    const Folder folder(replaced(arrangement_text, from, to), "time_s,A0C\n0,0\n10,3\n");
    expect_input_error([&] { require_fits(folder.read(), test::five_axis_machine()); }, words);
  };
  refused("arrangement = \"rtest\"", "arrangement = \"retst\"", {"channels.toml:14", "'retst'", "nearest: rtest"});
  refused("0.25, 5]", "0.25]", {"weights", "5 weights for 2 points", "6"});
  refused("[0, 0, -5.0123456789, 0, 0.25, 5]", "[0, 0, 0, 0, 0, 0]", {"all weights 0"});
  refused("quantity = \"A0C\"", "quantity = \"ra\"", {"an arrangement of 'ra'", "a location error"});
  refused("zero = \"first\"", "pose = {X_mm = 1}", {"pose beside an arrangement"});
  refused("arrangement = \"rtest\"\n", "", {"weights without an arrangement"});
  refused("X_mm = -100", "X_mm = -1e5", {"arrangement 'rtest' point 2", "travel of axis X"});
  refused("id = \"rtest\"", "id = \"\"", {"channels.toml:3"});
}

TEST(Measurement, WrittenAndReadAgainIsTheSame) {
  const Folder folder;
  Measurement m = folder.read();
  EXPECT_FALSE(m.rows_at_changes);
  m.rows_at_changes = true;
  EXPECT_TRUE(std::isnan(m.starts_at_h));
  m.starts_at_h = 6.5;
  const Scratch other;
  write_measurement(other.path() / "copy", m);
  const Measurement copy = read_measurement(other.path() / "copy");
  ASSERT_EQ(copy.channels.size(), m.channels.size());
  for (std::size_t i = 0; i < m.channels.size(); ++i) {
    EXPECT_EQ(copy.channels[i].id, m.channels[i].id);
    EXPECT_EQ(copy.channels[i].kind, m.channels[i].kind);
    EXPECT_EQ(copy.channels[i].unit, m.channels[i].unit);
    EXPECT_EQ(copy.channels[i].uncertainty, m.channels[i].uncertainty);
    EXPECT_EQ(copy.channels[i].sensor, m.channels[i].sensor);
    EXPECT_EQ(copy.channels[i].input, m.channels[i].input);
    EXPECT_EQ(copy.channels[i].quantity, m.channels[i].quantity);
    EXPECT_EQ(copy.channels[i].pose_text, m.channels[i].pose_text);
    EXPECT_EQ(copy.channels[i].zero, m.channels[i].zero);
  }
  EXPECT_TRUE(copy.rows_at_changes);
  EXPECT_DOUBLE_EQ(copy.starts_at_h, 6.5);
  EXPECT_EQ(copy.data.columns, m.data.columns);
  EXPECT_EQ(copy.time(), m.time());
  EXPECT_EQ(copy.values(copy.channels[2]), m.values(m.channels[2]));
}

TEST(Measurement, MissingFilesAreNamed) {
  const Scratch empty;
  expect_input_error([&] { read_measurement(empty.path()); }, {"channels.toml", "data.csv"});
  expect_input_error([&] { read_measurement(empty.path() / "nowhere"); }, {"nowhere"});
  empty.write("channels.toml", channels_text);
  expect_input_error([&] { read_measurement(empty.path()); }, {"no file data.csv"});
}

TEST(Measurement, MistakesInChannelsAreNamedWithWhatIsAllowed) {
  const auto with = [](const std::string& from, const std::string& to) {
    return [=] { Folder(replaced(channels_text, from, to)).read(); };
  };
  expect_input_error(with("\"temperature\"", "\"temprature\""), {"temprature", "temperature", "displacement"});
  expect_input_error(with("\"degC\"", "\"F\""), {"\"F\"", "degC"});
  expect_input_error(with("sensor =", "sensr ="), {"sensr", "sensor"});
  expect_input_error(with("uncertainty = 0.05", "uncertainty = -1"), {"uncertainty"});
  expect_input_error(with("uncertainty = 0.05\n", ""), {"uncertainty"});
  expect_input_error(with("\"dz\"", "\"dw\""), {"dw", "dz"});
  expect_input_error(with("\"dz\"", "\"ra\""), {"ra", "um/m"});
  expect_input_error(with("X_mm", "X"), {"'X'", "X_mm"});
  expect_input_error(with("id = \"n\"", "id = \"T1\""), {"T1", "second time"});
  expect_input_error(with("id = \"n\"", "id = \"time_s\""), {"time_s", "second time"});
  expect_input_error([] { Folder("schema = 1\n").read(); }, {"no channel"});
}

TEST(Measurement, MistakesInDataNameLineAndColumn) {
  const auto with = [](const std::string& data) { return [=] { Folder(channels_text, data).read(); }; };
  expect_input_error(with("time_s,T1,n,dz@1\n0,1,1,1\n5,1,1,1\n4,1,1,1\n"),
                     {"data.csv:4", "backwards", "4 s after 5 s"});
  expect_input_error(with("time_s,T1,n,dz@1\n0,1,1,1\n0,1,1,1\n"), {"data.csv:3"});
  expect_input_error(with("time_s,T1,n,dz@1\n,1,1,1\n"), {"data.csv:2", "time_s"});
  expect_input_error(with("time_s,T1,n,dz@1\n0,1,1\n"), {"data.csv:2", "3 cells"});
  expect_input_error(with("time_s,T1,n,dz@1\n0,1,x,1\n"), {"data.csv:2 n", "'x'"});
  expect_input_error(with("t,T1,n,dz@1\n0,1,1,1\n"), {"time_s"});
  expect_input_error(with("time_s,T1,n\n0,1,1\n"), {"no column for channel 'dz@1'"});
  expect_input_error(with("time_s,T1,n,dz@1,dz@2\n0,1,1,1,1\n"), {"column 5", "dz@2", "nearest: dz@1"});
  expect_input_error(with("time_s,T1,n,dz@1\n"), {"no rows"});
  expect_input_error(with(""), {"data.csv"});
  const std::string fluid =
      std::string(channels_text) +
      "[[channel]]\nid = \"fluid\"\nkind = \"state\"\nunit = \"1\"\ninput = \"cutting_fluid.on\"\n";
  EXPECT_NO_THROW(Folder(fluid, "time_s,T1,n,dz@1,fluid\n0,1,1,1,nan\n5,1,1,1,0.5\n").read());
  expect_input_error([&] { Folder(fluid, "time_s,T1,n,dz@1,fluid\n0,1,1,1,0\n5,1,1,1,2\n").read(); },
                     {"data.csv:3 fluid", "2", "0 (off) to 1 (on)"});
}

TEST(Measurement, FitsAMachineOrSaysWhyNot) {
  const mesh::Machine machine = test::five_axis_machine();
  const auto with = [&](const std::string& from, const std::string& to) {
    return [&machine, from, to] { require_fits(Folder(replaced(channels_text, from, to)).read(), machine); };
  };
  EXPECT_NO_THROW(require_fits(Folder().read(), machine));
  expect_input_error(with("T_nose", "T_nos"), {"T_nos", "nearest: T_nose"});
  expect_input_error(with("\"degC\"", "\"K\""), {"'K'", "degC"});
  expect_input_error(with("spindle.speed_rpm", "spindel.speed_rpm"), {"spindel", "nearest: spindle.speed_rpm"});
  expect_input_error(with("spindle.speed_rpm", "axis.X.feed_mm_min"), {"rpm", "mm_min"});
  expect_input_error(with("X_mm = -100", "W_mm = 1"), {"W"});
  expect_input_error(with("X_mm = -100", "X_mm = 9000"), {"X", "travel"});
  expect_input_error(with("\"dz\"", "\"X0A\""), {"X0A", "rotary axes"});
  for (const char* error : {"\"X0T\"", "\"Y0B\""}) EXPECT_NO_THROW(with("\"dz\"", error)());
  expect_input_error(with("input = \"spindle.speed_rpm\"\n", ""), {"'n'", "neither sensor nor input"});
}

TEST(ChannelRows, HoldTheLastKnownValueAndDefaults) {
  const mesh::Machine machine = test::five_axis_machine();
  const solver::Channels channels(machine);
  const Eigen::MatrixXd rows = channel_rows(Folder().read(), channels);
  ASSERT_EQ(rows.rows(), 3);
  const int speed = channels.index("spindle.speed_rpm"), air = channels.index("air.T_C");
  EXPECT_EQ(rows(0, speed), 0.0);  // not known yet: the default
  EXPECT_EQ(rows(1, speed), 6000.0);
  EXPECT_EQ(rows(2, speed), 6000.0);
  EXPECT_EQ(rows(1, air), channels.defaults()[air]);
}

TEST(ChannelRows, RangeEndsWhereItsAxisStandsOrIsElsewhere) {
  const mesh::Machine machine = test::five_axis_machine();
  const solver::Channels channels(machine);
  const auto at = [&](const char* name) { return channels.index(std::string("axis.X.") + name); };
  Eigen::VectorXd row = channels.defaults(), given = Eigen::VectorXd::Constant(channels.size(), solver::not_given);
  given[at("position_mm")] = -50.0, given[at("feed_mm_min")] = 9000.0, given[at("low_mm")] = -120.0,
  given[at("high_mm")] = 20.0;
  channels.update(given, row);
  given[at("low_mm")] = given[at("high_mm")] = solver::not_given;
  channels.update(given, row);
  EXPECT_EQ(row[at("low_mm")], -120.0);  // a gap in the record: it goes on
  Eigen::VectorXd elsewhere = row;
  given[at("position_mm")] = 21.0;
  channels.update(given, elsewhere);
  EXPECT_TRUE(std::isnan(elsewhere[at("low_mm")]) && std::isnan(elsewhere[at("high_mm")]));
  given[at("position_mm")] = -50.0, given[at("feed_mm_min")] = 0.0;
  channels.update(given, row);
  EXPECT_TRUE(std::isnan(row[at("low_mm")]) && std::isnan(row[at("high_mm")]));
  given[at("low_mm")] = -10.0, given[at("high_mm")] = 10.0;  // who records no feeds
  channels.update(given, row);
  EXPECT_EQ(row[at("low_mm")], -10.0);
}

}  // namespace
}  // namespace thermotwin::compensation
