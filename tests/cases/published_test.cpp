// SPDX-License-Identifier: GPL-3.0-or-later
// The composite model with three modules (Naumann et al. 2023) through `evaluate`, and the script of its superposition
// check.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <sys/wait.h>
#include <utility>
#include <vector>

#include "tests/cases/program.h"
#include "tests/cases/toy.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;

/// A machine of two lags: T8 and T9 follow the hall, M a motor beside them; the tool side moves with all three and with
/// a slow part of M that no sensor shows, the table side with the hall.
struct Specimen {
  double hall = 21, t8 = 21, t9 = 21, motor = 0, slow = 0;
  void step(double hours, bool on, double speed) {
    const double guided = hall + (on ? 2.0 : 0.0);
    t8 += (guided - t8) * (1.0 - std::exp(-hours / 2.0));
    t9 += (hall - t9) * (1.0 - std::exp(-hours / 4.0));
    motor += (speed / 1000.0 - motor) * (1.0 - std::exp(-hours / 0.5));
    slow += (motor - slow) * (1.0 - std::exp(-hours / 2.0));
  }
  double tool(double x) const { return (1.0 + x) * (-3.0 * (t9 - 21) - 1.0 * (t8 - 21)) - 2.0 * motor - 6.0 * slow; }
  double table(double x) const { return (1.0 - x) * 2.0 * (t9 - 21); }
};

struct Phase {
  double hours, hall, speed;
};
struct Experiment {
  std::string name;
  bool on;
  std::vector<Phase> phases;
};

/// A measurement folder with these experiments; the sides of two poses, or the error between them.
/// @param silent  programs whose names begin so have no readings of M, N and T8
void write_record(const fs::path& folder, const std::vector<Experiment>& experiments, bool sides,
                  const std::string& silent = "none") {
  fs::create_directories(folder);
  std::ofstream data(folder / "data.csv"), channels(folder / "channels.toml");
  const std::array<double, 2> places{0.0, 0.4};
  data << "time_s,machine.on,spindle.speed_rpm,air.T_C,M,N,T8,T9";
  const auto channel = [&](const std::string& id, const std::string& more) {
    channels << "[[channel]]\nid = \"" << id << "\"\n" << more;
  };
  channel("machine.on", "kind = \"state\"\nunit = \"1\"\ninput = \"machine.on\"\n");
  channel("spindle.speed_rpm", "kind = \"speed\"\nunit = \"rpm\"\ninput = \"spindle.speed_rpm\"\n");
  channel("air.T_C", "kind = \"temperature\"\nunit = \"degC\"\ninput = \"air.T_C\"\n");
  for (const char* id : {"M", "N", "T8", "T9"})
    channel(id, "kind = \"temperature\"\nunit = \"degC\"\nuncertainty = 0.05\n");
  const std::string of = "kind = \"displacement\"\nunit = \"um\"\nuncertainty = 0.3\nquantity = \"dz\"\npose = ";
  if (sides) {
    for (const std::string side : {"tool", "table"}) {
      for (const int p : {0, 1}) {
        const std::string id = "dz_" + side + "@" + std::to_string(p);
        data << "," << id;
        channel(id, of + (p == 0 ? "{X_mm = 0}" : "{X_mm = 400}") + "\ndirection = \"" + side + "\"\n");
      }
    }
  } else {
    data << ",dz@between";
    channel("dz@between", of + "{X_mm = 200}\n");
  }
  data << "\n";
  double time = 0;
  constexpr double step_h = 0.25;
  for (const Experiment& experiment : experiments) {
    Specimen specimen;
    const double from = time;
    const bool steady = !experiment.on;
    for (const Phase& phase : experiment.phases) {
      const double before = specimen.hall;
      const int steps = static_cast<int>(phase.hours / step_h);
      for (int i = 0; i <= steps; ++i, time += 3600 * step_h) {
        specimen.hall = steady ? phase.hall : before + (phase.hall - before) * std::min(1.0, i / 8.0);
        if (steady) specimen.t8 = specimen.t9 = phase.hall;
        const double body = specimen.t8;  // of M and N beside their heat
        data << time << "," << experiment.on << "," << phase.speed << "," << specimen.hall << ",";
        if (experiment.name.starts_with(silent))
          data << ",,";
        else
          data << body + specimen.motor << "," << body + 0.4 * specimen.motor << "," << specimen.t8;
        data << "," << specimen.t9;
        if (sides) {
          for (const double x : places) data << "," << specimen.tool(x);
          for (const double x : places) data << "," << specimen.table(x);
        } else {
          data << "," << specimen.tool(0.2) - specimen.table(0.2);
        }
        data << "\n";
        if (!steady) specimen.step(step_h, experiment.on, phase.speed);
      }
    }
    channels << "[[program]]\nname = \"" << experiment.name << "\"\nfrom_s = " << from << "\nto_s = " << time << "\n";
    time += 3 * 86400;
  }
}

