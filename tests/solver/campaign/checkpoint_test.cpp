// SPDX-License-Identifier: GPL-3.0-or-later
// A run that is stopped anywhere goes on with the same bits.
#include "solver/campaign/checkpoint.h"

#include <gtest/gtest.h>

#include <cstring>
#include <iterator>
#include <unistd.h>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "solver/campaign/adaptive_simulation.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "solver/thermal/adaptive.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/integrator.h"
#include "tests/machines/box_machine.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::solver {
namespace {

struct Killed {};

class CheckpointTest : public ::testing::Test {
protected:
  CheckpointTest()
      : folder_(std::filesystem::temp_directory_path() / ("thermotwin_checkpoint_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    core::set_quiet(true);
  }
  ~CheckpointTest() override {
    core::set_quiet(false);
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  std::filesystem::path folder_;
};

bool same_bits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0;
}

struct Rig {
  Rig() {
    machine.coolants[0].control = mesh::ChillerControl::two_point;
    machine.coolants[0].time_constant = 300;
    mesh = test::slide_mesh(1, machine);
    system = assemble_thermal(mesh);
  }
  LoadProgram program(const std::string& time, int air) const {
    return LoadProgram::parse("schema = 1\noutput_s = 300\ntime_step_s = 60\n" + time +
                                  "[[phase]]\nduration_s = 1500\nspindle_rpm = 9000\nair_C = [20, " +
                                  std::to_string(air) +
                                  "]\n[[phase]]\nduration_s = 1800\nspindle_rpm = 0\ncutting_fluid = true\n",
                              "p.toml", machine);
  }
  /// States at all outputs; kills the run at its n-th output if asked to.
  Eigen::MatrixXd run(const std::vector<const LoadProgram*>& block, Checkpoint* checkpoint, int kill_at,
                      double* resumed = nullptr) const {
    const OperatingModel model(machine, system.layout);
    SimulationOptions options;
    options.progress = false;
    options.checkpoint = checkpoint;
    const auto loads = std::ssize(block);
    Eigen::MatrixXd states = Eigen::MatrixXd::Zero(system.size, loads * std::ssize(block.front()->output_times()));
    Eigen::Index filled = 0;
    if (checkpoint) {
      checkpoint->save_rest = [&](core::BinaryWriter& out) { out.matrix(states); };
      checkpoint->load_rest = [&](core::BinaryReader& in) { states = in.matrix(); };
    }
    const auto record = [&](const OutputState& out) {
      if (kill_at >= 0 && filled++ == kill_at) throw Killed();
      states.col(out.index * loads + out.load) = out.state;
    };
    RunSummary summary;
    if (block.front()->time().scheme == TimeScheme::adaptive) {
      AdaptiveIntegrator integrator(system);
      summary = simulate_adaptive(integrator, model, *block.front(), options, record);
    } else {
      ThermalIntegrator integrator(system);
      summary = simulate(integrator, model, block, options, record);
    }
    if (resumed) *resumed = summary.resumed_at;
    return states;
  }
  mesh::Machine machine = test::slide_machine();
  mesh::MachineMesh mesh;
  ThermalSystem system;
};

}  // namespace

TEST_F(CheckpointTest, KilledRunsGoOnWithTheSameBits) {
  const Rig rig;
  const LoadProgram warm = rig.program("", 26), cold = rig.program("", 15),
                    adaptive = rig.program("[time]\ntolerance_K = 0.002\n", 26);
  const std::vector<std::vector<const LoadProgram*>> blocks{{&warm, &cold}, {&adaptive}};
  for (const auto& block : blocks) {
    const Eigen::MatrixXd whole = rig.run(block, nullptr, -1);
    for (int kill_at : {1, 5, 10}) {
      const auto path = folder_ / "checkpoint.bin";
      Checkpoint first(path, "0123456789abcdef", {"p"}, 0.05, false);
      EXPECT_THROW(rig.run(block, &first, kill_at), Killed);
      Checkpoint second(path, "0123456789abcdef", {"p"}, 1e9, true);
      double resumed = 0.0;
      EXPECT_TRUE(same_bits(rig.run(block, &second, -1, &resumed), whole)) << kill_at;
      if (kill_at > 4) {
        EXPECT_GT(resumed, 0.0);
      }
    }
  }
}

TEST_F(CheckpointTest, StaleAndDamagedFilesAreNotUsed) {
  const auto path = folder_ / "checkpoint.bin";
  Checkpoint writer(path, "0123456789abcdef", {"a", "b"}, 0.0, false);
  writer.write([](core::BinaryWriter& out) { out.number(3.5); });
  const auto restore = [&](const std::string& hash, bool resume = true) {
    double value = 0.0;
    const bool done =
        Checkpoint(path, hash, {"a", "b"}, 0.0, resume).restore([&](core::BinaryReader& in) { value = in.number(); });
    return done ? value : -1.0;
  };
  EXPECT_EQ(restore("0123456789abcdef"), 3.5);
  EXPECT_EQ(restore("fedcba9876543210"), -1.0);
  EXPECT_EQ(restore("0123456789abcdef", false), -1.0);
  EXPECT_EQ(Checkpoint::owner(path)->members, (std::vector<std::string>{"a", "b"}));
  std::string bytes = core::read_file(path);
  bytes.back() ^= 1;
  core::write_file(path, bytes);
  EXPECT_EQ(restore("0123456789abcdef"), -1.0);
  core::write_file(path, bytes.substr(0, bytes.size() / 2));
  EXPECT_EQ(restore("0123456789abcdef"), -1.0);
  core::write_file(path, "something else");
  EXPECT_EQ(restore("0123456789abcdef"), -1.0);
  EXPECT_FALSE(Checkpoint::owner(path));
  writer.remove();
  EXPECT_EQ(restore("0123456789abcdef"), -1.0);
}

TEST_F(CheckpointTest, AKilledCampaignGoesOnWithTheSameBits) {
  mesh::MachineMesh mesh = test::box_machine_mesh();
  ThermalSystem thermal = assemble_thermal(mesh);
  ElasticModel elastic(mesh, thermal);
  const FullModel full{std::move(mesh), std::move(thermal), std::move(elastic)};
  const auto program = [&](const std::string& name, const std::string& text) {
    return LoadProgram::parse(
        "schema = 1\noutput_s = 300\ntime_step_s = 60\n" + text + "[[phase]]\nduration_s = 1800\nair_C = [20, 26]\n",
        name + ".toml", full.mesh.machine);
  };
  const std::vector<LoadProgram> loads{program("a", ""), program("b", "initial_C = 25\n"), program("c", "[time]\n")};
  CampaignOptions options;
  options.keep_snapshots = true;
  options.field_modes = 3;
  options.out = folder_ / "whole";
  run_campaign(full, loads, options);
  options.out = options.checkpoints = folder_ / "out";
  options.checkpoint_s = 0.0;
  // Killed again and again: within the block of a and b, between their results, within c.
  for (int kill_at : {5, 2, 9, 3}) {
    int outputs = 0;
    options.on_output = [&](const LoadProgram&, const OutputState&) {
      if (outputs++ == kill_at) throw Killed();
    };
    EXPECT_THROW(run_campaign(full, loads, options), Killed) << kill_at;
    options.resume = true;
  }
  options.on_output = nullptr;
  const auto expect_same_files = [&] {
    for (const char* load : {"a", "b", "c"}) {
      for (const char* file :
           {"tcp.csv", "sensors.csv", "inputs.csv", "heat.csv", "snapshots.bin", "fields.bin", "done"}) {
        EXPECT_EQ(core::content_hash(core::read_file(folder_ / "out" / load / file)),
                  core::content_hash(core::read_file(folder_ / "whole" / load / file)))
            << load << " " << file;
      }
    }
  };
  run_campaign(full, loads, options);
  expect_same_files();
  // Nothing is left but results.
  for (const auto& entry : std::filesystem::directory_iterator(options.out))
    EXPECT_TRUE(entry.is_directory()) << entry.path();

  // A block whose results were half written: its other load does not run alone.
  int outputs = 0;
  options.resume = false;
  options.on_output = [&](const LoadProgram&, const OutputState&) {
    if (outputs++ == 13) throw Killed();  // the last output of b
  };
  EXPECT_THROW(run_campaign(full, loads, options), Killed);
  options.resume = true;
  options.on_output = nullptr;
  run_campaign(full, loads, options);
  expect_same_files();
}

// `reduce` keeps all temperatures of a load and no fields; a campaign beside it need not run the load again.
TEST_F(CheckpointTest, FieldsComeFromSnapshotsWithTheSameBits) {
  mesh::MachineMesh mesh = test::box_machine_mesh();
  ThermalSystem thermal = assemble_thermal(mesh);
  ElasticModel elastic(mesh, thermal);
  const FullModel full{std::move(mesh), std::move(thermal), std::move(elastic)};
  const std::vector<LoadProgram> loads{LoadProgram::parse(
      "schema = 1\noutput_s = 60\ntime_step_s = 60\n[[phase]]\nduration_s = 6000\nair_C = [20, 26]\n", "a.toml",
      full.mesh.machine)};
  CampaignOptions fresh;
  fresh.field_modes = 3;
  const LoadFields expected = run_campaign(full, loads, fresh).front().fields;
  ASSERT_EQ(expected.coefficients.cols(), LoadFields::most_times);
  CampaignOptions options;
  options.keep_snapshots = true;
  options.out = folder_ / "out";
  run_campaign(full, loads, options);
  options.keep_snapshots = false;
  options.field_modes = 3;
  options.resume = true;
  options.on_output = [](const LoadProgram&, const OutputState&) { FAIL() << "a finished load was run again"; };
  const LoadFields found = run_campaign(full, loads, options).front().fields;
  EXPECT_TRUE(same_bits(found.modes, expected.modes));
  EXPECT_TRUE(same_bits(found.coefficients, expected.coefficients));
  // Damaged temperatures are not taken for those of the load.
  const auto file = folder_ / "out/a/snapshots.bin";
  const std::string whole = core::read_file(file);
  std::string damaged = whole;
  damaged[damaged.size() - 1] ^= 0x40;
  core::write_file(file, damaged);
  int outputs = 0;
  options.keep_snapshots = true;
  options.on_output = [&](const LoadProgram&, const OutputState&) { ++outputs; };
  run_campaign(full, loads, options);
  EXPECT_GT(outputs, 0);
  EXPECT_EQ(core::read_file(file), whole);
}

}  // namespace thermotwin::solver
