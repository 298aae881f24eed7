// SPDX-License-Identifier: GPL-3.0-or-later
// `study campaign` and `study validate`: units in any order, stopped or failed, against the verbs that they are of.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <csignal>
#include <cstdlib>
#include <fstream>

#include "core/file.h"
#include "tests/cases/program.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Words = std::vector<std::string>;
using Files = std::map<std::string, std::string>;

Words joined(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// The first file or folder of the name below the folder.
fs::path find(const fs::path& folder, const std::string& name) {
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(folder, ignored))
    if (entry.path().filename() == name) return entry.path();
  return {};
}

/// A study of the toy and the verb that it is of.
class UnitsOf : public ::testing::Test {
protected:
  void is(const std::string& verb, const Words& options) {
    verb_ = verb;
    plain_ = joined({verb, toy_.path(), "--json", "--quiet"}, options);
    study_ = joined({"study"}, plain_);
  }
  Result plain() const { return toy_.run(plain_); }
  Result study(const Words& more = {}) const { return toy_.run(joined(study_, more)); }
  fs::path folder() const { return toy_.result("study/" + verb_); }

  /// Stops the study by SIGTERM once it has left this checkpoint.
  void stop_at(const std::string& name) const {
    Program program(joined(study_, {"--checkpoint-every", "0", "--out", toy_.out()}));
    fs::path checkpoint;
    while (checkpoint.empty() && program.is_running()) {
      checkpoint = find(folder() / "units", name);
      program.ends_within(0.002);
    }
    program.send(SIGTERM);
    const Result stopped = program.wait();
    EXPECT_EQ(stopped.status, 130) << stopped.err;
    EXPECT_TRUE(fs::exists(checkpoint)) << checkpoint;
  }

  Toy toy_;

private:
  std::string verb_;
  Words plain_, study_;
};

/// Studies whose --out is renamed while they run, as if a share were no longer mounted.
class LostFolder : public UnitsOf {
protected:
  void SetUp() override { toy_.edit("loads/warm_up.toml", "time_step_s = 120", "time_step_s = 20"); }

  /// Renames --out once the study has left this checkpoint. @param more  words of the study  @param later  s
  Result renamed_at(const std::string& checkpoint, const Words& more, double later = 0.0) const {
    fs::remove(find(toy_.out(), checkpoint));
    Program program(joined(more, {"--quiet", "--out", toy_.out()}));
    while (find(toy_.out(), checkpoint).empty() && program.is_running()) program.ends_within(0.002);
    program.ends_within(later);
    fs::rename(toy_.out(), away());
    return program.wait();
  }
  void expect_refused(const Result& of) const {
    EXPECT_EQ(of.status, 3) << of.err;
    EXPECT_SAYS(of.err, toy_.out() + ": the folder has gone away");
    EXPECT_FALSE(fs::exists(toy_.out()));
    EXPECT_EQ(find(away() / "study", "done"), fs::path());
  }
  fs::path away() const { return fs::path(toy_.out()).parent_path() / "away"; }
};

TEST_F(LostFolder, IsNotMadeAnewByVariants) {
  toy_.write("../plan.toml",
             "schema = 1\ncase = \"toy\"\nloads = [\"warm_up\"]\nsamples = 4\nblock = 2\n[[parameter]]\n"
             "kind = \"source_power\"\nwhere = \"*\"\n");
  const Words words{"study", "variants", toy_.file("../plan.toml")};
  // Found by the tables of a unit, and by its checkpoints.
  expect_refused(renamed_at("checkpoint.bin", joined(words, {"--checkpoint-every", "1000"})));
  fs::rename(away(), toy_.out());
  expect_refused(renamed_at("checkpoint.bin", joined(words, {"--part", "0/1", "--checkpoint-every", "0"})));
  // Back in its place, it goes on.
  fs::rename(away(), toy_.out());
  EXPECT_EQ(toy_.run(joined(words, {"--quiet"})).status, 0);
  // Of another study by now.
  Program program(joined(words, {"--quiet", "--out", toy_.out() + "2", "--checkpoint-every", "0"}));
  const fs::path note = toy_.out() + "2/study/plan/plan.path";
  while (find(toy_.out() + "2", "checkpoint.bin").empty() && program.is_running()) program.ends_within(0.002);
  std::ofstream(note) << "/another/plan.toml\n";
  const Result other = program.wait();
  EXPECT_EQ(other.status, 3);
  EXPECT_SAYS(other.err, note.string() + " is missing or another");
}

