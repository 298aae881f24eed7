// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/stream.h"

#include <fmt/format.h>

#include <iterator>
#include <random>
#include <sstream>

#include "compensation/online/compensator.h"
#include "core/table.h"
#include "tests/compensation/scratch.h"
#include "tests/machines/five_axis.h"

namespace thermotwin::compensation {
namespace {

using test::expect_input_error;

const reduction::ReducedModel& nominal() {
  static const reduction::ReducedModel model = test::lumped_model();
  return model;
}

StreamOptions quiet(bool strict = false) {
  StreamOptions options;
  options.strict = strict;
  options.log = options.warn = options.lack = [](const std::string&) {};
  return options;
}

std::string streamed(const std::string& text, const StreamOptions& options = quiet()) {
  Compensator compensator(nominal());
  std::istringstream in(text);
  std::ostringstream out;
  compensate_stream(compensator, nominal().machine, in, "rows.csv", out, options);
  return out.str();
}

TEST(CompensateStream, WritesOffsetsDeviationsAndStatusForEachRow) {
  const std::string out =
      streamed("time_s,spindle.speed_rpm,axis.X.position_mm,T_nose_C\n0,0,100,20\n60,6000,100,20\n120.5,6000,-100,\n");
  std::istringstream lines(out);
  std::string header, row;
  std::getline(lines, header);
  EXPECT_EQ(header, "time_s,offset_x_um,offset_y_um,offset_z_um,std_x_um,std_y_um,std_z_um,status");
  std::getline(lines, row);
  EXPECT_EQ(row.substr(0, 2), "0,");
  EXPECT_NE(row.find(",ok"), std::string::npos);
  std::getline(lines, row);
  std::getline(lines, row);
  EXPECT_EQ(row.substr(0, 6), "120.5,");
  EXPECT_NE(row.find(",no_sensors"), std::string::npos);
  EXPECT_FALSE(std::getline(lines, row));
}

// One torn line at the start is no reason to end; rows that never fit the header are.
TEST(CompensateStream, FirstRowsWithOtherCellsAreRepeatedUntilOneFits) {
  const std::string header = "time_s,spindle.speed_rpm,air.T_C\n";
  const std::string out = streamed(header + "0,20\n1,0,20,7\n2,0,20\n");
  EXPECT_EQ(std::count(out.begin(), out.end(), '\n'), 4);
  EXPECT_NE(out.find("input_missing row=unreadable"), std::string::npos);
  EXPECT_NE(out.find("\n2,"), std::string::npos);
  std::string commas = header;
  for (int i = 0; i < 10; ++i) commas += fmt::format("{},0,20,5\n", i);
  commas += "10,0,20\n";  // too late
  for (const std::string& text : {commas, header + "0,20\n"}) {
    try {
      streamed(text);
      FAIL() << "was accepted";
    } catch (const core::InputError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("rows.csv:2: ")) << error.what();
    }
  }
}

TEST(CompensateStream, AgreesWithTheCompensatorRowByRow) {
  std::string text = "time_s,spindle.speed_rpm,air.T_C,axis.B.position_deg,T_nose_C\n";
  Compensator compensator(nominal());
  std::vector<Eigen::Index> absent;
  for (Eigen::Index k = 0; k < compensator.channels().size(); ++k) {
    const std::string& name = compensator.channels().names()[k];
    if (!std::isnan(compensator.channels().defaults()[k]) && text.find(name) == std::string::npos) absent.push_back(k);
  }
  compensator.never_told(absent);
  Eigen::VectorXd row = compensator.channels().defaults();
  Eigen::VectorXd sensors = Eigen::VectorXd::Constant(std::ssize(nominal().machine.sensors), std::nan(""));
  std::vector<double> expected;
  for (int i = 0; i < 300; ++i) {
    const double speed = i < 150 ? 8000 : 0, air = 20 + 0.01 * i, b = i % 90, nose = 20 + 0.02 * i;
    text += fmt::format("{},{},{},{},{}\r\n", 30 * i, speed, air, b, nose);
    row[compensator.channels().index("spindle.speed_rpm")] = speed;
    row[compensator.channels().index("air.T_C")] = air;
    row[compensator.channels().index("axis.B.position_deg")] = b;
    sensors[nominal().machine.sensor_index("T_nose")] = nose;
    expected.push_back(compensator.step(30.0 * i, row, sensors).offset_um[2]);
  }
  std::istringstream lines(streamed(text));
  std::string line;
  std::getline(lines, line);
  for (const double z : expected) {
    ASSERT_TRUE(std::getline(lines, line));
    double time = 0, x = 0, y = 0, offset = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &time, &x, &y, &offset), 4);
    EXPECT_NEAR(offset, z, 5.1e-4);
  }
}