const std::vector<Experiment> training{
    {"off", false, {{1, 11, 0}, {1, 21, 0}, {1, 36, 0}}},
    {"ambient_1", true, {{60, 16, 0}, {30, 21, 0}}},
    {"ambient_2", true, {{60, 22, 0}, {30, 21, 0}}},
    {"ambient_3", true, {{60, 31, 0}, {30, 21, 0}}},
    {"spindle_1", true, {{8, 21, 2000}, {8, 21, 0}}},
    {"spindle_2", true, {{8, 21, 6000}, {8, 21, 0}}},
    {"spindle_3", true, {{4, 21, 4000}, {4, 21, 1000}, {6, 21, 0}}},
};
const std::vector<Experiment> unseen{{"work", true, {{6, 21, 3000}, {6, 23, 0}, {8, 23, 5000}, {6, 21, 0}}}};

/// RMS removed by each model in the unseen program, %.
std::map<std::string, double> removed(const core::TemporaryFolder& folder, const std::string& models) {
  const Result result =
      thermotwin({"evaluate", "--data", (folder / "judged").string(), "--train-data", (folder / "training").string(),
                  "--models", models, "--check", "dz@between", "--out", (folder / "out").string(), "--json"});
  EXPECT_EQ(result.status, 0) << result.err;
  std::map<std::string, double> found;
  const nlohmann::json said = nlohmann::json::parse(result.out);
  for (const nlohmann::json& row : said.value("rows", nlohmann::json::array())) {
    if (row["part"] == "work" && row["rms_reduction_percent"].is_number())
      found[row["model"]] = row["rms_reduction_percent"];
  }
  return found;
}

TEST(ThreeModules, PredictBetweenPosesAndSidesWhatTheProgramsOfEachModuleTaught) {
  const core::TemporaryFolder folder;
  write_record(folder / "training", training, true);
  write_record(folder / "judged", unseen, false);
  const std::string own = "composite_modules_grid";
  const auto found = removed(folder, own + "," + own + ":no_delays,static_grid");
  ASSERT_TRUE(found.contains(own)) << "no prediction";
  EXPECT_GT(found.at(own), 90.0);
  // The slow part of the motor's heat is seen by delays only.
  EXPECT_LT(found.at(own + ":no_delays"), found.at(own) - 3.0);
  EXPECT_LT(found.at("static_grid"), found.at(own) - 3.0);
  // What was saved predicts the same.
  const Result again = thermotwin({"evaluate", "--data", (folder / "judged").string(), "--fitted",
                                   (folder / "out/evaluation/models.toml").string(), "--out",
                                   (folder / "again").string(), "--train-programs", "work", "--json"});
  ASSERT_EQ(again.status, 0) << again.err << again.out;
  double as_is = 0;
  const nlohmann::json of_again = nlohmann::json::parse(again.out);
  for (const nlohmann::json& row : of_again["rows"]) {
    if (row["model"] == own + "_as_is" && row["part"] == "work") as_is = row["rms_reduction_percent"];
  }
  EXPECT_NEAR(as_is, found.at(own), 1e-6);
}

