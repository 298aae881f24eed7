// SPDX-License-Identifier: GPL-3.0-or-later
// `study` as a user meets it, on the toy: numbers against separate campaigns, known sensitivities, units that
// are kept, and slips.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/table.h"
#include "tests/cases/program.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A short load program with every source, and a plan beside it.
class StudyVariants : public ::testing::Test {
protected:
  void SetUp() override {
    toy_.make_affine();
    fs::create_directories(toy_.out());
    if (fs::exists(meshes().path() / "cache"))
      fs::copy(meshes().path() / "cache", toy_.result("cache"), fs::copy_options::recursive);
    toy_.write("loads/short.toml", R"(schema = 1
title = "spindle, X axis and table"
initial_C = 20.0
time_step_s = 300
output_s = 1200
[[phase]]
duration_h = 1
air_C = [20, 22]
spindle_rpm = 9000
coolant = true
[[phase.axis]]
id = "X"
low_mm = -80
high_mm = 110
feed_mm_min = 25000
[[phase]]
duration_h = 1
spindle_rpm = 0
[[phase.axis]]
id = "C"
speed_rpm = 80
)");
  }

  void TearDown() override {
    if (!fs::exists(meshes().path() / "cache") && fs::exists(toy_.result("cache")))
      fs::copy(toy_.result("cache"), meshes().path() / "cache", fs::copy_options::recursive);
  }
  /// Meshes that the first test has made, for the others.
  static const core::TemporaryFolder& meshes() {
    static const core::TemporaryFolder folder;
    return folder;
  }

  std::string plan(const std::string& text, const std::string& name = "plan") {
    const std::string file = name + ".toml";
    toy_.write("../" + file, "schema = 1\ncase = \"toy\"\nloads = [\"short\"]\n" + text);
    return toy_.file("../" + file);
  }
  Result run(const std::string& text, std::vector<std::string> more = {}, const std::string& name = "plan") {
    std::vector<std::string> words{"study", "variants", plan(text, name), "--json", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return toy_.run(words);
  }
  fs::path study(const std::string& name = "plan") const { return toy_.result("study/" + name); }

  /// Table of the variant, from 1.
  core::Table tcp(int variant, const std::string& name = "plan") const {
    const std::string file = fmt::format("tcp_{:05}.csv", variant);
    for (const auto& entry : fs::recursive_directory_iterator(study(name)))
      if (entry.path().filename() == file) return core::read_csv(entry.path());
    ADD_FAILURE() << "no " << file;
    return {};
  }

  Toy toy_;
};

constexpr const char* errors[] = {"dx_um", "dy_um", "dz_um", "ra_um_per_m", "rb_um_per_m", "rc_um_per_m"};

constexpr const char* three_kinds = R"(
[[parameter]]
kind = "source_power"
where = "spindle.bearings"
values = [1.0, 1.7]
[[parameter]]
kind = "film_coefficient"
where = "slides"
values = [1.0, 2.0]
[[parameter]]
kind = "contact_conductance"
where = "Z_guide"
values = [1.0, 0.5]
)";

