// SPDX-License-Identifier: GPL-3.0-or-later
// `compensate` beside a control: rows in, offsets out, one for one.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "core/table.h"
#include "core/text.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

std::string inputs() { return (toy_run() / "campaign/mixed/inputs.csv").string(); }

const std::string header = "time_s,spindle.speed_rpm,axis.X.position_mm,air.T_C\n";

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

TEST(Stream, AnswersEachRowBeforeTheNext) {
  Program program({"compensate", toy_model(), "--quiet"});
  program.write(header);
  EXPECT_TRUE(program.read_line().starts_with("time_s,offset_x_um,offset_y_um,offset_z_um,"));
  for (int minute = 0; minute < 20; ++minute) {
    const std::string time = std::to_string(60 * minute);
    program.write(time + ",6000,10,20.5\n");
    EXPECT_TRUE(program.read_line().starts_with(time + ","));  // comes while the input is still open
  }
  const Result result = program.wait();
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.err, "");
}

TEST(Stream, WritesOverNothingThatItReads) {
  const Toy toy;
  const std::string rows = header + "0,6000,10,20\n60,6000,10,20\n";
  toy.write("rows.csv", rows);
  for (const char* option : {"--out", "--state", "--lines", "--learned"}) {
    std::vector<std::string> words{"compensate",         toy_model(), "--in",
                                   toy.file("rows.csv"), option,      toy.file("sub/../rows.csv")};
    std::filesystem::create_directory(toy.file("sub"));
    const Result result = thermotwin(words);
    EXPECT_EQ(result.status, 3) << option << result.err;
    EXPECT_SAYS(result.err, std::string(option) + " ");
    EXPECT_SAYS(result.err, "the file of the rows itself");
    EXPECT_EQ(read(toy.file("rows.csv")), rows) << option;
  }
  std::filesystem::copy(toy_model(), toy.file("own.rom.h5"));
  const Result model = thermotwin({"compensate", toy.file("own.rom.h5"), "--out", toy.file("own.rom.h5")}, rows);
  EXPECT_EQ(model.status, 3);
  EXPECT_SAYS(model.err, "the file of the model itself");
}

TEST(Stream, PipesAndFilesGiveTheSameBytes) {
  const Toy toy;
  const Result piped = thermotwin({"compensate", toy_model(), "--in", "-", "--out", "-"}, read(inputs()));
  EXPECT_EQ(piped.status, 0);
  EXPECT_SAYS(piped.err, "91 rows from 0 to 21600 s (6 h)");
  EXPECT_EQ(thermotwin({"compensate", toy_model(), "--in", inputs()}).out, piped.out);
  const Result filed =
      thermotwin({"compensate", toy_model(), "--in", inputs(), "--out", toy.file("offsets.csv"), "--json"});
  EXPECT_EQ(filed.status, 0);
  EXPECT_SAYS(filed.out, "\"rows\":91");
  EXPECT_EQ(read(toy.file("offsets.csv")), piped.out);
}

// The offsets undo the error of the full model on the load that was held out: at X0 Y0 Z50 B0, which
// is one of the 27 poses, while the spindle heats up.
TEST(Stream, OffsetsAreTheErrorOfTheFullModelTurnedRound) {
  const Result result = thermotwin({"compensate", toy_model(), "--in", inputs()});
  std::istringstream answers(result.out);
  const core::Table tcp = core::read_csv(toy_run() / "campaign/mixed/tcp.csv");
  const auto column = [&](const char* name) { return tcp.column(name); };
  const auto time = column("time_s"), x = column("X_mm"), y = column("Y_mm"), z = column("Z_mm"), b = column("B_deg");
  std::string line;
  std::getline(answers, line);
  ASSERT_TRUE(line.starts_with("time_s,offset_x_um,offset_y_um,offset_z_um,")) << line;
  int compared = 0;
  double largest = 0, worst = 0;
  while (std::getline(answers, line)) {
    double at = 0, offset[3] = {};
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &at, &offset[0], &offset[1], &offset[2]), 4) << line;
    if (at > 5400) break;
    for (Eigen::Index i = 0; i < time.size(); ++i) {
      if (time[i] != at || x[i] != 0 || y[i] != 0 || z[i] != 50 || b[i] != 0) continue;
      ++compared;
      const char* names[] = {"dx_um", "dy_um", "dz_um"};
      for (int k = 0; k < 3; ++k) {
        const double error = column(names[k])[i];
        largest = std::max(largest, std::abs(error));
        worst = std::max(worst, std::abs(error + offset[k]));
      }
    }
  }
  EXPECT_EQ(compared, 23);
  EXPECT_GT(largest, 20);
  EXPECT_LT(worst, 0.5);
}

