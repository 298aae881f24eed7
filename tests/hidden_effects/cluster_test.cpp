// SPDX-License-Identifier: GPL-3.0-or-later
// The bank's program in units: its scripts for Slurm, one task after another, against the program without them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>

#include "core/file.h"
#include "reduction/basis/reduce.h"
#include "reduction/model/model_file.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "tests/core/temporary_folder.h"

namespace {

using namespace thermotwin;
namespace fs = std::filesystem;

const std::string toy = THERMOTWIN_SOURCE_DIR "/tests/cases/toy";

/// A small model of the toy.
void reduce_to(const fs::path& file) {
  const solver::Case machine_case = solver::read_case(toy);
  const solver::FullModel full = solver::build_full_model(machine_case.machine, {1.0, {}});
  std::vector<solver::LoadProgram> loads;
  for (const std::string& name : machine_case.train) loads.push_back(machine_case.load(name));
  solver::CampaignOptions with_snapshots;
  with_snapshots.keep_snapshots = true;
  reduction::ReduceOptions options;
  options.order = 40;
  reduction::write_model(file, reduction::reduce(full, loads, run_campaign(full, loads, with_snapshots), options));
}

class HiddenEffectsOnACluster : public ::testing::Test {
protected:
  void SetUp() override { reduce_to(folder_ / "model.rom.h5"); }

  /// Status of a shell command; what it says is in said().
  int shell(const std::string& command) const {
    return WEXITSTATUS(std::system((command + " >'" + path("said") + "' 2>&1").c_str()));
  }
  int bank(const std::string& out, const std::string& more) const {
    return shell("'" + std::string(THERMOTWIN_BANK) + "' --case '" + toy + "' --model '" + path("model.rom.h5") +
                 "' --out '" + path(out) + "' --cache '" + path("cache") +
                 "' --seed 7 --draws 1 --kinds source_power --clean 1 --pairs 0 --outside 0"
                 " --unseen none " +
                 more);
  }
  int job(const std::string& script, int task) const {
    return shell("cd / && SLURM_ARRAY_TASK_ID=" + std::to_string(task) + " bash '" + path("cluster/bank_7/slurm/") +
                 script + "'");
  }
  /// Without the column of seconds.
  std::string table(const std::string& out) const {
    std::istringstream lines(core::read_file(path(out + "/bank_7.tsv")));
    std::string text;
    std::ptrdiff_t left_out = -1;  // columns before that of the seconds
    for (std::string line; std::getline(lines, line);) {
      if (left_out < 0) left_out = std::count(line.begin(), line.begin() + line.find("\tseconds\t") + 1, '\t');
      std::istringstream cells(line);
      std::ptrdiff_t column = 0;
      for (std::string cell; std::getline(cells, cell, '\t'); ++column)
        if (column != left_out) text += cell + "\t";
      text += "\n";
    }
    return text;
  }
  std::string said() const { return core::read_file(path("said")); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  core::TemporaryFolder folder_;
};

TEST_F(HiddenEffectsOnACluster, TheTasksAndTheGatheringMakeTheTableOfTheProgram) {
  ASSERT_EQ(bank("alone", ""), 0) << said();
  ASSERT_EQ(bank("cluster", "--slurm"), 0) << said();
  EXPECT_NE(said().find("2 units in 2 tasks"), std::string::npos) << said();
  EXPECT_NE(core::read_file(path("cluster/bank_7/slurm/array.sbatch")).find("#SBATCH --array=0-1\n"),
            std::string::npos);
  EXPECT_EQ(job("array.sbatch", 1), 0) << said();
  EXPECT_EQ(job("gather.sbatch", 0), 3);
  EXPECT_NE(said().find("1 sets are not in the table, since they failed or have no result: source_power_0"),
            std::string::npos)
      << said();
  EXPECT_EQ(job("array.sbatch", 0), 0) << said();
  EXPECT_EQ(job("array.sbatch", 0), 0);
  EXPECT_NE(said().find("0 units computed, 1 done before"), std::string::npos) << said();
  fs::remove(path("cluster/bank_7.tsv"));
  EXPECT_EQ(job("gather.sbatch", 0), 0) << said();
  EXPECT_EQ(table("cluster"), table("alone"));
}

TEST_F(HiddenEffectsOnACluster, NothingIsMadeWhereNoUnitWasComputed) {
  EXPECT_EQ(bank("nowhere", "--gather"), 3);
  EXPECT_NE(said().find("no study was begun here"), std::string::npos) << said();
  EXPECT_FALSE(fs::exists(path("nowhere")));
}

}  // namespace