TEST_F(StudyVariants, AreThoseOfSeparateRuns) {
  const Result made = run(three_kinds);
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(json::parse(made.out)["variants"], 8);
  EXPECT_EQ(json::parse(made.out)["model"], "full");
  std::string alone = three_kinds;
  for (const char* both : {"[1.0, 1.7]", "[1.0, 2.0]", "[1.0, 0.5]"}) {
    const std::string one = std::string(both).replace(1, 5, "");
    alone.replace(alone.find(both), std::strlen(both), one);
  }
  ASSERT_EQ(run(alone, {}, "alone").status, 0);
  // Variant 8: all three changed, in machine.toml.
  ASSERT_EQ(toy_.run({"campaign", toy_.path(), "--load", "short", "--quiet"}).status, 0);
  const core::Table nominal = core::read_csv(toy_.result("campaign/short/tcp.csv"));
  toy_.edit("machine.toml", "surfaces = [\"y_slide.skin\", \"z_slide.skin\"]\nfilm_coefficient_W_m2K = {value = 9,",
            "surfaces = [\"y_slide.skin\", \"z_slide.skin\"]\nfilm_coefficient_W_m2K = {value = 18,");
  const std::string machine = read(toy_.file("machine.toml"));
  std::string changed = machine;
  const auto source = changed.find("id = \"spindle.bearings\""), scale = changed.find("scale = {value = 1.0", source);
  changed.replace(scale, std::string("scale = {value = 1.0").size(), "scale = {value = 1.7");
  const auto joint = changed.find("id = \"Z_guide\""), conductance = changed.find("{value = 800", joint);
  changed.replace(conductance, std::string("{value = 800").size(), "{value = 400");
  toy_.write("machine.toml", changed);
  ASSERT_EQ(toy_.run({"campaign", toy_.path(), "--load", "short", "--quiet"}).status, 0);
  const core::Table apart = core::read_csv(toy_.result("campaign/short/tcp.csv"));
  for (const char* column : errors) {
    const double size = apart.column(column).cwiseAbs().maxCoeff();
    const Eigen::VectorXd ours = tcp(8).column(column);
    EXPECT_LE((ours - tcp(1, "alone").column(column)).cwiseAbs().maxCoeff(), 1e-9 * size) << column;
    const double least = 1e-9 * size;
    EXPECT_LE((tcp(1).column(column) - nominal.column(column)).cwiseAbs().maxCoeff(), least) << column;
    EXPECT_LE((ours - apart.column(column)).cwiseAbs().maxCoeff(), least) << column;
    EXPECT_GT((tcp(8).column(column) - tcp(1).column(column)).cwiseAbs().maxCoeff(), 0.01 * size) << column;
  }
  // The same in one line: the last row of errors.csv is variant 8.
  const core::Table eighth = tcp(8);
  const double largest = (eighth.column("dx_um").array().square() + eighth.column("dy_um").array().square() +
                          eighth.column("dz_um").array().square())
                             .sqrt()
                             .maxCoeff();
  const std::string rows = read(study() / "errors.csv");
  EXPECT_TRUE(rows.starts_with("variant,group,load,largest_error_um,at_h,error_at_end_um\n1,coarse,short,")) << rows;
  EXPECT_SAYS(rows, fmt::format("\n8,coarse,short,{:.6g},", largest));
  EXPECT_SAYS(read(study() / "report.html"), "Each variant");
}

/// Powers of the affine toy. Its error is linear in them: one at a time tells what each is worth.
class StudyPowers : public StudyVariants {
protected:
  void know() {
    const std::string machine = read(toy_.file("machine.toml"));
    for (std::size_t at = machine.find("[[source]]"); at != std::string::npos;
         at = machine.find("[[source]]", at + 1)) {
      const auto from = machine.find("id = \"", at) + 6;
      ids_.push_back(machine.substr(from, machine.find('"', from) - from));
    }
    ASSERT_GE(ids_.size(), 3U);
    std::string one_at_a_time;
    for (const std::string& id : ids_)
      one_at_a_time += fmt::format("[[parameter]]\nkind = \"source_power\"\nwhere = \"{}\"\nvalues = [1.0, 2.0]\n", id);
    ASSERT_EQ(run(one_at_a_time, {}, "single").status, 0);
    double sum = 0.0;
    const int combinations = 1 << ids_.size();
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      const int variant = 1 + (combinations >> (i + 1));  // the last parameter is the fastest
      double square = 0.0;
      for (int k = 0; k < 3; ++k)
        square += (tcp(variant, "single").column(errors[k]) - tcp(1, "single").column(errors[k])).squaredNorm();
      worth_.push_back(std::sqrt(square));
    }
    for (std::size_t i = 0; i < ids_.size(); ++i) shares_.push_back(std::pow(worth_[i] * std_of(i), 2));
    for (const double share : shares_) sum += share;
    for (double& share : shares_) share /= sum;
  }
  /// Of the factor on a power.
  virtual double std_of(std::size_t power) const {
    constexpr double of[] = {0.10, 0.20, 0.05, 0.15};
    return of[power % 4];
  }
  std::string drawn(const std::string& how) const {
    std::string text = how;
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      text += fmt::format("[[parameter]]\nkind = \"source_power\"\nwhere = \"{}\"\nstd_percent = {}\n", ids_[i],
                          100.0 * std_of(i));
    }
    return text;
  }
  struct Row {
    std::string parameter;
    double first = 0, first_low = 0, first_high = 0, total = 0, total_low = 0, total_high = 0;
  };
  std::vector<Row> sensitivities(const std::string& name) const {
    std::istringstream table(read(study(name) / "coarse/short/sensitivities.csv"));
    std::string line;
    std::getline(table, line);
    EXPECT_EQ(line, "parameter,first,first_low,first_high,total,total_low,total_high");
    std::vector<Row> rows;
    while (std::getline(table, line)) {
      Row row;
      row.parameter = line.substr(0, line.find(','));
      EXPECT_EQ(std::sscanf(line.c_str() + line.find(','), ",%lf,%lf,%lf,%lf,%lf,%lf", &row.first, &row.first_low,
                            &row.first_high, &row.total, &row.total_low, &row.total_high),
                6)
          << line;
      rows.push_back(row);
    }
    return rows;
  }

  std::vector<std::string> ids_;
  std::vector<double> worth_, shares_;  ///< um for each unit of the factor; share of the variance, first and total
};