TEST(ThreeModules, ARecordWithoutAKindOfProgramIsNamed) {
  const core::TemporaryFolder folder;
  write_record(folder / "training", {training.begin() + 1, training.end()}, true);
  write_record(folder / "judged", unseen, false);
  const Result result = thermotwin({"evaluate", "--data", (folder / "judged").string(), "--train-data",
                                    (folder / "training").string(), "--models", "composite_modules_grid,static_grid",
                                    "--check", "dz@between", "--out", (folder / "out").string(), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "at least one of each");
  EXPECT_SAYS(result.out, "static_grid");
}

TEST(ThreeModules, SensorsThatAreSilentAtWorkAreNamed) {
  const core::TemporaryFolder folder;
  write_record(folder / "training", training, true, "spindle");
  write_record(folder / "judged", unseen, false);
  const Result result = thermotwin({"evaluate", "--data", (folder / "judged").string(), "--train-data",
                                    (folder / "training").string(), "--models", "composite_modules_grid,static_grid",
                                    "--check", "dz@between", "--out", (folder / "out").string(), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "1 temperature of the machine with readings at work");
}

std::pair<int, std::string> superposition(const std::string& arguments, const fs::path& folder) {
  const fs::path script = fs::path(THERMOTWIN_CASES_DIR) / "../../tools/superposition";
  const fs::path log = folder / "log.txt";
  const std::string command = "THERMOTWIN_BUILD='" + fs::path(THERMOTWIN_PROGRAM).parent_path().string() +
                              "' python3 '" + script.string() + "' " + arguments + " > '" + log.string() + "' 2>&1";
  const int status = std::system(command.c_str());
  return {WEXITSTATUS(status), read(log)};
}

TEST(Superposition, TheScriptAddsTwoRunsAndHoldsThemAgainstTheThird) {
  const Toy toy;
  toy.make_affine();
  const auto load = [&](const std::string& name, const char* air, const char* speed) {
    toy.write("loads/" + name + ".toml",
              std::string("schema = 1\ntitle = \"t\"\ninitial_C = 20\ntime_step_s = 900\noutput_s = 1800\n[[phase]]\n"
                          "duration_h = 4\nair_C = ") +
                  air + "\nspindle_rpm = " + speed + "\n");
  };
  load("internal", "20", "9000");
  load("ambient", "[20, 26]", "0");
  load("both", "[20, 26]", "9000");
  const core::TemporaryFolder folder;
  const std::string out = " --pose X=60,Z=50 --out '" + (folder / "out").string() + "'";
  const auto [status, said] = superposition(toy.path() + " internal ambient both" + out, folder / "");
  ASSERT_EQ(status, 0) << said;
  std::ifstream table(folder / "out/superposition.csv");
  std::string line;
  std::getline(table, line);
  EXPECT_SAYS(line, "dz_sum_um,dz_both_um");
  double largest = 0, off = 0;
  while (std::getline(table, line)) {
    std::vector<double> row;
    for (std::size_t at = 0; at < line.size();
         at = line.find(',', at) == std::string::npos ? line.size() : line.find(',', at) + 1)
      row.push_back(std::stod(line.substr(at)));
    ASSERT_EQ(row.size(), 13U);
    for (const std::size_t k : {4U, 8U, 12U}) {
      largest = std::max(largest, std::abs(row[k]));
      off = std::max(off, std::abs(row[k] - row[k - 1]));
      EXPECT_NEAR(row[k - 1], row[k - 3] + row[k - 2], 1e-3);
    }
  }
  EXPECT_GT(largest, 1.0);
  EXPECT_LT(off, 0.1 * largest);  // but for a film that follows the spindle's speed
  EXPECT_SAYS(read(folder / "out/superposition.svg"), "</svg>");
  // Other output times cannot be added.
  toy.write("loads/other.toml",
            "schema = 1\ntitle = \"t\"\ntime_step_s = 900\noutput_s = 900\n[[phase]]\nduration_h = 2\n"
            "air_C = 20\n");
  const auto [refused, why] = superposition(toy.path() + " other ambient both" + out, folder / "");
  EXPECT_EQ(refused, 3);
  EXPECT_SAYS(why, "other: 9 rows");
}

TEST(Superposition, TheSteadyCharacteristicFollowsTheAirOfThePhases) {
  const Toy toy;
  toy.make_affine();
  toy.write("loads/steps.toml",
            "schema = 1\ntitle = \"t\"\ntime_step_s = 3600\noutput_s = 3600\n[[phase]]\nduration_h = 1\nair_C = 15\n"
            "[[phase]]\nduration_h = 1\nair_C = 25\n");
  const core::TemporaryFolder folder;
  const auto [status, said] = superposition(
      toy.path() + " --steady steps --pose X=60,Z=50 --out '" + (folder / "out").string() + "'", folder / "");
  ASSERT_EQ(status, 0) << said;
  EXPECT_SAYS(said, "| 15 |");
  EXPECT_SAYS(said, "| 25 |");
  EXPECT_SAYS(read(folder / "out/characteristic.svg"), "air, degC");
}

}  // namespace
}  // namespace thermotwin::cases