TEST_F(LostFolder, IsNotMadeAnewByCampaign) {
  expect_refused(renamed_at("checkpoint_warm_up.bin", {"study", "campaign", toy_.path(), "--load", "warm_up"}));
}

TEST_F(LostFolder, IsNotMadeAnewByValidate) {
  expect_refused(renamed_at("checkpoint_mixed.bin", {"study", "validate", toy_.path(), "--model", toy_model(),
                                                     "--draws", "1", "--load", "mixed", "--checkpoint-every", "0"}));
}

TEST_F(LostFolder, IsNotMadeAnewByChoices) {
  toy_.take_results();
  const Words before_results[] = {{"study", "sensors", toy_.path(), "--load", "warm_up", "--spacing", "80"},
                                  {"study", "tests", toy_.path(), "--model", toy_model(), "--hours", "6"}};
  for (const Words& words : before_results) {
    expect_refused(renamed_at("plan.path", words, 0.05));
    EXPECT_EQ(find(away() / "study", "report.html"), fs::path());
    fs::rename(away(), toy_.out());
  }
}

TEST_F(LostFolder, IsNotGathered) {
  toy_.write("../plan.toml", "schema = 1\ncase = \"toy\"\n");
  for (const Words& words :
       {Words{"study", "variants", toy_.file("../plan.toml")}, Words{"study", "campaign", toy_.path()},
        Words{"study", "validate", toy_.path(), "--model", toy_model()}}) {
    const Result made = toy_.run(joined(words, {"--gather", "--quiet"}));
    EXPECT_EQ(made.status, 3) << words[1];
    EXPECT_SAYS(made.err, "no study was begun here");
    EXPECT_FALSE(fs::exists(toy_.out())) << words[1];
  }
}

/// Studies for which the disk or the memory is too little.
class TooLittle : public ::testing::Test {
protected:
  void SetUp() override {
    toy_.write("../plan.toml",
               "schema = 1\ncase = \"toy\"\nloads = [\"warm_up\"]\nsamples = 1000\nblock = 1000\n[[parameter]]\n"
               "kind = \"source_power\"\nwhere = \"*\"\n");
  }
  std::vector<Words> studies() const {
    return {{"study", "variants", toy_.file("../plan.toml")},
            {"study", "campaign", toy_.path()},
            {"study", "validate", toy_.path(), "--model", toy_model(), "--draws", "20"}};
  }
  bool has_units() const { return !find(toy_.out(), "units").empty(); }
  /// A shell command for the program, on a file system of 128 KiB.
  static Result on_small_disk(const Words& words, const fs::path& disk) {
    std::string command = "mount -t tmpfs -o size=128k none '" + disk.string() + "' || exit 77; '";
    command += THERMOTWIN_PROGRAM;
    for (const std::string& word : words) command += "' '" + word;
    command += "' --out '" + disk.string() + "/out' --quiet 2>'" + disk.string() + ".said'; status=$?; find '" +
               disk.string() + "' -name units >>'" + disk.string() + ".said'; exit $status";
    core::write_file(disk.string() + ".sh", command);
    const std::string all = "unshare -rm bash '" + disk.string() + ".sh' 2>/dev/null";
    Result result;
    result.status = WEXITSTATUS(std::system(all.c_str()));
    if (result.status == 3) result.err = read(disk.string() + ".said");
    return result;
  }

  Toy toy_;
};