TEST_F(StudyPowers, HaveTheSharesOfALinearMachine) {
  know();
  const Result made = run(drawn("samples = 40\nseed = 3\n"), {}, "drawn");
  ASSERT_EQ(made.status, 0) << made.err;
  const std::vector<Row> rows = sensitivities("drawn");
  ASSERT_EQ(rows.size(), ids_.size());
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    EXPECT_EQ(rows[i].parameter, "source_power:" + ids_[i]);
    EXPECT_NEAR(rows[i].first, shares_[i], 1e-4) << ids_[i];
    EXPECT_NEAR(rows[i].total, shares_[i], 1e-4) << ids_[i];
  }
  // Quantiles: of a sum of sources, whose median is the nominal machine.
  const core::Table quantiles = core::read_csv(study("drawn") / "coarse/short/quantiles.csv");
  const core::Table nominal = tcp(1, "single");
  ASSERT_EQ(quantiles.rows(), nominal.rows());
  const double size = nominal.column("dz_um").cwiseAbs().maxCoeff();
  EXPECT_LT((quantiles.column("dz_um_q50") - nominal.column("dz_um")).cwiseAbs().maxCoeff(), 0.05 * size);
  EXPECT_GT((quantiles.column("dz_um_q95") - quantiles.column("dz_um_q05")).maxCoeff(), 0.05 * size);
  EXPECT_TRUE(fs::exists(study("drawn") / "report.html"));
  EXPECT_TRUE(fs::exists(study("drawn") / "coarse/short/sensitivities_by_pose.csv"));
}

/// All powers, with deviations that make their shares equal.
class StudyCoverage : public StudyPowers {
protected:
  double std_of(std::size_t power) const override {
    return 0.3 * *std::min_element(worth_.begin(), worth_.end()) / worth_[power];
  }
};

TEST_F(StudyCoverage, IntervalsHoldTheSharesOfALinearMachine) {
  know();
  int held = 0, all = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    const Result made =
        run(drawn(fmt::format("samples = 20\nseed = {}\nsampling = \"pick_freeze\"\nblock = 100\n", seed)));
    ASSERT_EQ(made.status, 0) << made.err;
    const std::vector<Row> rows = sensitivities("plan");
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      // An interval ends at 0, so that one of a share near 0 would always hold it: none is counted.
      ASSERT_NEAR(shares_[i], 1.0 / static_cast<double>(ids_.size()), 1e-9) << ids_[i];
      held += rows[i].first_low <= shares_[i] && shares_[i] <= rows[i].first_high;
      held += rows[i].total_low <= shares_[i] && shares_[i] <= rows[i].total_high;
      all += 2;
    }
    fs::remove_all(study());
  }
  RecordProperty("held", held);
  EXPECT_GE(held, 0.90 * all) << all;
  EXPECT_LE(held, 0.98 * all) << all;
  std::printf("95 %% intervals hold %d of %d shares\n", held, all);
}

constexpr const char* two_units = R"(
samples = 6
block = 3
[[parameter]]
kind = "film_coefficient"
where = "*"
[[parameter]]
kind = "source_power"
where = "*"
)";