// A value of a row was probed with the offsets that were in effect until that row.
TEST(CompensateStream, AValueProbedWithCompensationCountsTheOffsetsBeforeItsRow) {
  StreamOptions options = quiet();
  options.probed_compensated = true;
  std::string text = "time_s,spindle.speed_rpm,probe_dx_um,probe_dz_um\n";
  Compensator compensator(nominal());
  const Eigen::Index spindle = compensator.channels().index("spindle.speed_rpm");
  std::vector<Eigen::Index> absent;
  for (Eigen::Index k = 0; k < compensator.channels().size(); ++k) {
    if (k != spindle && !std::isnan(compensator.channels().defaults()[k])) absent.push_back(k);
  }
  compensator.never_told(absent);
  Eigen::VectorXd row = compensator.channels().defaults(), before = Eigen::Vector3d::Zero();
  row[spindle] = 12000;
  std::string last;
  double moved = 0;
  for (int i = 0; i <= 60; ++i) {
    text += fmt::format("{},12000,{},{}\n", 300 * i, i == 20 ? "4" : "", i == 20 ? "-3" : "");
    const Offsets& offsets = compensator.step(300.0 * i, row, {});
    last = fmt::format("{},{:.3f},{:.3f},{:.3f},", 300 * i, offsets.offset_um[0], offsets.offset_um[1],
                       offsets.offset_um[2]);
    if (i == 20) {
      moved = (offsets.offset_um - before).norm();
      compensator.probe_compensated(compensator.pose(), {4, std::nan(""), -3}, before, options.probe_std_um);
    }
    before = offsets.offset_um;
  }
  EXPECT_GT(moved, 0.1) << "um: else either row's offsets would do";
  const std::string out = streamed(text, options);
  EXPECT_NE(out.find("\n" + last), std::string::npos) << last << " in " << out;
}

TEST(CompensateStream, ABlankCellKeepsTheLastValue) {
  const std::string with = streamed("time_s,spindle.speed_rpm\n0,6000\n60,\n120,nan\n180, \n");
  const std::string without = streamed("time_s,spindle.speed_rpm\n0,6000\n60,6000\n120,6000\n180,6000\n");
  EXPECT_EQ(with, without);
}

TEST(CompensateStream, AMissingLastNewlineAndBlankLinesAtTheEndAreFine) {
  const std::string plain = streamed("time_s\n0\n60\n");
  EXPECT_EQ(streamed("time_s\n0\n60"), plain);
  EXPECT_EQ(streamed("\xEF\xBB\xBFtime_s\r\n0\r\n60\r\n\r\n\n"), plain);
}

TEST(CompensateStream, MistakesAreNamedWithLineAndColumn) {
  const auto with = [](const std::string& text) { return [text] { streamed(text, quiet(true)); }; };
  expect_input_error(with(""), {"rows.csv", "no header"});
  expect_input_error(with("time_s,spindel.speed_rpm\n"),
                     {"rows.csv:1 column 2", "spindel", "nearest: spindle.speed_rpm"});
  expect_input_error(with("time_s,T_nos_C\n"), {"T_nos_C", "nearest: T_nose_C"});
  expect_input_error(with("air.T_C\n20\n"), {"time_s"});
  expect_input_error(with("time_s,air.T_C,air.T_C\n"), {"column 3", "second time"});
  expect_input_error(with("time_s\n0\n\n60\n"), {"rows.csv:3", "blank line"});
  expect_input_error(with("time_s\nnan\n"), {"rows.csv:2", "time_s"});
  expect_input_error(with("time_s,air.T_C\n,20\n"), {"rows.csv:2", "time_s"});
  expect_input_error(with("time_s\n5\n4\n"), {"rows.csv:3", "backwards", "4 s after 5 s"});
  expect_input_error(with("time_s\n5\n5\n"), {"rows.csv:3", "stands still"});
  expect_input_error(with("time_s,air.T_C\n0\n"), {"rows.csv:2", "1 cell;", "2"});
  expect_input_error(with("time_s,air.T_C\n0,20\n60,20,7\n"), {"rows.csv:3", "3 cells", "2"});
  expect_input_error(with("time_s,air.T_C\n0,warm\n"), {"rows.csv:2 air.T_C", "'warm'"});
  expect_input_error(with("time_s,air.T_C\n0,1e999\n"), {"rows.csv:2 air.T_C"});
  expect_input_error(with("time_s,air.T_C\n0,inf\n"), {"rows.csv:2 air.T_C"});
  expect_input_error(with("time_s,T_nose_C\n0,1e300\n"), {"rows.csv:2 T_nose_C", "1e300", "at most 1e+10"});
  expect_input_error(with("time_s,cutting_fluid.on\n0,-1\n"),
                     {"rows.csv:2", "cutting_fluid.on = -1", "0 (off) to 1 (on)"});
  expect_input_error(with("time_s\n0\n1700000000\n"), {"rows.csv:3", "time gap", "1700000000 s after 0 s"});
}