TEST_F(TooLittle, DiskIsSaidBeforeTheFirstUnit) {
  const core::TemporaryFolder folder;
  fs::create_directories(folder / "disk");
  if (std::system("unshare -rm true 2>/dev/null") != 0) GTEST_SKIP() << "no namespaces of one's own here";
  for (const Words& words : studies()) {
    for (const Words& more : {Words{"--local"}, Words{"--slurm"}, Words{"--part", "0/1"}}) {
      const Result made = on_small_disk(joined(words, more), folder / "disk");
      EXPECT_EQ(made.status, 3) << words[1] << more[0];
      EXPECT_SAYS(made.err, "the tables take ") << words[1] << more[0];
      EXPECT_EQ(made.err.find("units"), std::string::npos) << made.err;
    }
  }
}

TEST_F(TooLittle, MemoryOfATaskIsSaidBeforeTheScripts) {
  for (const Words& words : studies()) {
    const Result made = toy_.run(joined(words, {"--slurm", "--task-memory", "0.01", "--quiet"}));
    EXPECT_EQ(made.status, 3) << words[1];
    EXPECT_SAYS(made.err, "--task-memory: ");
    EXPECT_SAYS(made.err, "0.01 GiB of memory are available") << words[1];
    EXPECT_EQ(find(toy_.out(), "submit.sh"), fs::path()) << words[1];
  }
  const Result enough = toy_.run(joined(studies().front(), {"--slurm", "--task-memory", "64", "--quiet"}));
  EXPECT_EQ(enough.status, 0) << enough.err;
}

TEST_F(TooLittle, MemoryIsSaidBeforeTheFirstUnit) {
  toy_.edit("../plan.toml", "samples", "size = \"0.25\"\nsamples");
  Surroundings small;
  small.memory = std::uint64_t{1500} << 20;
  for (const Words& more : {Words{"--local"}, Words{"--part", "0/1"}}) {
    const Result made = toy_.run(joined(studies().front(), joined(more, {"--quiet", "--threads", "1"})), small);
    EXPECT_EQ(made.status, 3) << made.err;
    EXPECT_SAYS(made.err, "1000 variants of ");
    EXPECT_SAYS(made.err, "GiB of memory are available");
    EXPECT_FALSE(has_units());
  }
}

TEST_F(TooLittle, FinishedUnitsNeedNothing) {
  toy_.edit("../plan.toml", "samples = 1000", "samples = 2");
  const Words words = joined(studies().front(), {"--quiet"});
  ASSERT_EQ(toy_.run(words).status, 0);
  const Result again = toy_.run(joined(words, {"--slurm", "--task-memory", "0.01"}));
  EXPECT_EQ(again.status, 0) << again.err;
}

class StudyCampaign : public UnitsOf {
protected:
  void SetUp() override {
    // Of the times of `ambient`: both are one unit.
    toy_.write("loads/again.toml", read(toy_.file("loads/ambient.toml")));
    toy_.edit("loads/again.toml", "air_C = [20, 26]", "air_C = [20, 23]");
    is("campaign", {"--load", "ambient", "--load", "warm_up", "--load", "again"});
  }
  /// Files of the plain verb, which are then removed.
  Files of_the_verb() const {
    const Result made = plain();
    EXPECT_EQ(made.status, 0) << made.err;
    Files files = files_in(toy_.result("campaign"));
    EXPECT_EQ(files.count("again/tcp.csv"), 1U);
    fs::remove_all(toy_.result("campaign"));
    return files;
  }
};