TEST_F(StudyVariants, AUnitIsComputedOnceByWhateverTask) {
  const Result whole = run(two_units, {"--local"});
  ASSERT_EQ(whole.status, 0) << whole.err;
  EXPECT_EQ(json::parse(whole.out)["computed"], 2);
  const std::string computed_by = json::parse(whole.out)["computed_by"];
  EXPECT_SAYS(computed_by, " nodes");
  const json gathered = json::parse(run(two_units, {"--gather"}).out);
  EXPECT_EQ(gathered["computed_by"], computed_by);
  EXPECT_EQ(gathered["kept"], 2);
  EXPECT_EQ(gathered["variants_computed"], 6);
  const auto files = files_in(study());
  fs::remove_all(study());

  // The scripts for Slurm as they are, one task after another: the same bytes, and what is missing is named.
  const Result scripts = run(two_units, {"--slurm", "--tasks", "2", "--task-threads", "1"});
  ASSERT_EQ(scripts.status, 0) << scripts.err;
  EXPECT_FALSE(fs::exists(study() / "units"));
  const std::string slurm = (study() / "slurm").string(), said = (study() / "said").string();
  const auto job = [&](const std::string& script, int task) {
    const std::string command =
        fmt::format("cd / && SLURM_ARRAY_TASK_ID={} bash '{}/{}' >/dev/null 2>'{}'", task, slurm, script, said);
    return WEXITSTATUS(std::system(command.c_str()));
  };
  EXPECT_EQ(job("array.sbatch", 1), 0);
  EXPECT_EQ(job("gather.sbatch", 0), 3);
  EXPECT_SAYS(read(said), "1 of 2 units have no result");
  EXPECT_SAYS(read(said), "variants 1 to 3 of 'short'");
  EXPECT_EQ(job("array.sbatch", 0), 0);
  EXPECT_EQ(job("gather.sbatch", 0), 0);
  for (const auto& [name, bytes] : files)
    if (name.ends_with(".csv") || name.ends_with("done")) {
      EXPECT_EQ(read(study() / name), bytes) << name;
    }
  EXPECT_EQ(WEXITSTATUS(std::system(("env PATH=/none /bin/bash '" + slurm + "/submit.sh' 2>/dev/null").c_str())), 3);

  // A table that was changed afterwards is computed again; the other unit is kept.
  for (const auto& [name, bytes] : files)
    if (name.ends_with("tcp_00002.csv")) std::ofstream(study() / name) << "time_s\n";
  const Result repaired = run(two_units);
  EXPECT_EQ(json::parse(repaired.out)["computed"], 1);
  EXPECT_EQ(json::parse(repaired.out)["kept"], 1);
  // Another machine: nothing of the earlier results is taken for its own.
  toy_.edit("machine.toml", "spindle_max_rpm = 12000", "spindle_max_rpm = 12001");
  const Result other = run(two_units);
  EXPECT_EQ(json::parse(other.out)["computed"], 2);
  EXPECT_SAYS(other.err, "2 units in");
  toy_.edit("loads/short.toml", "spindle_rpm = 9000", "spindle_rpm = 8000");
  EXPECT_EQ(json::parse(run(two_units).out)["computed"], 2);
}

TEST_F(StudyVariants, AStoppedUnitGoesOnWithTheSameBits) {
  toy_.edit("loads/short.toml", "time_step_s = 300", "time_step_s = 10");
  const std::string plan_file = plan(two_units);
  const std::vector<std::string> words{"study", "variants", plan_file, "--quiet", "--checkpoint-every", "0.05"};
  auto with_out = words;
  with_out.insert(with_out.end(), {"--out", toy_.out()});
  fs::path found;
  Result stopped;
  {
    Program program(with_out);
    while (found.empty() && program.is_running()) {
      std::error_code ignored;
      for (const auto& entry : fs::recursive_directory_iterator(toy_.result("study"), ignored))
        if (entry.path().filename() == "checkpoint.bin") found = entry.path();
      program.ends_within(0.005);
    }
    program.send(SIGTERM);
    stopped = program.wait();
  }
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(stopped.status, 130) << stopped.err;
  EXPECT_TRUE(fs::exists(found));
  ASSERT_EQ(toy_.run(words).status, 0);
  const auto resumed = files_in(toy_.result("study"));
  fs::remove_all(toy_.result("study"));
  ASSERT_EQ(toy_.run(words).status, 0);
  for (const auto& [name, bytes] : files_in(toy_.result("study"))) {
    EXPECT_FALSE(name.ends_with("checkpoint.bin"));
    if (name.ends_with(".csv")) {
      EXPECT_EQ(bytes, resumed.at(name)) << name;
    }
  }
}

