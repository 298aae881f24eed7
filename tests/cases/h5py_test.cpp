// SPDX-License-Identifier: GPL-3.0-or-later
// model.rom.h5 as another program reads it: h5py and docs/reference/result_files.md suffice for a time step.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <fstream>
#include <random>

#include "core/error.h"
#include "core/table.h"
#include "reduction/basis/reduce.h"
#include "reduction/model/model_file.h"
#include "reduction/model/reduced_simulation.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string python() {
  for (const char* name : {"python3", "/usr/bin/python3"})
    if (std::system((std::string(name) + " -c 'import h5py' >/dev/null 2>&1").c_str()) == 0) return name;
  return "";
}

TEST(H5py, RebuildsAStepOfTheProgramFromTheFileAlone) {
  if (python().empty()) GTEST_SKIP() << "no python3-h5py";
  const Toy toy;
  toy.write("loads/one_step.toml", R"(schema = 1
initial_C = 24.0
time_step_s = 90
output_s = 90
position = {X_mm = 40, Z_mm = 30}
[[phase]]
name = "one step"
duration_s = 90
air_C = 19.0
spindle_rpm = 7000
coolant = true
[[phase.axis]]
id = "X"
low_mm = -100
high_mm = 60
feed_mm_min = 9000
)");
  const std::string file = (toy_run() / "model.rom.h5").string();
  const Result run = toy.run({"campaign", toy.path(), "--reduced", "--model", file, "--load", "one_step"});
  ASSERT_EQ(run.status, 0) << run.err;
  const core::Table sensors = core::read_csv(toy.result("campaign_reduced/one_step/sensors.csv")),
                    tcp = core::read_csv(toy.result("campaign_reduced/one_step/tcp.csv"));

  // What drove the step, by the laws of machine.toml; coefficients that follow temperatures are iterated to 1e-7 K.
  const reduction::ReducedModel model = reduction::read_model(file);
  const solver::LoadProgram load = solver::LoadProgram::read(toy.file("loads/one_step.toml"), model.machine);
  reduction::RunRecord record;
  reduction::simulate_reduced(model, model.machine, load, {}, {.tell = false, .record = &record});
  ASSERT_EQ(record.steps.size(), 1U);
  const solver::Coefficients& c = record.steps[0].c;
  std::ofstream(toy.file("step.json")) << json{{"p", std::vector<double>(c.p.begin(), c.p.end())},
                                               {"q", std::vector<double>(c.q.begin(), c.q.end())},
                                               {"initial_K", record.initial_K},
                                               {"step_s", record.steps[0].length_s}};
  const std::string answer = toy.file("answer.json");
  ASSERT_EQ(std::system((python() + " " THERMOTWIN_CASES_DIR "/read_model.py '" + file + "' '" + toy.file("step.json") +
                         "' > '" + answer + "'")
                            .c_str()),
            0);
  const json read_back = json::parse(read(answer));
  EXPECT_EQ(read_back["format"], "thermotwin reduced model");
  EXPECT_EQ(read_back["order"], model.system.order());
  EXPECT_TRUE(read_back["checksums"]);

  ASSERT_EQ(sensors.rows(), 2);
  double moved = 0;
  for (Eigen::Index s = 0; s < 4; ++s) {
    const double program = sensors.values(1, 1 + s) - model.machine.reference_C - model.machine.sensors[s].offset;
    EXPECT_NEAR(read_back["sensors_K"][s], program, 1e-7);
    moved = std::max(moved, std::abs(program - record.initial_K));
  }
  EXPECT_GT(moved, 1e-4) << "a step in which nothing happens proves nothing";
  const Eigen::Index poses = tcp.rows() / 2;
  ASSERT_GE(static_cast<Eigen::Index>(read_back["tool_um"].size()), poses) << "the grid comes first";
  const char* columns[] = {"dx_um_tool",       "dy_um_tool",       "dz_um_tool",
                           "ra_um_per_m_tool", "rb_um_per_m_tool", "rc_um_per_m_tool"};
  double largest = 0;
  for (std::size_t k = 0; k < 6; ++k) {
    const Eigen::VectorXd program = tcp.column(columns[k]).tail(poses), before = tcp.column(columns[k]).head(poses);
    largest = std::max(largest, (program - before).cwiseAbs().maxCoeff());
    for (Eigen::Index i = 0; i < poses; ++i)
      EXPECT_NEAR(read_back["tool_um"][i][k], program(i), 1e-6) << columns[k] << " at pose " << i;
  }
  EXPECT_GT(largest, 1e-2);
}

// In the text of machine.toml, in HDF5's own structure, in a number: nothing may pass for another model.
TEST(ModelFile, AFlippedBitIsAnError) {
  const core::TemporaryFolder folder;
  const fs::path file = folder / "model.rom.h5";
  const std::string whole = read(toy_run() / "model.rom.h5");
  fs::copy_file(toy_run() / "model.rom.h5", file);
  std::fstream change(file, std::ios::binary | std::ios::in | std::ios::out);
  const auto put = [&](std::size_t at, char byte) { change.seekp(static_cast<std::streamoff>(at)).put(byte).flush(); };
  std::mt19937_64 random(17);
  for (int flip = 0; flip < 10; ++flip) {
    const std::size_t bit = random() % (8 * whole.size()), at = bit / 8;
    put(at, static_cast<char>(whole[at] ^ (1 << (bit % 8))));
    EXPECT_THROW(reduction::read_model(file), core::InputError) << "bit " << bit;
    const Result result = thermotwin({"compensate", file.string()}, "time_s\n0\n60\n");
    EXPECT_EQ(result.status, 3) << "bit " << bit;
    EXPECT_SAYS(result.err, "model.rom.h5");
    EXPECT_EQ(result.out, "");
    put(at, whole[at]);
  }
  EXPECT_NO_THROW(reduction::read_model(file)) << "as it was";
  // A letter of machine.toml's text.
  const std::size_t at = whole.find("body");
  ASSERT_NE(at, std::string::npos);
  put(at, static_cast<char>(whole[at] ^ 8));
  EXPECT_SAYS(thermotwin({"compensate", file.string()}, "time_s\n0\n").err, "checksum");
}

}  // namespace
}  // namespace thermotwin::cases