TEST(CompensateStream, AFullOutputIsAnError) {
  Compensator compensator(nominal());
  std::istringstream in("time_s\n0\n60\n");
  std::ostringstream out;
  out.setstate(std::ios::badbit);
  expect_input_error([&] { compensate_stream(compensator, nominal().machine, in, "rows.csv", out, quiet()); },
                     {"written"});
}

TEST(CompensateStream, WhatCannotBeReadIsMissingUnlessAskedToBeStrict) {
  std::vector<std::string> said;
  StreamOptions options = quiet();
  options.warn = [&](const std::string& text) { said.push_back(text); };
  Compensator compensator(nominal());
  std::istringstream in(
      "time_s,spindle.speed_rpm,T_nose_C\n0,0,20\n60,fast,20\n120,0,warm\n,0,20\n180,0\n\n240,0,20\n300,-,20\n");
  std::ostringstream out;
  const StreamSummary summary = compensate_stream(compensator, nominal().machine, in, "rows.csv", out, options);
  EXPECT_EQ(summary.rows, 7);
  EXPECT_EQ(summary.unreadable, 5);
  EXPECT_EQ(said.size(), 6U);  // and the blank line
  EXPECT_NE(said[0].find("rows.csv:3 spindle.speed_rpm: 'fast'"), std::string::npos) << said[0];
  std::istringstream lines(out.str());
  std::vector<std::string> rows;
  for (std::string line; std::getline(lines, line);) rows.push_back(line);
  ASSERT_EQ(rows.size(), 8U);
  const char* endings[] = {",ok",
                           ",input_missing spindle.speed_rpm=unreadable",
                           ",sensor_failed T_nose_C=unreadable",
                           ",input_missing time_s=missing",
                           ",input_missing row=unreadable",
                           ",ok",
                           ",input_missing spindle.speed_rpm=unreadable"};
  for (std::size_t i = 0; i < 7; ++i) EXPECT_TRUE(rows[i + 1].ends_with(endings[i])) << rows[i + 1];
  // A row without a time gets the answer of the row before once more.
  EXPECT_EQ(rows[4].substr(0, rows[4].rfind(',')), rows[3].substr(0, rows[3].rfind(',')));
  EXPECT_EQ(rows[5].substr(0, rows[5].rfind(',')), rows[3].substr(0, rows[3].rfind(',')));
  // Rows that never fit the header are another file's.
  expect_input_error([] { streamed("time_s,air.T_C\n0\n60\n"); }, {"rows.csv:2", "1 cell;", "2"});
  expect_input_error([] { streamed("time_s\n5\n4\n"); }, {"backwards"});
}