TEST_F(StudyVariants, MeshSizesAndMaterialsAreGroupsOfTheirOwn) {
  const Result made = run(R"(
size = ["coarse", "0.9"]
[[parameter]]
kind = "expansion_coefficient"
where = "iron"
values = [1.0, 1.2]
)");
  ASSERT_EQ(made.status, 0) << made.err;
  const json summary = json::parse(made.out);
  EXPECT_EQ(summary["units"], 4);
  ASSERT_EQ(summary["groups"].size(), 2U);
  const double coarse = tcp(1).column("dz_um").cwiseAbs().maxCoeff(),
               more = tcp(2).column("dz_um").cwiseAbs().maxCoeff();
  EXPECT_GT(std::abs(more - coarse), 0.01 * coarse);
  EXPECT_TRUE(fs::exists(study() / "0.9/short/quantiles.csv"));
  // Each size with its own mesh.
  EXPECT_SAYS(summary["computed_by"].get<std::string>(), "size coarse: ");
  EXPECT_SAYS(summary["computed_by"].get<std::string>(), " nodes, size 0.9: ");
  // Here both sizes make one mesh, which is said.
  EXPECT_SAYS(made.err, "sizes 'coarse' and '0.9' have 1351 nodes each");
  const Result other = run("size = [\"coarse\", \"0.5\"]\n");
  ASSERT_EQ(other.status, 0) << other.err;
  EXPECT_EQ(other.err.find("nodes each"), std::string::npos) << other.err;
}

TEST_F(StudyVariants, TablesOfAnEarlierRunAreSetAsideAndNamed) {
  toy_.write("loads/brief.toml", read(toy_.file("loads/short.toml")));
  const std::string text = "[[parameter]]\nkind = \"source_power\"\nwhere = \"spindle.bearings\"\nvalues = [1, 2]\n";
  const std::vector<std::string> words{"study", "variants", plan(text), "--json", "--quiet"};
  toy_.edit("../plan.toml", "[\"short\"]", "[\"short\", \"brief\"]");
  ASSERT_EQ(toy_.run(words).status, 0);
  const std::string table = read(study() / "coarse/brief/quantiles.csv"),
                    kept = read(study() / "coarse/short/quantiles.csv");
  toy_.edit("../plan.toml", "[\"short\", \"brief\"]", "[\"short\"]");
  const Result later = toy_.run(words);
  ASSERT_EQ(later.status, 0) << later.err;
  EXPECT_FALSE(fs::exists(study() / "coarse/brief"));
  EXPECT_EQ(read(study() / "before/1/coarse/brief/quantiles.csv"), table);
  EXPECT_EQ(read(study() / "coarse/short/quantiles.csv"), kept);
  EXPECT_SAYS(later.err, "before/1: coarse/brief/quantiles.csv");
  EXPECT_EQ(json::parse(later.out)["set_aside"], json({"coarse/brief/quantiles.csv"}));
  // Nothing is moved twice, and what was moved stays.
  const Result again = toy_.run(words);
  EXPECT_EQ(json::parse(again.out)["set_aside"], json::array());
  EXPECT_EQ(again.err.find("before"), std::string::npos) << again.err;
  EXPECT_EQ(read(study() / "before/1/coarse/brief/quantiles.csv"), table);
}

TEST_F(StudyVariants, AnotherPlanOfTheSameNameIsRefused) {
  ASSERT_EQ(run("").status, 0);
  const auto files = files_in(study());
  toy_.write("../elsewhere/plan.toml", "schema = 1\ncase = \"../toy\"\nloads = [\"short\"]\n");
  const std::string other = fs::canonical(toy_.file("../elsewhere/plan.toml")).string();
  const Result refused = toy_.run({"study", "variants", other, "--quiet"});
  EXPECT_EQ(refused.status, 3);
  EXPECT_SAYS(refused.err, fs::canonical(toy_.file("../plan.toml")).string());
  EXPECT_SAYS(refused.err, other);
  EXPECT_EQ(files_in(study()), files);
  // A plan that was moved is the same plan.
  fs::remove(toy_.file("../plan.toml"));
  EXPECT_EQ(toy_.run({"study", "variants", other, "--quiet"}).status, 0);
}