// Probes of the full model's error beside sensors of which one reads a place that it is not at.
TEST(Stream, SensorsThatWorsenTheOffsetsAreNamedBesideProbes) {
  const core::Table rows = core::read_csv(inputs()), sensors = core::read_csv(toy_run() / "campaign/mixed/sensors.csv"),
                    tcp = core::read_csv(toy_run() / "campaign/mixed/tcp.csv");
  const auto time = tcp.column("time_s"), x = tcp.column("X_mm"), y = tcp.column("Y_mm"), z = tcp.column("Z_mm"),
             b = tcp.column("B_deg");
  const auto lines = [&](double wrong_K) {
    core::Table told = rows;
    const Eigen::Index first = told.values.cols();
    told.columns.insert(told.columns.end(), sensors.columns.begin() + 1, sensors.columns.end());
    for (const char* column : {"probe_dx_um", "probe_dy_um", "probe_dz_um"}) told.columns.emplace_back(column);
    told.values.conservativeResize(Eigen::NoChange, std::ssize(told.columns));
    told.values.middleCols(first, sensors.values.cols() - 1) = sensors.values.rightCols(sensors.values.cols() - 1);
    told.values.rightCols(3).setConstant(std::nan(""));
    const Eigen::VectorXd spindle = (sensors.column("time_s").array() / 5400.0).min(1.0);
    for (const char* sensor : {"T1_C", "T2_C"}) told.values.col(*told.find(sensor)) += wrong_K * spindle;
    for (Eigen::Index i = 8; i < told.rows() && told.values(i, 0) <= 5400; i += 4) {
      for (Eigen::Index k = 0; k < time.size(); ++k) {
        if (time[k] != told.values(i, 0) || x[k] != 0 || y[k] != 0 || z[k] != 50 || b[k] != 0) continue;
        told.values.row(i).tail(3) << tcp.column("dx_um")[k], tcp.column("dy_um")[k], tcp.column("dz_um")[k];
      }
    }
    return told;
  };
  const Toy toy;
  const auto said = [&](double wrong_K) {
    core::write_csv(toy.file("rows.csv"), lines(wrong_K), 12);
    const Result done =
        thermotwin({"compensate", toy_model(), "--in", toy.file("rows.csv"), "--out", toy.file("offsets.csv")});
    EXPECT_EQ(done.status, 0) << done.err;
    return done.out;
  };
  const std::string right = said(0.0), wrong = said(-6.0);
  for (const std::string& text : {right, wrong}) EXPECT_SAYS(text, "um without temperature sensors");
  EXPECT_EQ(right.find("The sensors worsen the offsets"), std::string::npos) << right;
  EXPECT_SAYS(wrong, "The sensors worsen the offsets");
}