TEST(CompensateStream, WhatTheMachineCannotHaveIsMissing) {
  std::vector<std::string> said;
  StreamOptions options = quiet();
  options.warn = [&](const std::string& text) { said.push_back(text); };
  const std::string header = "time_s,spindle.speed_rpm,axis.X.position_mm,axis.X.feed_mm_min,axis.C.position_deg\n";
  const std::pair<const char*, const char*> cells[] = {
      {"6000,100,60000,0", "no_sensors"},
      {"15000,100,60000,0", "input_missing spindle.speed_rpm=beyond_12000"},
      {"12100,100,60500,0", "no_sensors"},  // an overshoot of less than 1 %
      {"-12000,100,-60000,4000", "no_sensors"},
      {"-12500,100,0,0", "input_missing spindle.speed_rpm=beyond_-12000"},
      {"6000,409,0,0", "input_missing axis.X.position_mm=beyond_400"},
      {"6000,100,70000,0", "input_missing axis.X.feed_mm_min=beyond_60000"},
      {"nan,100,0,0", "no_sensors"},
  };
  std::string rows = header;
  double time = 0;
  for (const auto& [cell, status] : cells) rows += fmt::format("{},{}\n", time += 60, cell);
  std::istringstream lines(streamed(rows, options));
  std::string line;
  std::getline(lines, line);
  for (const auto& [cell, status] : cells) {
    std::getline(lines, line);
    EXPECT_EQ(line.substr(line.rfind(',') + 1), status) << cell;
  }
  ASSERT_EQ(said.size(), 4U);
  for (const char* words :
       {"rows.csv:3: spindle.speed_rpm = 15000", "-12000 to 12000 (spindle_max_rpm of machine.toml)"})
    EXPECT_NE(said[0].find(words), std::string::npos) << said[0];
  EXPECT_NE(said[2].find("-400 to 400 (travel_mm of axis X of machine.toml)"), std::string::npos) << said[2];
  // It is what a blank cell is.
  const auto offsets = [&](const std::string& speed) {
    const std::string out = streamed("time_s,spindle.speed_rpm\n0,6000\n60," + speed + "\n");
    return out.substr(0, out.rfind(','));
  };
  EXPECT_EQ(offsets("15000"), offsets(""));
  expect_input_error([&] { streamed("time_s,spindle.speed_rpm\n0,15000\n", quiet(true)); },
                     {"rows.csv:2", "spindle.speed_rpm = 15000", "-12000 to 12000"});
}

TEST(CompensateStream, TheSignOfASpeedIsADirection) {
  // Tapping: both directions within a step heat as one does.
  std::string both = "time_s,spindle.speed_rpm,axis.X.feed_mm_min\n", one = both;
  for (int i = 0; i < 200; ++i) {
    const bool back = i % 2 == 1;
    both += fmt::format("{},{},{}\n", 10 * i, back ? -6000 : 6000, back ? 20000 : -20000);
    one += fmt::format("{},6000,20000\n", 10 * i);
  }
  EXPECT_EQ(streamed(both), streamed(one));
}

// An axis that carries the table, or whose direction is turned round, moves the TCP the other way.
TEST(CompensateStream, ProbedErrorsAreComparedWithTheMotionThatOffsetsMake) {
  reduction::ReducedModel turned = nominal();
  turned.machine.axes[turned.machine.axis_index("X")].direction *= -1.0;
  std::string rows = "time_s,spindle.speed_rpm,axis.B.position_deg,probe_dx_um,probe_dy_um,probe_dz_um\n";
  for (int i = 0; i < 120; ++i) rows += fmt::format("{},8000,45,,,\n", 60 * i);
  Compensator seen(nominal());
  std::istringstream before(rows);
  std::ostringstream out;
  compensate_stream(seen, nominal().machine, before, "rows.csv", out, quiet());
  const Eigen::Vector3d error_um = 1e6 * seen.tcp(seen.pose()).error.head<3>();
  ASSERT_GT(std::abs(error_um.x()), 1.0);
  rows += fmt::format("7200,8000,45,{},,{}\n", error_um.x(), error_um.z());
  for (const reduction::ReducedModel* model : {&nominal(), static_cast<const reduction::ReducedModel*>(&turned)}) {
    Compensator compensator(*model);
    std::istringstream in(rows);
    const StreamSummary done = compensate_stream(compensator, model->machine, in, "rows.csv", out, quiet());
    EXPECT_EQ(done.probed, 2);
    EXPECT_NEAR(done.probed_rms_um, std::hypot(error_um.x(), error_um.z()) / std::sqrt(2.0), 1e-3);
    EXPECT_LT(done.left_rms_um, 0.1 * std::abs(error_um.x()));
  }
}

TEST(CompensateStream, ALineWithoutEndHasALimit) {
  class Endless : public std::streambuf {
  public:
    explicit Endless(std::string start) : start_(std::move(start)) {
      setg(start_.data(), start_.data(), start_.data() + start_.size());
    }
    long blocks = 0;

  private:
    int_type underflow() override {
      if (++blocks > 100000) return traits_type::eof();
      setg(digits_.data(), digits_.data(), digits_.data() + digits_.size());
      return traits_type::to_int_type(digits_.front());
    }
    std::string start_, digits_ = std::string(1024, '1');
  };
  for (const char* start : {"", "time_s\n0\n6"}) {
    Endless source(start);
    std::istream in(&source);
    std::ostringstream out;
    Compensator compensator(nominal());
    expect_input_error([&] { compensate_stream(compensator, nominal().machine, in, "rows", out, quiet()); },
                       {"a line of more than", "at most 262143 characters"});
    EXPECT_LT(source.blocks, 300);
  }
}

