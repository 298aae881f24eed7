// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/units/slurm.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "core/file.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::study {
namespace {

namespace fs = std::filesystem;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Slurm, ScriptsAreAnArrayAndAJobAfterIt) {
  const core::TemporaryFolder folder;
  SlurmJob job;
  job.name = "family";
  job.command = "'/opt/it is here/thermotwin' study variants plan.toml --out out";
  job.folder = folder.path() / "90 % of \"all\" #1";
  job.tasks = 7;
  job.hours = 26.5;
  write_slurm(job);
  const std::string array = core::read_file(job.folder / "array.sbatch");
  for (const char* line : {"#SBATCH --array=0-6\n", "#SBATCH --requeue\n", "#SBATCH --time=1-02:30:00\n",
                           "--part \"$SLURM_ARRAY_TASK_ID/7\"", "\n'/opt/it is here/thermotwin' study variants",
                           "/90 %% of \\\"all\\\" #1\"/task_%a.log\n"})
    EXPECT_TRUE(has(array, line)) << line << "\n" << array;
  EXPECT_TRUE(has(core::read_file(job.folder / "gather.sbatch"), " --gather"));
  const std::string submit = core::read_file(job.folder / "submit.sh");
  EXPECT_TRUE(has(submit, "--dependency=\"afterany:$array\""));
  EXPECT_FALSE(has(submit + array, "--wait"));
  for (const char* name : {"array.sbatch", "gather.sbatch", "submit.sh"}) {
    const std::string command = "bash -n '" + (job.folder / name).string() + "'";
    EXPECT_EQ(std::system(command.c_str()), 0) << name;
  }
}

/// The array script with a program that writes its arguments, or waits to be told to stop.
class ArrayScript : public ::testing::Test {
protected:
  int run(const std::string& program, const std::string& how) {
    core::write_file(path("program"), "#!/bin/bash\n" + program);
    core::write_file(path("scontrol"), "#!/bin/bash\necho \"$*\" >> '" + path("requeued") + "'\n");
    SlurmJob job;
    job.command = path("program") + " study variants plan";
    job.folder = folder_.path();
    job.tasks = 3;
    core::write_file(path("array.sbatch"), array_script(job));
    core::write_file(path("drive"), "cd '" + folder_.path().string() +
                                        "'\nchmod +x program scontrol\nexport PATH=$PWD:$PATH SLURM_ARRAY_TASK_ID=2 "
                                        "SLURM_ARRAY_JOB_ID=44\n" +
                                        how + "\n");
    const int status = std::system(("bash '" + path("drive") + "'").c_str());
    return WEXITSTATUS(status);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string text(const std::string& name) const { return fs::exists(path(name)) ? core::read_file(path(name)) : ""; }

private:
  core::TemporaryFolder folder_;
};

TEST_F(ArrayScript, ComputesItsPart) {
  EXPECT_EQ(run("echo \"$*\" > said", "bash array.sbatch"), 0);
  EXPECT_TRUE(has(text("said"), "study variants plan --part 2/3")) << text("said");
  EXPECT_EQ(text("requeued"), "");
}

TEST_F(ArrayScript, PassesTheStatusOfBadInputOn) {
  EXPECT_EQ(run("exit 3", "bash array.sbatch"), 3);
  EXPECT_EQ(text("requeued"), "");
}

constexpr const char* waits =
    "trap \"echo stopped > said; exit 130\" TERM\ntouch ready\nwhile true; do sleep 0.05; done\n";
constexpr const char* until_ready = "bash array.sbatch & job=$!; while [ ! -e ready ]; do sleep 0.05; done; ";

TEST_F(ArrayScript, BeforeTheTimeLimitItStopsTheProgramAndGoesBackToTheQueue) {
  EXPECT_EQ(run(waits, std::string(until_ready) + "kill -USR1 $job; wait $job"), 0);
  EXPECT_EQ(text("said"), "stopped\n");
  EXPECT_EQ(text("requeued"), "requeue 44_2\n");
}

TEST_F(ArrayScript, OnTermItStopsTheProgramAndEnds) {
  EXPECT_EQ(run(waits, std::string(until_ready) + "kill -TERM $job; wait $job"), 143);
  EXPECT_EQ(text("said"), "stopped\n");
  EXPECT_EQ(text("requeued"), "");
}

TEST_F(ArrayScript, AKilledProgramGoesBackToTheQueueThreeTimesAtMost) {
  EXPECT_EQ(run("kill -KILL $$", "bash array.sbatch"), 137);
  EXPECT_EQ(text("requeued"), "requeue 44_2\n");
  EXPECT_EQ(run("kill -KILL $$", "SLURM_RESTART_COUNT=3 bash array.sbatch"), 137);
  EXPECT_EQ(text("requeued"), "requeue 44_2\n");
}

}  // namespace
}  // namespace thermotwin::study