TEST(Stream, ALineForEachAxisGoesThroughTheLastOffset) {
  const Toy toy;
  const Result done = thermotwin({"compensate", toy_model(), "--in", inputs(), "--out", toy.file("offsets.csv"),
                                  "--lines", toy.file("lines.csv"), "--axis-errors", toy.file("tables")});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_SAYS(done.err, "tables along the axes leave x ");
  std::istringstream lines(read(toy.file("lines.csv")));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "time_s,axis,reference_mm,offset_um,slope_um_per_m,left_travel_um,left_across_um");
  const std::string offsets = read(toy.file("offsets.csv"));
  const std::vector<std::string> last = cells_of(offsets.substr(offsets.rfind('\n', offsets.size() - 2) + 1));
  std::size_t column = 0;
  for (const std::string axis : {"X", "Y", "Z"}) {
    ASSERT_TRUE(std::getline(lines, line)) << axis;
    const std::vector<std::string> cells = cells_of(line);
    ASSERT_EQ(cells.size(), 7U) << line;
    EXPECT_EQ(cells[1], axis);
    EXPECT_EQ(std::stod(cells[0]), std::stod(last[0]));
    EXPECT_EQ(cells[3], last[++column]);
    EXPECT_GE(std::stod(cells[6]), 0.0);
    const core::Table table = core::read_csv(toy.file("tables/axis_" + axis + ".csv"));
    EXPECT_EQ(table.rows(), 21);
    EXPECT_NEAR(table.column("ex" + core::lower(axis) + "_um")[10], 0.0, 1e-3) << "the middle of the workspace";
  }
}

TEST(Stream, LinesAreThereBesideAControlThatWaits) {
  const Toy toy;
  Program program({"compensate", toy_model(), "--quiet", "--lines", toy.file("lines.csv"), "--lines-every", "120"});
  program.write(header);
  program.read_line();
  for (int minute = 0; minute < 4; ++minute) {
    program.write(std::to_string(60 * minute) + ",6000,10,20.5\n");
    program.read_line();
  }
  // The answer comes after the lines of its row.
  EXPECT_SAYS(read(toy.file("lines.csv")), "\n120,X,10.0000,");
  EXPECT_EQ(program.wait().status, 0);
  EXPECT_SAYS(read(toy.file("lines.csv")), "\n180,X,10.0000,");
}

TEST(Stream, LinesThatCannotBeWrittenEndNoControl) {
  const Toy toy;
  toy.write("taken", "a file where a folder should be");
  const Result done =
      thermotwin({"compensate", toy_model(), "--lines", toy.file("taken/lines.csv"), "--lines-every", "0"},
                 header + "0,6000,10,20.5\n60,6000,10,20.5\n120,6000,10,20.5\n");
  EXPECT_SAYS(done.out, "\n120,");
  const std::size_t warned = done.err.find("warning: " + toy.file("taken") + ": cannot be made");
  ASSERT_NE(warned, std::string::npos) << done.err;
  EXPECT_EQ(done.err.find("warning: ", warned + 1), std::string::npos) << "said once";
  EXPECT_EQ(done.status, 3) << "the last lines cannot be written either";
}

TEST(Stream, NoRowsLeaveNoLinesAndNoTables) {
  const Toy toy;
  const Result done = thermotwin(
      {"compensate", toy_model(), "--lines", toy.file("lines.csv"), "--axis-errors", toy.file("tables")}, header);
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_FALSE(std::filesystem::exists(toy.file("lines.csv")));
  EXPECT_FALSE(std::filesystem::exists(toy.file("tables")));
}

TEST(Stream, UnknownColumnIsRefusedBeforeAnyAnswer) {
  const Result result = thermotwin({"compensate", toy_model()}, "time_s,spindle.speed\n0,6000\n");
  EXPECT_EQ(result.status, 3);
  EXPECT_EQ(result.out, "");
  for (const char* words : {"standard input:1 column 2", "'spindle.speed'", "allowed: ", "nearest: spindle.speed_rpm"})
    EXPECT_SAYS(result.err, words);
}

/// Answers of a run: time, offsets and status of each row.
struct Answers {
  std::vector<double> time;
  std::vector<std::array<double, 3>> offset, deviation;
  std::vector<std::string> status;
};

Answers answers(const std::string& out) {
  Answers all;
  std::istringstream lines(out);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    double time = 0;
    std::array<double, 3> offset{}, deviation{};
    EXPECT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%lf", &time, &offset[0], &offset[1], &offset[2],
                          &deviation[0], &deviation[1], &deviation[2]),
              7)
        << line;
    all.time.push_back(time);
    all.offset.push_back(offset);
    all.deviation.push_back(deviation);
    all.status.push_back(line.substr(line.rfind(',') + 1));
  }
  return all;
}