TEST(CompensateStream, RowsOfAnotherMachineAreRefused) {
  const mesh::Machine& machine = nominal().machine;
  const std::string rows = "time_s\n0\n60\n", own = fmt::format("# machine {} {}\n", machine.name, machine.hash);
  EXPECT_EQ(streamed(own + rows), streamed(rows));
  EXPECT_EQ(streamed("# written by hand\n" + rows), streamed(rows));
  expect_input_error([&] { streamed("# machine other 0123\n" + rows); },
                     {"rows.csv:1", "'other'", "'0123'", machine.name.c_str(), machine.hash.c_str()});
  expect_input_error([&] { streamed(fmt::format("# machine other {}\n", machine.hash) + rows); },
                     {"rows.csv:1", "'other'"});
  // The same machine after a change of its file: said, and an error only to the strict.
  std::string said;
  StreamOptions options = quiet();
  options.warn = [&](const std::string& text) { said = text; };
  EXPECT_EQ(streamed(fmt::format("# machine {} 0123\n", machine.name) + rows, options), streamed(rows));
  EXPECT_NE(said.find("'0123'"), std::string::npos);
  options.strict = true;
  expect_input_error([&] { streamed(fmt::format("# machine {} 0123\n", machine.name) + rows, options); },
                     {"rows.csv:1"});
}

/// A stream of rows that are made when they are read, so that memory stays what the code needs.
class EndlessRows : public std::streambuf {
public:
  EndlessRows(std::string header, long rows) : line_(std::move(header)), rows_(rows) {
    setg(line_.data(), line_.data(), line_.data() + line_.size());
  }

private:
  int_type underflow() override {
    if (next_ >= rows_) return traits_type::eof();
    line_ = fmt::format("{},{},{},{},{},{:.2f},{:.2f}\n", next_, next_ / 600 % 2 * 6000, 20 + next_ % 7200 / 3600.0,
                        100 + next_ % 200, next_ % 90, 20 + next_ % 500 * 0.004, 20 + next_ % 300 * 0.002);
    ++next_;
    setg(line_.data(), line_.data(), line_.data() + line_.size());
    return traits_type::to_int_type(line_.front());
  }
  std::string line_;
  long rows_, next_ = 0;
};

/// Counts what is written and drops it.
class Drain : public std::streambuf {
public:
  long bytes = 0;

private:
  int_type overflow(int_type c) override {
    ++bytes;
    return c;
  }
  std::streamsize xsputn(const char*, std::streamsize n) override {
    bytes += n;
    return n;
  }
};

long resident_kB() {
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  long size = 0, resident = 0;
  if (file == nullptr) return 0;
  const int read = std::fscanf(file, "%ld %ld", &size, &resident);
  std::fclose(file);
  return read == 2 ? resident * 4 : 0;
}

TEST(CompensateStream, MemoryDoesNotGrowOverAMillionRows) {
  const auto run = [](long count) {
    Compensator fresh(nominal());
    EndlessRows source("time_s,spindle.speed_rpm,air.T_C,axis.X.position_mm,axis.B.position_deg,T_nose_C,T_bed_C\n",
                       count);
    Drain drain;
    std::istream in(&source);
    std::ostream out(&drain);
    EXPECT_EQ(compensate_stream(fresh, nominal().machine, in, "rows", out, quiet()).rows, count);
    EXPECT_GT(drain.bytes, 20 * count);
  };
  run(5000);
  const long before = resident_kB();
#ifdef __SANITIZE_ADDRESS__
  constexpr long rows = 20000;
  constexpr bool memory_is_ours = false;  // freed memory stays in the sanitizer's quarantine
#else
  constexpr long rows = 1000000;
  constexpr bool memory_is_ours = true;
#endif
  run(rows);
  if (memory_is_ours) {
    EXPECT_LT(resident_kB() - before, 2000);
  }
}

}  // namespace
}  // namespace thermotwin::compensation
