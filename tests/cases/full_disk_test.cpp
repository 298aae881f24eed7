// SPDX-License-Identifier: GPL-3.0-or-later
// A disk that fills up while results are written: exit status 3, a message that names the file, and
// earlier results byte for byte as they were. A limit on the size of files stands for the disk,
// since that needs no privilege; where a small file system may be mounted, that one fills up too.
#include <gtest/gtest.h>

#include <string>
#include <sys/mount.h>
#include <vector>

#include "diagnosis/judge/diagnosis.h"
#include "reduction/model/trained_range.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

/// Runs the verb with little room for each file. @return what it said
std::string run_without_room(const Toy& toy, const std::vector<std::string>& arguments, std::uint64_t bytes) {
  const auto before = files_in(toy.out());
  Surroundings surroundings;
  surroundings.largest_file = bytes;
  const Result result = toy.run(arguments, surroundings);
  EXPECT_EQ(result.status, 3) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(changes(before, files_in(toy.out())), std::vector<std::string>());
  return result.err;
}

// The tables have room, the fields have not: the tables of the earlier run stay with its fields.
TEST(FullDisk, FieldsOfASimulation) {
  const Toy toy;
  const std::vector<std::string> simulate{"simulate", toy.path(), "--load", "ambient"};
  ASSERT_EQ(toy.run(simulate).status, 0);
  toy.edit("loads/ambient.toml", "air_C = [20, 26]", "air_C = [20, 25]");
  const std::string said = run_without_room(toy, simulate, 30000);
  EXPECT_SAYS(said, "000000.vtu");
  EXPECT_SAYS(said, "allowed: ");
}

TEST(FullDisk, MeshForParaview) {
  const Toy toy;
  ASSERT_EQ(toy.run({"mesh", toy.path()}).status, 0);
  EXPECT_SAYS(run_without_room(toy, {"mesh", toy.path(), "--size", "0.9"}, 5000), ".vtu");
}

TEST(FullDisk, TablesOfACampaign) {
  const Toy toy;
  toy.take_results();
  toy.edit("loads/mixed.toml", "spindle_rpm = 6000", "spindle_rpm = 7000");
  const std::string said = run_without_room(toy, {"campaign", toy.path(), "--load", "mixed"}, 100000);
  EXPECT_SAYS(said, "fields_mixed.bin");
  EXPECT_SAYS(said, "cannot be written");
}

// With twice as many outputs the tables need more room than the fields of 72 of them.
TEST(FullDisk, TablesOfACampaignLargerThanItsFields) {
  const Toy toy;
  toy.take_results();
  toy.edit("loads/mixed.toml", "output_s = 240", "output_s = 120");
  EXPECT_SAYS(run_without_room(toy, {"campaign", toy.path(), "--load", "mixed"}, 900000), "tcp.csv");
}

TEST(FullDisk, SnapshotsOfTheTraining) {
  const Toy toy;
  toy.take_results();
  toy.edit("loads/warm_up.toml", "spindle_rpm = 9000", "spindle_rpm = 8000");
  EXPECT_SAYS(run_without_room(toy, {"reduce", toy.path(), "--resume"}, 150000), "snapshots");
}

TEST(FullDisk, ReducedModel) {
  const Toy toy;
  toy.take_results();
  EXPECT_SAYS(run_without_room(toy, {"reduce", toy.path(), "--resume", "--order", "40"}, 600000), "model.rom.h5");
}

TEST(FullDisk, Diagnosis) {
  const Toy toy;
  toy.take_results();
  toy.take_measurement();
  EXPECT_SAYS(run_without_room(toy,
                               {"diagnose", toy.path(), "--data", toy.file("measurement"), "--model",
                                (toy_run() / "model.rom.h5").string()},
                               200000),
              "extended/model.rom.h5");
}

TEST(FullDisk, Offsets) {
  const Toy toy;
  const std::string model = (toy_run() / "model.rom.h5").string(),
                    rows = (toy_run() / "campaign/mixed/inputs.csv").string();
  toy.write("offsets.csv", "earlier offsets\n");
  const std::string offsets = toy.file("offsets.csv");
  Surroundings surroundings;
  surroundings.largest_file = 1000;
  const Result result = thermotwin({"compensate", model, "--in", rows, "--out", offsets}, "", surroundings);
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "offsets.csv");
  EXPECT_EQ(read(offsets), "earlier offsets\n");
}

// Nobody may take a cut-off summary for a whole one.
TEST(FullDisk, StandardOutput) {
  const Toy toy;
  Surroundings surroundings;
  surroundings.output = "/dev/full";
  const Result mesh = toy.run({"mesh", toy.path(), "--json"}, surroundings);
  EXPECT_EQ(mesh.status, 3);
  EXPECT_SAYS(mesh.err, "standard output");
  const Result offsets =
      thermotwin({"compensate", (toy_run() / "model.rom.h5").string()}, "time_s\n0\n60\n", surroundings);
  EXPECT_EQ(offsets.status, 3);
  EXPECT_SAYS(offsets.err, "cannot be written");
}

/// A file system of its own, gone at the end.
class SmallDisk {
public:
  explicit SmallDisk(const std::string& folder, const char* size) : folder_(folder) {
    std::filesystem::create_directories(folder);
    mounted_ = ::mount("toy", folder.c_str(), "tmpfs", 0, size) == 0;
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(folder_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool is_mounted() const { return mounted_; }

private:
  std::string folder_;
  bool mounted_ = false;
};

TEST(FullDisk, OfAWholeRun) {
  const Toy toy;
  const SmallDisk disk(toy.out(), "size=6m");  // meshes and campaign fit, the model does not
  if (!disk.is_mounted()) GTEST_SKIP() << "no file system may be mounted here";
  const Result result = toy.run({"run", toy.path()});
  EXPECT_EQ(result.status, 3) << result.err;
  EXPECT_SAYS(result.err, "model.rom.h5");
  for (const auto& [name, bytes] : files_in(toy.out())) EXPECT_EQ(name.find("part-"), std::string::npos) << name;
  for (const char* load : {"ambient", "warm_up", "mixed"})
    EXPECT_TRUE(std::filesystem::exists(toy.result("campaign") / load / "done")) << load;
}

}  // namespace
}  // namespace thermotwin::cases