// A machine at 35 degC, the axes standing: nothing goes out at once, and a row later no more than the stated rate.
TEST(Stream, AHotStartDoesNotJump) {
  std::string rows = "time_s,T1_C,T2_C,T3_C,T4_C\n";
  for (int second = 0; second < 600; ++second) rows += std::to_string(second) + ",35,35,35,35\n";
  const Result result = thermotwin({"compensate", toy_model()}, rows);
  ASSERT_EQ(result.status, 0);
  double largest = 0, rate = 0, fastest = 0;
  ASSERT_EQ(std::sscanf(result.err.c_str(), "offset limits: %lf um, %lf um/s while the axes stand, %lf", &largest,
                        &rate, &fastest),
            3)
      << result.err;
  const Answers all = answers(result.out);
  ASSERT_EQ(all.offset.size(), 600U);
  EXPECT_EQ(all.offset[0], (std::array<double, 3>{0, 0, 0}));
  EXPECT_EQ(all.status[0], "limited");
  double reached = 0;
  for (std::size_t i = 1; i < all.offset.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(std::abs(all.offset[i][k] - all.offset[i - 1][k]), 1.01 * rate + 0.001) << "row " << i;
      reached = std::max(reached, std::abs(all.offset[i][k]));
    }
  }
  EXPECT_GT(reached, 20);
  EXPECT_LE(reached, largest);
  // Stated limits hold instead.
  for (const auto& row :
       answers(thermotwin({"compensate", toy_model(), "--largest-offset", "7", "--offset-rate", "0.5"}, rows).out)
           .offset)
    for (const double value : row) EXPECT_LE(std::abs(value), 7.0);
}

// Clean readings of the full model on the load that was held out: no sensor is named, though speeds, axes and coolant
// change.
TEST(Stream, CleanReadingsAreNotNamed) {
  const core::Table in = core::read_csv(inputs()), sensors = core::read_csv(toy_run() / "campaign/mixed/sensors.csv");
  for (const int count : {4, 2}) {
    std::string rows = read(inputs());
    std::istringstream lines(rows);
    std::string line, joined;
    std::getline(lines, line);
    joined = line;
    for (int s = 0; s < count; ++s) joined += "," + sensors.columns[s + 1];
    joined += "\n";
    for (Eigen::Index i = 0; std::getline(lines, line); ++i) {
      ASSERT_EQ(in.values(i, 0), sensors.values(i, 0));
      joined += line;
      for (int s = 0; s < count; ++s) joined += "," + std::to_string(sensors.values(i, s + 1));
      joined += "\n";
    }
    const Result result = thermotwin({"compensate", toy_model()}, joined);
    for (const std::string& status : answers(result.out).status) EXPECT_EQ(status, "ok");
  }
}

/// The rows of the held-out load from a row on, with the readings of all sensors.
std::string rows_from(Eigen::Index first) {
  const core::Table sensors = core::read_csv(toy_run() / "campaign/mixed/sensors.csv");
  std::istringstream lines(read(inputs()));
  std::string line, joined;
  std::getline(lines, joined);
  for (std::size_t s = 1; s < sensors.columns.size(); ++s) joined += "," + sensors.columns[s];
  joined += "\n";
  for (Eigen::Index i = 0; std::getline(lines, line); ++i) {
    if (i < first) continue;
    joined += line;
    for (Eigen::Index s = 1; s < sensors.values.cols(); ++s) joined += "," + std::to_string(sensors.values(i, s));
    joined += "\n";
  }
  return joined;
}