TEST_F(StudyCampaign, UnitsInAnyOrderGiveTheFilesOfTheVerb) {
  const Files files = of_the_verb();
  const Result scripts = study({"--slurm"});
  ASSERT_EQ(scripts.status, 0) << scripts.err;
  EXPECT_EQ(json::parse(scripts.out)["tasks"], 2);
  EXPECT_SAYS(read(folder() / "slurm/array.sbatch"), "#SBATCH --array=0-1\n");
  EXPECT_FALSE(fs::exists(folder() / "units"));

  // The scripts as they are, the last task first.
  const std::string said = (folder() / "said").string();
  const auto job = [&](const std::string& script, int task) {
    const std::string command = fmt::format("cd / && SLURM_ARRAY_TASK_ID={} bash '{}/slurm/{}' >/dev/null 2>'{}'", task,
                                            folder().string(), script, said);
    return WEXITSTATUS(std::system(command.c_str()));
  };
  EXPECT_EQ(job("array.sbatch", 1), 0) << read(said);
  EXPECT_FALSE(fs::exists(toy_.result("campaign")));
  EXPECT_EQ(job("gather.sbatch", 0), 3);
  EXPECT_SAYS(read(said), "1 of 2 units have no result");
  EXPECT_SAYS(read(said), "load programs 'ambient', 'again'");
  EXPECT_TRUE(fs::exists(toy_.result("campaign/warm_up/tcp.csv")));
  EXPECT_EQ(job("array.sbatch", 0), 0) << read(said);
  EXPECT_EQ(job("gather.sbatch", 0), 0) << read(said);
  EXPECT_EQ(files_in(toy_.result("campaign")), files);

  // What is done is kept, and what is changed is computed again.
  const json kept = json::parse(study().out);
  EXPECT_EQ(kept["computed"], 0);
  EXPECT_EQ(kept["kept"], 2);
  toy_.edit("loads/warm_up.toml", "spindle_rpm = 9000", "spindle_rpm = 8000");
  const Result changed = study({"--local"});
  EXPECT_EQ(json::parse(changed.out)["computed"], 1);
  EXPECT_SAYS(changed.err, "1 units in");
  const Files after = files_in(toy_.result("campaign"));
  EXPECT_EQ(after.at("again/tcp.csv"), files.at("again/tcp.csv"));
  EXPECT_NE(after.at("warm_up/tcp.csv"), files.at("warm_up/tcp.csv"));
  EXPECT_EQ(of_the_verb(), after);
}

TEST_F(StudyCampaign, ADryRunSaysWhatIsLeftAndWritesNothing) {
  const json before = json::parse(study({"--dry-run"}).out);
  EXPECT_EQ(before["units"], 2);
  EXPECT_EQ(before["to_compute"].size(), 2U);
  EXPECT_SAYS(before["to_compute"].dump(), "load programs 'warm_up'");
  EXPECT_GT(before["disk_GiB"], 0.0);
  EXPECT_GT(before["memory_GiB"], 0.0);
  EXPECT_FALSE(fs::exists(folder()));
  EXPECT_FALSE(fs::exists(toy_.result("campaign")));

  ASSERT_EQ(study({"--part", "0/2"}).status, 0);
  const Files files = files_in(folder());
  const json after = json::parse(study({"--dry-run"}).out);
  EXPECT_EQ(after["done"], 1);
  EXPECT_EQ(after["to_compute"].size(), 1U);
  EXPECT_EQ(files_in(folder()), files);
  EXPECT_EQ(study({"--dry-run", "--slurm"}).status, 2);
  EXPECT_EQ(study({"--dry-run", "--gather"}).status, 2);
}

TEST_F(StudyCampaign, AStoppedUnitGoesOnWithTheSameBits) {
  toy_.edit("loads/warm_up.toml", "time_step_s = 120", "time_step_s = 5");
  const Files files = of_the_verb();
  stop_at("checkpoint_warm_up.bin");
  ASSERT_EQ(study().status, 0);
  EXPECT_EQ(files_in(toy_.result("campaign")), files);
  EXPECT_EQ(find(folder() / "units", "checkpoint_warm_up.bin"), fs::path());
}

TEST_F(StudyCampaign, AFailedUnitIsNamedAndTheOthersAreGathered) {
  ASSERT_EQ(study().status, 0);
  // As if the solver had given up.
  const fs::path unit = find(folder() / "units", "warm_up").parent_path().parent_path();
  fs::remove(unit / "done");
  std::ofstream(unit / "failed") << "no convergence at 600 s\n";
  fs::remove_all(toy_.result("campaign"));
  const Result gathered = study({"--gather"});
  EXPECT_EQ(gathered.status, 4);
  EXPECT_SAYS(gathered.err, "load programs 'warm_up': no convergence at 600 s");
  EXPECT_EQ(json::parse(gathered.out)["loads"].size(), 2U);
  EXPECT_SAYS(read(folder() / "failures.csv"), "\"load programs 'warm_up'\",\"no convergence at 600 s\"\n");
  EXPECT_FALSE(fs::exists(toy_.result("campaign/warm_up")));
  EXPECT_TRUE(fs::exists(toy_.result("campaign/again/done")));
  // The next run tries it again.
  EXPECT_EQ(json::parse(study().out)["loads"].size(), 3U);
  EXPECT_FALSE(fs::exists(folder() / "failures.csv"));
}