TEST_F(StudyVariants, ReducedIsSaidAndNear) {
  // The machine as it was when its model was made.
  toy_.edit("machine.toml", "radiation = \"linear\"", "radiation = \"exact\"");
  toy_.edit("machine.toml", "guide_ambient = \"air\"", "guide_sensor = \"T3\"");
  fs::copy(toy_run() / "model.rom.h5", toy_.result("model.rom.h5"));
  const Result full = run(three_kinds), reduced = run(three_kinds, {"--reduced"}, "reduced");
  ASSERT_EQ(reduced.status, 0) << reduced.err;
  EXPECT_EQ(json::parse(reduced.out)["model"], "reduced");
  EXPECT_SAYS(json::parse(reduced.out)["computed_by"].get<std::string>(), "order");
  EXPECT_SAYS(read(study("reduced") / "report.html"), "reduced model");
  const std::string model = " --reduced --model " + toy_.result("model.rom.h5").string();
  EXPECT_SAYS(read(study("reduced") / "report.html"), "--slurm --out " + toy_.out() + model);
  const Eigen::VectorXd ours = tcp(8, "reduced").column("dz_um"), theirs = tcp(8).column("dz_um");
  EXPECT_LT((ours - theirs).cwiseAbs().maxCoeff(), 0.05 * theirs.cwiseAbs().maxCoeff());
  const Result replaced = run(three_kinds, {"--reduced"});
  EXPECT_EQ(replaced.status, 0) << replaced.err;
  EXPECT_SAYS(replaced.err, "came from the full model and are replaced");
  EXPECT_EQ(json::parse(run(three_kinds).out)["computed"], 0) << "the units of the full model stay";
  // The model itself changes with a material.
  const std::string expansion =
      "[[parameter]]\nkind = \"expansion_coefficient\"\nwhere = \"iron\"\nvalues = [1.0, 1.5]\n";
  const Result stretched = run(expansion, {"--reduced"}, "stretched");
  ASSERT_EQ(stretched.status, 0) << stretched.err;
  const Result of_full = run(expansion, {}, "of_full");
  ASSERT_EQ(of_full.status, 0) << of_full.err;
  const auto change = [&](const char* name) {
    return Eigen::VectorXd(tcp(2, name).column("dz_um") - tcp(1, name).column("dz_um"));
  };
  const Eigen::VectorXd reference = change("of_full");
  EXPECT_LT((change("stretched") - reference).cwiseAbs().maxCoeff(), 0.1 * reference.cwiseAbs().maxCoeff());
}

struct Slip {
  const char *text, *place, *value, *allowed;
};

TEST_F(StudyVariants, SlipsInAPlanNamePlaceValueAndWhatIsAllowed) {
  const Slip slips[] = {
      {"sample = 3\n[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\n", "plan.toml:4", "sample", "samples"},
      {"[[parameter]]\nkind = \"source_powr\"\nwhere = \"*\"\n", "plan.toml:5", "source_powr", "source_power"},
      {"[[parameter]]\nkind = \"sensor_offset\"\nwhere = \"T1\"\nstd = 1\n", "kind", "sensor_offset", "one of"},
      {"[[parameter]]\nkind = \"source_power\"\nwhere = \"spindel\"\nvalues = [1]\n", "where", "spindel", "spindle"},
      {"[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\nvalues = [1, 9]\n", "values", "9", "0 to 8"},
      {"[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\nrange = [2, 1]\n", "range", "[2, 1]", "low < high"},
      {"[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\n", "plan.toml", "samples = 0", "1 or more"},
      {"samples = 3\n[[parameter]]\nkind = \"ambient_offset\"\nwhere = \"air\"\n", "where", "no std_percent", "std"},
      {"samples = 3\n[[parameter]]\nkind = \"ambient_offset\"\nwhere = \"air\"\nstd_percent = 3\n", "std_percent",
       "ambient_offset", "std, in K"},
      {"samples = 3\n[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\nstd = 1\nrange = [0, 1]\n", "plan.toml:8",
       "range and std together", "one of values, range, std_percent, std"},
      {"samples = 3\n[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\n[[parameter]]\nkind = \"source_power\"\n"
       "where = \"spindle.bearings\"\n",
       "plan.toml:10", "'spindle.bearings' of source_power twice", "each parameter once"},
      {"samples = 3\n[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\nvalues = [1]\n", "plan.toml:4",
       "3, and no parameter to draw", "0, or a parameter with range"},
      {"size = [\"coarse\", \"coarse\"]\n[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\nvalues = [1]\n",
       "plan.toml:4", "'coarse' twice", "each once"},
      {"[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\nvalues = [1, 2, 1]\n", "values", "1 twice", "once"},
      {"[[parameter]]\nkind = \"process_heat\"\nwhere = \"Y.motor\"\nvalues = [1]\n", "where", "'Y.motor'",
       "nothing that process_heat may change"},
      {"[[parameter]]\nkind = \"film_speed_law\"\nwhere = \"slides\"\nvalues = [1]\n", "where", "'slides'", "table"},
      {"[[parameter]]\nkind = \"ambient_offset\"\nwhere = \"foundation\"\nvalues = [1]\n", "where", "'foundation'",
       "of air: air"},
      {"[[parameter]]\nkind = \"film_emissivity\"\nwhere = \"structure\"\nvalues = [1, 1.2]\n", "values",
       "1.2 of 'structure'", "0 to 1.11111"},
      {"size = \"corse\"\n[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\nvalues = [1]\n", "plan.toml:4",
       "'corse'", "coarse, standard, fine, or a factor"},
  };
  for (const Slip& slip : slips) {
    const Result result = run(slip.text);
    EXPECT_EQ(result.status, 3) << slip.text << result.err;
    for (const char* part : {slip.place, slip.value, slip.allowed}) EXPECT_SAYS(result.err, part) << slip.text;
    EXPECT_FALSE(fs::exists(study() / "units")) << slip.text;
  }
  plan("");
  toy_.edit("../plan.toml", "\"toy\"", "\"nowhere\"");
  const Result nowhere = toy_.run({"study", "variants", toy_.file("../plan.toml"), "--quiet"});
  EXPECT_EQ(nowhere.status, 3);
  EXPECT_SAYS(nowhere.err, "plan.toml:2");
  EXPECT_SAYS(nowhere.err, "no case 'nowhere'; allowed: a folder with case.toml");
  const std::string file = plan("[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\nvalues = [1]\n");
  toy_.edit("../plan.toml", "[\"short\"]", "[\"short\", \"short\"]");
  const Result twice = toy_.run({"study", "variants", file, "--quiet"});
  EXPECT_EQ(twice.status, 3);
  EXPECT_SAYS(twice.err, "plan.toml:3");
  EXPECT_SAYS(twice.err, "'short' twice; allowed: each load program once");
}