// A compensator that is started beside a machine at work, or one that has just stopped: the readings are right and say
// what the machine carries. Truth are the full model's errors at X0 Y0 Z50 B0, as the offsets of its own start.
TEST(Stream, AWarmStartAccusesNoSensorAndFindsTheError) {
  const Answers cold = answers(thermotwin({"compensate", toy_model()}, rows_from(0)).out);
  for (const std::size_t first : {22, 45, 68, 72}) {
    const Answers warm = answers(thermotwin({"compensate", toy_model()}, rows_from(first)).out);
    for (const std::string& status : warm.status) EXPECT_EQ(status.find("sensor_failed"), std::string::npos) << status;
    constexpr std::size_t half_an_hour = 8;
    double truth = 0, error = 0, deviations = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double right = cold.offset[first + half_an_hour][k], off = warm.offset[half_an_hour][k] - right;
      truth += right * right;
      error += off * off;
      deviations = std::max(deviations, std::abs(off) / warm.deviation[half_an_hour][k]);
    }
    std::printf("  from row %zu: %.2f of %.2f um left after half an hour, at most %.1f stated deviations\n", first,
                std::sqrt(error), std::sqrt(truth), deviations);
    EXPECT_LT(std::sqrt(error), 0.25 * std::sqrt(truth)) << "from row " << first;
  }
}

TEST(Stream, AbsentColumnsAreNamed) {
  const Result result = thermotwin({"compensate", toy_model()}, "time_s,axis.X.position_mm,air.T_C\n0,0,20\n60,0,20\n");
  EXPECT_EQ(result.status, 0);
  EXPECT_SAYS(result.err, "inputs of the model without a column");
  EXPECT_SAYS(result.err, "spindle.speed_rpm = 0");
  EXPECT_EQ(result.err.find("air.T_C ="), std::string::npos) << result.err;
}

/// Inputs and, if wanted, sensors of the held-out program, with its spindle speed taken away: the whole column, or
/// the cells of all rows but the first.
std::string without_speed(bool column, bool sensors) {
  core::Table table = core::read_csv(inputs());
  if (sensors) {
    const core::Table readings = core::read_csv(toy_run() / "campaign/mixed/sensors.csv");
    const Eigen::Index first = table.values.cols();
    table.values.conservativeResize(Eigen::NoChange, first + readings.values.cols() - 1);
    for (Eigen::Index c = 1; c < readings.values.cols(); ++c) {
      table.columns.push_back(readings.columns[c]);
      table.values.col(first + c - 1) = readings.values.col(c).head(table.rows());
    }
  }
  const Eigen::Index at = table.find("spindle.speed_rpm").value();
  std::string rows;
  for (Eigen::Index i = -1; i < table.rows(); ++i) {
    std::string row;
    for (Eigen::Index c = 0; c < table.values.cols(); ++c) {
      if (column && c == at) continue;
      const double value = i < 0 || (c == at && i > 0) ? std::nan("") : table.values(i, c);
      row += (c == 0 ? "" : ",") + (i < 0 ? table.columns[c] : std::isnan(value) ? "" : std::to_string(value));
    }
    rows += row + "\n";
  }
  return rows;
}

// What is wrong for want of an input lies within a few of the deviations that are stated, and no sensor is blamed.
TEST(Stream, TheDeviationHoldsTheHeatOfADriveThatNobodyTells) {
  const Answers told = answers(thermotwin({"compensate", toy_model()}, read(inputs())).out);
  for (const bool sensors : {false, true}) {
    for (const bool column : {true, false}) {
      const Answers got = answers(thermotwin({"compensate", toy_model()}, without_speed(column, sensors)).out);
      ASSERT_EQ(got.time.size(), told.time.size());
      double off = 0.0, worst = 0.0, square = 0.0;
      long blamed = 0, values = 0;
      for (std::size_t i = 0; i < got.time.size(); ++i) {
        blamed += got.status[i].find('=') != std::string::npos;
        for (int k = 0; k < 3; ++k) {
          const double wrong = std::abs(got.offset[i][k] - told.offset[i][k]), share = wrong / got.deviation[i][k];
          off = std::max(off, wrong);
          worst = std::max(worst, share);
          square += share * share;
          ++values;
        }
      }
      const std::string what = fmt::format(
          "{}, {}: wrong by up to {:.1f} um, {:.1f} deviations, RMS {:.2f}", column ? "no column" : "blank cells",
          sensors ? "with sensors" : "no sensors", off, worst, std::sqrt(square / static_cast<double>(values)));
      std::printf("%s, %ld rows blame a sensor\n", what.c_str(), blamed);
      if (!sensors) {
        EXPECT_GT(off, 3.0) << "the input has to matter";
      }
      EXPECT_LT(worst, 4.0) << what;
      EXPECT_LT(square / static_cast<double>(values), 2.0) << what;
      EXPECT_EQ(blamed, 0) << what;
    }
  }
}