TEST_F(StudyCampaign, WhatCannotBeMeshedIsSaidOnceWithStatus3) {
  std::string machine = read(toy_.file("machine.toml"));
  const std::string size = "element_size_mm";
  for (std::size_t at = machine.find(size); at != std::string::npos; at = machine.find(size, at + 40))
    machine.insert(at, "max_elements = 1000\n");
  toy_.write("machine.toml", machine);
  const Result made = study({"--size", "0.2"});
  EXPECT_EQ(made.status, 3) << made.err;
  EXPECT_SAYS(made.err, "nothing can be computed: load programs 'ambient', 'again'");
  EXPECT_SAYS(made.err, "max_elements");
}

TEST_F(StudyCampaign, AnotherCaseInTheSameFolderIsRefused) {
  ASSERT_EQ(study({"--slurm"}).status, 0);
  const Toy other;
  const Result refused = toy_.run({"study", "campaign", other.path(), "--slurm", "--quiet"});
  EXPECT_EQ(refused.status, 3);
  EXPECT_SAYS(refused.err, "one plan or case a folder");
}

class StudyValidate : public UnitsOf {
protected:
  void SetUp() override { draw("2"); }
  void draw(const std::string& machines) {
    is("validate", {"--model", toy_model(), "--draws", machines, "--load", "mixed"});
  }
  /// What the plain verb says and writes, which is then removed.
  std::pair<std::string, Files> of_the_verb() const {
    const Result made = plain();
    EXPECT_EQ(made.status, 0) << made.err;
    std::pair<std::string, Files> all{made.out, results()};
    fs::remove_all(toy_.result("measured"));
    fs::remove_all(toy_.result("validation"));
    return all;
  }
  Files results() const {
    Files files = files_in(toy_.result("measured"));
    EXPECT_EQ(files.count("all/mixed/machine_2/data.csv"), 1U);
    files["report"] = read(toy_.result("validation/report.html"));
    return files;
  }
};

TEST_F(StudyValidate, UnitsInAnyOrderGiveTheFilesOfTheVerb) {
  const auto [said, files] = of_the_verb();
  ASSERT_EQ(study({"--slurm"}).status, 0);
  EXPECT_SAYS(read(folder() / "slurm/array.sbatch"), "#SBATCH --array=0-1\n");
  EXPECT_EQ(study({"--part", "1/2"}).status, 0);
  const Result early = study({"--gather"});
  EXPECT_EQ(early.status, 3);
  EXPECT_SAYS(early.err, "machine 1 (seed 1)");
  EXPECT_FALSE(fs::exists(toy_.result("validation")));
  stop_at("checkpoint_mixed.bin");
  EXPECT_EQ(study({"--part", "0/2"}).status, 0);
  const Result gathered = study({"--gather"});
  EXPECT_EQ(gathered.status, 0) << gathered.err;
  EXPECT_EQ(gathered.out, said);
  EXPECT_EQ(results(), files);
  // A machine more: the others are kept.
  draw("3");
  const Result more = study({"--part", "0/1"});
  EXPECT_EQ(json::parse(more.out)["computed"], 1) << more.err;
  EXPECT_EQ(json::parse(more.out)["kept"], 2);
}

TEST_F(StudyValidate, NeedsFullModelsAndOnSeveralHostsAModel) {
  const Result quick = study({"--truth", (toy_run() / "reference.rom.h5").string()});
  EXPECT_EQ(quick.status, 2);
  EXPECT_SAYS(quick.err, "--full-draws");
  const Result none = toy_.run({"study", "validate", toy_.path(), "--slurm"});
  EXPECT_EQ(none.status, 2);
  EXPECT_SAYS(none.err, "--model");
}

}  // namespace
}  // namespace thermotwin::cases