TEST_F(StudyVariants, AGradientOfTheAirIsThatOfTheVariant) {
  const std::string air = "id = \"air\"\ndefault_C = {value = 20, std_percent = 2}\n";
  toy_.edit("machine.toml", air, air + "gradient_K_m = {value = 2, std_percent = 50}\n");
  const Result made = run("[[parameter]]\nkind = \"ambient_gradient\"\nwhere = \"air\"\nvalues = [0, 3]\n");
  ASSERT_EQ(made.status, 0) << made.err;
  toy_.edit("machine.toml", "gradient_K_m = {value = 2,", "gradient_K_m = {value = 5,");
  ASSERT_EQ(toy_.run({"campaign", toy_.path(), "--load", "short", "--quiet"}).status, 0);
  const core::Table apart = core::read_csv(toy_.result("campaign/short/tcp.csv"));
  const double size = apart.column("dz_um").cwiseAbs().maxCoeff();
  EXPECT_GT((tcp(2).column("dz_um") - tcp(1).column("dz_um")).cwiseAbs().maxCoeff(), 0.005 * size);
  EXPECT_LE((tcp(2).column("dz_um") - apart.column("dz_um")).cwiseAbs().maxCoeff(), 1e-7 * size);
  // Its std_percent is a reason for `*`.
  EXPECT_EQ(run("samples = 4\n[[parameter]]\nkind = \"ambient_gradient\"\nwhere = \"*\"\n", {}, "drawn").status, 0);
  const Eigen::VectorXd drawn = core::read_csv(study("drawn") / "variants.csv").column("ambient_gradient:air");
  EXPECT_GT(drawn.maxCoeff() - drawn.minCoeff(), 0.5);
  EXPECT_LT(drawn.cwiseAbs().maxCoeff(), 2.5 * 2.5) << "at most two and a half deviations of 2.5 K/m";
}

TEST_F(StudyVariants, TooManyVariantsAreRefusedBeforeTheyAreMade) {
  std::string values = "1";
  for (int i = 1; i < 200; ++i) values += fmt::format(", {:.3f}", 1.0 + 0.01 * i);
  std::string text;
  for (const char* where : {"spindle.bearings", "X.friction", "C.drive", "Y.motor"})
    text += fmt::format("[[parameter]]\nkind = \"source_power\"\nwhere = \"{}\"\nvalues = [{}]\n", where, values);
  const Result refused = run(text);
  EXPECT_EQ(refused.status, 3);
  EXPECT_SAYS(refused.err, "1.6e+09 variants");
}