// No unit and no single wild reading gets into the model, nor is the good sensor blamed.
TEST(Stream, TemperaturesThatCannotBeAreNamedAndLeftOut) {
  const auto run = [](const std::string& readings) {
    std::string rows = "time_s,T1_C,T2_C,T3_C,T4_C\n";
    for (int minute = 0; minute < 300; ++minute) rows += std::to_string(60 * minute) + "," + readings + "\n";
    return answers(thermotwin({"compensate", toy_model()}, rows).out);
  };
  const double usual = std::abs(run("20,20,20,20").offset.back()[2]);
  const std::pair<const char*, const char*> all[] = {
      {"293.15,293.15,293.15,293.15", "sensor_failed T1=kelvin T2=kelvin T3=kelvin T4=kelvin"},
      {"68,68,68,68", "sensor_failed T1=fahrenheit T2=fahrenheit T3=fahrenheit T4=fahrenheit"},
      {"20,-253.15,,", "sensor_failed T2=implausible"},
      {"20,293.15,,", "sensor_failed T2=kelvin"},
      {"1e9,20,20,20", "sensor_failed T1=implausible"},
  };
  for (const auto& [readings, named] : all) {
    const Answers got = run(readings);
    for (const std::string& status : got.status) EXPECT_EQ(status, named);
    for (const auto& row : got.offset)
      for (const double value : row) EXPECT_LE(std::abs(value), usual + 8.0) << readings;
  }
  const Answers air = answers(thermotwin({"compensate", toy_model()}, "time_s,air.T_C\n0,293.15\n60,20\n").out);
  EXPECT_EQ(air.status, (std::vector<std::string>{"input_missing air.T_C=kelvin", "no_sensors"}));
  const std::string all_kelvin = "time_s,air.T_C,T1_C,T2_C\n0,293.15,293.15,293.15\n60,20,293.15,20\n";
  EXPECT_EQ(answers(thermotwin({"compensate", toy_model()}, all_kelvin).out).status,
            (std::vector<std::string>{"input_missing air.T_C=kelvin T1=kelvin T2=kelvin", "sensor_failed T1=kelvin"}));
}

TEST(Stream, GoesOnAfterACellThatCannotBeRead) {
  const std::string rows = header + "0,6000,10,20\n60,fast,10,20\n120,6000,10\n180,6000,10,20\n";
  const Toy toy;
  const Result result = thermotwin({"compensate", toy_model()}, rows);
  EXPECT_EQ(result.status, 0);
  const Answers all = answers(result.out);
  ASSERT_EQ(all.status.size(), 4U);
  EXPECT_EQ(all.status[0], "no_sensors");
  EXPECT_EQ(all.status[1], "input_missing spindle.speed_rpm=unreadable");
  EXPECT_EQ(all.status[2], "input_missing row=unreadable");
  EXPECT_EQ(all.time[2], 60);
  EXPECT_EQ(all.status[3], "no_sensors");
  for (const char* words :
       {"standard input:3 spindle.speed_rpm: 'fast'", "standard input:4: 3 cells", "2 of them partly unreadable",
        "; status input_missing row=unreadable in 1 rows, input_missing "})
    EXPECT_SAYS(result.err, words);
  const Result filed = thermotwin({"compensate", toy_model(), "--out", toy.file("offsets.csv"), "--json"}, rows);
  EXPECT_EQ(filed.status, 0);
  EXPECT_SAYS(filed.out, "\"unreadable\":2");
  EXPECT_SAYS(filed.out, "\"input_missing row=unreadable\":1");
  EXPECT_EQ(read(toy.file("offsets.csv")), result.out);
}

// A failed reading is named at once; a row that says nothing new is not.
TEST(Stream, NanIsABlankCellWithAMessage) {
  const auto run = [](const std::string& missing) {
    std::string rows = "time_s,spindle.speed_rpm,air.T_C,T1_C,T2_C\n0,6000,20,20,20\n";
    for (int minute = 1; minute <= 12; ++minute)
      rows += fmt::format("{},{},20,20,{}\n", 60 * minute, minute < 8 ? missing : "6000", minute < 8 ? missing : "20");
    return thermotwin({"compensate", toy_model()}, rows);
  };
  const Result nan = run("nan"), blank = run("");
  EXPECT_EQ(nan.status, 0);
  EXPECT_EQ(nan.out, blank.out);
  const Answers all = answers(nan.out);
  ASSERT_EQ(all.status.size(), 13U);
  EXPECT_EQ(all.status[5].find("input_missing"), std::string::npos) << "300 s";
  EXPECT_EQ(all.status[6], "input_missing T1=stuck T2=absent");
  EXPECT_EQ(all.status[7], "input_missing T1=stuck T2=absent");
  EXPECT_EQ(all.status[8].find("input_missing"), std::string::npos);
  for (const char* words : {"warning: standard input:3: spindle.speed_rpm is nan; this counts as a blank cell",
                            "warning: standard input:3: T2_C is nan", "after 300 s it is named absent"}) {
    EXPECT_SAYS(nan.err, words);
    EXPECT_EQ(nan.err.find(words), nan.err.rfind(words)) << "said once";
    EXPECT_EQ(blank.err.find(words), std::string::npos);
  }
  for (const Result* one : {&nan, &blank}) {
    const std::string words =
        "standard input:8: spindle.speed_rpm has had no value for more than 300 s; its last value holds";
    EXPECT_SAYS(one->err, words);
    EXPECT_EQ(one->err.find(words), one->err.rfind(words)) << "said once";
  }
  const Result never = thermotwin({"compensate", toy_model()}, "time_s,spindle.speed_rpm\n0,nan\n60,\n120,inf\n");
  EXPECT_SAYS(never.err, "standard input:2: spindle.speed_rpm has had no value in these rows");
  EXPECT_EQ(answers(never.out).status,
            (std::vector<std::string>{"input_missing", "input_missing", "input_missing spindle.speed_rpm=unreadable"}));
}

TEST(Stream, ASpeedBeyondTheSpindleIsMissing) {
  const std::string rows = header + "0,6000,10,20\n60,15000,10,20\n120,-6000,10,20\n180,6000,500,20\n";
  const Toy toy;
  const Result result = thermotwin({"compensate", toy_model(), "--out", toy.file("offsets.csv"), "--json"}, rows);
  EXPECT_EQ(result.status, 0);
  EXPECT_SAYS(result.err, "standard input:3: spindle.speed_rpm = 15000");
  for (const char* words : {"\"unreadable\":2", "\"input_missing spindle.speed_rpm=beyond_12000\":1",
                            "\"input_missing axis.X.position_mm=beyond_120\":1"})
    EXPECT_SAYS(result.out, words);
  const Answers all = answers(read(toy.file("offsets.csv")));
  ASSERT_EQ(all.status.size(), 4U);
  EXPECT_EQ(all.status[2], "no_sensors");
  EXPECT_EQ(thermotwin({"compensate", toy_model(), "--strict"}, rows).status, 3);
}

TEST(Stream, ALineWithoutEndIsRefused) {
  const Result result = thermotwin({"compensate", toy_model()}, "time_s\n0\n" + std::string(3000000, '7'));
  EXPECT_EQ(result.status, 3);
  for (const char* words : {"standard input:3", "more than 262143 characters", "allowed: "})
    EXPECT_SAYS(result.err, words);
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 2);
}