TEST_F(StudyVariants, APlanWithoutParametersRunsTheMachineAsStated) {
  const Result made = run("");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(json::parse(made.out)["variants"], 1);
}

TEST_F(StudyVariants, DrawsOfAWideDeviationStayWithinTheKind) {
  toy_.edit("machine.toml", "drive_loss_share = 0.2\nscale = {value = 1.0, std_percent = 5}",
            "drive_loss_share = 0.2\nscale = {value = 1.0, std_percent = 70}");
  const Result made =
      run("samples = 12\nseed = 2\n[[parameter]]\nkind = \"source_power\"\nwhere = \"spindle.bearings\"\n");
  ASSERT_EQ(made.status, 0) << made.err;
  const core::Table variants = core::read_csv(study() / "variants.csv");
  EXPECT_GE(variants.column("source_power:spindle.bearings").minCoeff(), 0.0);
  EXPECT_GT(variants.column("source_power:spindle.bearings").maxCoeff(), 1.5);
}

TEST_F(StudyVariants, AVariantThatCannotBeMeshedIsNamedAndTheOthersGoOn) {
  std::string machine = read(toy_.file("machine.toml"));
  const std::string size = "element_size_mm";
  for (std::size_t at = machine.find(size); at != std::string::npos; at = machine.find(size, at + 40))
    machine.insert(at, "max_elements = 1000\n");
  toy_.write("machine.toml", machine);
  const Result made =
      run("size = [\"0.2\", \"coarse\"]\n[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\nvalues = [1]\n");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_SAYS(made.err, "size 0.2");
  EXPECT_SAYS(made.err, "max_elements");
  const json summary = json::parse(made.out);
  EXPECT_EQ(summary["failed"].size(), 1U);
  EXPECT_EQ(summary["computed"], 1);
  EXPECT_TRUE(fs::exists(study() / "coarse/short/quantiles.csv"));
  EXPECT_EQ(summary["variants_computed"], 1);
  EXPECT_EQ(summary["variants_failed"], 1);
  EXPECT_EQ(core::read_csv(study() / "variants.csv").column("results"), Eigen::Vector2d(0, 1));
  const std::string failures = read(study() / "failures.csv");
  EXPECT_SAYS(failures, "variant,group,load,reason\n1,1,short,\"");
  EXPECT_SAYS(failures, "max_elements");
  // To gather says the same and does not ask for what cannot help.
  const std::vector<std::string> words{"study", "variants", toy_.file("../plan.toml"), "--quiet"};
  std::vector<std::string> gather = words;
  gather.emplace_back("--gather");
  const Result gathered = toy_.run(gather), computed = toy_.run(words);
  EXPECT_EQ(gathered.status, 0) << gathered.err;
  EXPECT_EQ(computed.status, 0) << computed.err;
  for (const Result* of : {&gathered, &computed}) {
    EXPECT_SAYS(of->out, "1 of 2 variants computed, 1 failed");
    EXPECT_SAYS(of->out, "0 of 1");
    EXPECT_SAYS(of->out, "failed: variants 1 to 1 of 'short', size 0.2");
  }
  EXPECT_SAYS(read(study() / "report.html"), "1 of 2 variants could not be computed");
  // Mended, nothing of it stays.
  toy_.edit("../plan.toml", "\"0.2\", ", "");
  ASSERT_EQ(toy_.run(words).status, 0);
  EXPECT_FALSE(fs::exists(study() / "failures.csv"));
}

TEST_F(StudyVariants, TwoProgramsInOneStudyAreRefused) {
  toy_.edit("loads/short.toml", "time_step_s = 300", "time_step_s = 10");
  const std::string plan_file = plan(two_units);
  Program first({"study", "variants", plan_file, "--quiet", "--out", toy_.out()});
  while (!fs::exists(study() / "lock") && first.is_running()) first.ends_within(0.005);
  const Result second = toy_.run({"study", "variants", plan_file, "--quiet"});
  EXPECT_EQ(second.status, 3);
  EXPECT_SAYS(second.err, "writes here");
  first.send(SIGTERM);
  first.wait();
}

}  // namespace
}  // namespace thermotwin::cases