TEST(Stream, RowsOfAnotherMachineAreNoticed) {
  const std::string rows = header + "0,6000,10,20\n60,6000,10,20\n";
  const Result unnamed = thermotwin({"compensate", toy_model()}, rows);
  const std::string words = "begin with '";
  const std::size_t at = unnamed.err.find(words);
  ASSERT_NE(at, std::string::npos) << unnamed.err;
  const std::string own =
      unnamed.err.substr(at + words.size(), unnamed.err.find("'", at + words.size()) - at - words.size());
  ASSERT_TRUE(own.starts_with("# machine toy ")) << own;
  const Result named = thermotwin({"compensate", toy_model()}, own + "\n" + rows);
  EXPECT_EQ(named.status, 0);
  EXPECT_EQ(named.out, unnamed.out);
  EXPECT_EQ(named.err.find("does not name"), std::string::npos);
  const Result other = thermotwin({"compensate", toy_model()}, "# machine vmc5 0123456789abcdef\n" + rows);
  EXPECT_EQ(other.status, 3);
  EXPECT_EQ(other.out, "");
  for (const char* said : {"standard input:1", "'vmc5'", own.c_str()}) EXPECT_SAYS(other.err, said);
  const Result changed = thermotwin({"compensate", toy_model()}, "# machine toy 0123456789abcdef\n" + rows);
  EXPECT_EQ(changed.status, 0);
  EXPECT_SAYS(changed.err, "warning: standard input:1");
  EXPECT_EQ(thermotwin({"compensate", toy_model(), "--strict"}, "# machine toy 0123456789abcdef\n" + rows).status, 3);
}

TEST(Stream, ABadRowEndsAStrictStreamAfterTheAnswersBeforeIt) {
  struct Bad {
    std::string row;
    std::vector<std::string> said;
  };
  const std::vector<Bad> all = {
      {"180,fast,10,20\n", {"standard input:5 spindle.speed_rpm", "'fast'"}},
      {"180,6000,10\n", {"standard input:5", "3 cells", "4, one for each column"}},
      {"60,6000,10,20\n", {"standard input:5", "runs backwards: 60 s after 120 s"}},
      {",6000,10,20\n", {"standard input:5", "no time_s"}},
      {"180,inf,10,20\n", {"standard input:5 spindle.speed_rpm", "'inf'"}},
  };
  const Toy toy;
  for (const Bad& bad : all) {
    const std::string rows = header + "0,6000,10,20\n60,6000,10,20\n120,6000,,nan\n" + bad.row + "240,6000,10,20\n";
    const Result result = thermotwin({"compensate", toy_model(), "--strict"}, rows);
    EXPECT_EQ(result.status, 3);
    EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 4) << result.out;
    EXPECT_SAYS(result.err, "allowed: ");
    for (const std::string& words : bad.said) EXPECT_SAYS(result.err, words);

    // A file would look complete: it is not written at all.
    toy.write("offsets.csv", "earlier\n");
    EXPECT_EQ(thermotwin({"compensate", toy_model(), "--strict", "--out", toy.file("offsets.csv")}, rows).status, 3);
    EXPECT_EQ(read(toy.file("offsets.csv")), "earlier\n");
  }
}

TEST(Stream, NoRowsAtAll) {
  const Result empty = thermotwin({"compensate", toy_model()}, "");
  EXPECT_EQ(empty.status, 3);
  EXPECT_SAYS(empty.err, "no header");
  const Result only_names = thermotwin({"compensate", toy_model()}, "time_s\n");
  EXPECT_EQ(only_names.status, 0);
  EXPECT_EQ(std::count(only_names.out.begin(), only_names.out.end(), '\n'), 1);
}

TEST(Stream, WhatIsMissingIsSaid) {
  EXPECT_EQ(thermotwin({"compensate", toy_model(), "--in", "/nowhere/rows.csv"}).status, 3);
  const Toy toy;
  toy.write("cut.rom.h5", read(toy_model()).substr(0, 200000));
  const Result cut = thermotwin({"compensate", toy.file("cut.rom.h5")}, "time_s\n");
  EXPECT_EQ(cut.status, 3);
  EXPECT_SAYS(cut.err, "cut.rom.h5");
}

}  // namespace
}  // namespace thermotwin::cases
