// SPDX-License-Identifier: GPL-3.0-or-later
// `run` on the toy machine, and what it leaves: the contract of the files, that they fit together,
// and that what was found is what was hidden.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "core/table.h"
#include "tests/cases/toy.h"
#include "tests/cases/vtk_files.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json parsed(const fs::path& file) { return json::parse(read(file)); }

// ctest runs this one first; the others look at its results.
TEST(WholeChain, Runs) {
  const Result result = make_toy_run();
  ASSERT_EQ(result.status, 0) << result.err;
  const json summary = json::parse(result.out);
  EXPECT_EQ(summary, parsed(fs::path(THERMOTWIN_RUN_DIR) / "summary.json"));
  EXPECT_SAYS(result.err, "measuring a machine");  // progress, on stderr
}

TEST(WholeChain, LeavesAllFiles) {
  const auto files = files_in(toy_run());
  for (const char* name :
       {"model.rom.h5", "summary.json", "measurement/channels.toml", "measurement/data.csv", "diagnosis/diagnosis.json",
        "diagnosis/report.html", "diagnosis/extended/machine.toml", "diagnosis/extended/model.rom.h5",
        "fields/warm_up.pvd", "fields/warm_up.vtu", "fields/poses.vtp"})
    EXPECT_EQ(files.count(name), 1U) << name;
  for (const std::string load : {"ambient", "warm_up", "mixed"}) {
    for (const char* table : {"/tcp.csv", "/sensors.csv"})
      EXPECT_EQ(files.count("campaign/" + load + table), 1U) << load << table;
  }
  EXPECT_EQ(files.count("machine.png"), std::getenv("DISPLAY") != nullptr ? 1U : 0U);
  for (const auto& [name, bytes] : files) {
    EXPECT_EQ(name.find("part-"), std::string::npos) << name;
    EXPECT_FALSE(bytes.empty()) << name;
  }
}

TEST(WholeChain, SummaryTellsWhatWasFound) {
  const json summary = parsed(toy_run() / "summary.json");
  EXPECT_EQ(summary["machine"], "toy");
  EXPECT_EQ(summary["mesh"]["bodies"], 9);
  EXPECT_EQ(summary["campaign"]["poses"], 27);
  EXPECT_EQ(summary["campaign"]["loads"], 3);
  ASSERT_EQ(summary["reduced"]["heldout"].size(), 1U);
  const json& heldout = summary["reduced"]["heldout"][0];
  EXPECT_GT(heldout["peak_um"], 30.0);
  EXPECT_LT(heldout["max_um"].get<double>(), 0.02 * heldout["peak_um"].get<double>());
  EXPECT_GT(summary["compensation"]["reduction_percent"], 70.0);
  // The toy's files are as coarse as their shape allows: no size changes them.
  EXPECT_SAYS(summary["compensation"]["measured_mesh"].get<std::string>(), "the model's own mesh");
  EXPECT_EQ(summary["diagnosis"], parsed(toy_run() / "diagnosis/diagnosis.json"));
}

TEST(WholeChain, TablesHaveTheirColumnsAndRows) {
  const core::Table tcp = core::read_csv(toy_run() / "campaign/mixed/tcp.csv");
  std::vector<std::string> expected{"time_s", "X_mm", "Y_mm", "Z_mm", "B_deg", "C_deg"};
  for (const char* side : {"", "_tool", "_table"}) {
    for (const char* quantity : {"dx", "dy", "dz", "ra", "rb", "rc"})
      expected.push_back(std::string(quantity) + (quantity[0] == 'd' ? "_um" : "_um_per_m") + side);
  }
  EXPECT_EQ(tcp.columns, expected);
  const core::Table sensors = core::read_csv(toy_run() / "campaign/mixed/sensors.csv");
  EXPECT_EQ(sensors.columns, (std::vector<std::string>{"time_s", "T1_C", "T2_C", "T3_C", "T4_C"}));
  EXPECT_EQ(sensors.rows(), 91);
  EXPECT_EQ(tcp.rows(), 91 * 27);
  EXPECT_TRUE(tcp.values.allFinite());
  core::require_time_column(sensors);
  std::set<std::array<double, 3>> poses;
  for (Eigen::Index i = 0; i < 27; ++i) poses.insert({tcp.values(i, 1), tcp.values(i, 2), tcp.values(i, 3)});
  EXPECT_EQ(poses.size(), 27U);
  // error = tool side - table side
  for (const std::string quantity : {"dx_um", "dz_um", "rb_um_per_m"}) {
    EXPECT_LT(
        (tcp.column(quantity) - tcp.column(quantity + "_tool") + tcp.column(quantity + "_table")).cwiseAbs().maxCoeff(),
        1e-4)
        << quantity;
  }
}

void expect_keys(const json& object, const std::set<std::string>& keys, const std::string& place) {
  std::set<std::string> found;
  for (const auto& [key, value] : object.items()) found.insert(key);
  EXPECT_EQ(found, keys) << place;
}

// The schema that other programs rely on: required keys and the types of their values.
TEST(WholeChain, DiagnosisHasItsSchema) {
  const json d = parsed(toy_run() / "diagnosis/diagnosis.json");
  expect_keys(d,
              {"schema", "verdict", "sentence", "actions", "causes", "ranking", "explanations", "ambiguous_set",
               "reading_steps", "residual", "gain", "detectability", "next_measurement", "extended_machine", "warnings",
               "notes"},
              "top");
  EXPECT_FALSE(d["sentence"].get<std::string>().empty());
  for (const char* key : {"actions", "warnings", "notes"}) {
    ASSERT_TRUE(d[key].is_array());
    for (const json& text : d[key]) EXPECT_TRUE(text.is_string());
  }
  const std::set<std::string> verdicts{"explained", "no_discrepancy", "ambiguous", "unexplained"};
  EXPECT_EQ(verdicts.count(d["verdict"]), 1U);
  for (const json& cause : d["causes"]) {
    for (const char* key : {"kind", "where", "probability", "parameters"}) EXPECT_TRUE(cause.contains(key)) << key;
    EXPECT_TRUE(cause["probability"].is_number());
    for (const auto& [name, parameter] : cause["parameters"].items()) {
      expect_keys(parameter, {"value", "std", "unit"}, name);
      EXPECT_TRUE(parameter["value"].is_number() && parameter["std"].is_number() && parameter["unit"].is_string())
          << name;
    }
  }
  std::set<std::string> kinds;
  double before = 1.0;
  for (const json& row : d["ranking"]) {
    expect_keys(row, {"kind", "where", "probability", "log_evidence"}, "ranking");
    kinds.insert(row["kind"]);
    EXPECT_LE(row["probability"], before);
    before = row["probability"];
  }
  EXPECT_EQ(kinds.count("none") + kinds.count("unknown"), 2U);
  ASSERT_TRUE(d["ambiguous_set"].is_array());
  ASSERT_EQ(d["residual"]["per_channel"].size(), 10U);  // four sensors, three displacements at two poses
  for (const json& channel : d["residual"]["per_channel"])
    expect_keys(channel, {"id", "rms_before", "rms_after", "unit", "p_value_white"}, "residual");
  expect_keys(d["gain"], {"heldout_rms_before_um", "heldout_rms_after_um", "reduction_percent", "ci95_percent"},
              "gain");
  EXPECT_EQ(d["gain"]["ci95_percent"].size(), 2U);
  expect_keys(d["next_measurement"], {"load", "channel", "why", "duration_h", "outcomes"}, "next_measurement");
  ASSERT_GT(d["detectability"].size(), 10U);
  for (const json& row : d["detectability"])
    expect_keys(row, {"kind", "unit", "least", "best_where", "most", "worst_where", "invisible"}, "detectability");
  EXPECT_EQ(d["extended_machine"], "extended/machine.toml");
}

// The measured machine's spindle gives 1.8 times the heat, times a nominal uncertainty of 5 %.
TEST(WholeChain, DiagnosisFindsWhatWasHidden) {
  const json d = parsed(toy_run() / "diagnosis/diagnosis.json");
  ASSERT_EQ(d["verdict"], "explained");
  const json& cause = d["causes"][0];
  EXPECT_EQ(cause["kind"], "source_power");
  EXPECT_EQ(cause["where"], "spindle.bearings");
  EXPECT_NEAR(cause["parameters"]["factor"]["value"], 1.8, 0.2);
  EXPECT_GT(d["gain"]["reduction_percent"], 60.0);
  ASSERT_EQ(d["actions"].size(), 1U);
  EXPECT_SAYS(d["actions"][0].get<std::string>(), "Check the power of spindle.bearings");
}

// The copy is a case of its own; with its machine nothing is left to explain, and compensation gains.
TEST(WholeChain, AnAcceptedExtensionIsACaseOfItsOwn) {
  const Toy toy;
  toy.take_results();
  toy.take_measurement();
  const core::TemporaryFolder elsewhere;
  const std::string accepted = (elsewhere / "better").string();
  const std::vector<std::string> command{
      "diagnose", toy.path(), "--data", toy.path() + "/measurement", "--model", toy.result("model.rom.h5").string(),
      "--accept", accepted};
  const Result result = toy.run(command);
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "to do: Check the power of spindle.bearings");
  EXPECT_SAYS(result.out, "diagnosed again with the extended model: No discrepancy");
  EXPECT_SAYS(result.out, "extended");
  EXPECT_SAYS(read(elsewhere / "better/machine.toml"), "diagnosis: source_power factor");
  EXPECT_FALSE(std::filesystem::exists(accepted + ".part"));
  std::filesystem::rename(toy.path(), toy.path() + "_gone");
  const Result mesh = thermotwin({"mesh", accepted, "--out", (elsewhere / "out").string()});
  EXPECT_EQ(mesh.status, 0) << mesh.err;
  std::filesystem::rename(toy.path() + "_gone", toy.path());
  const Result again = toy.run(command);
  EXPECT_EQ(again.status, 3);
  EXPECT_SAYS(again.err, "a folder that exists");
}

TEST(WholeChain, ParaviewFilesOpenAgain) {
  const long nodes = parsed(toy_run() / "summary.json")["mesh"]["nodes"];
  const VtkFile fields = read_vtk(toy_run() / "fields/warm_up.vtu");
  EXPECT_EQ(fields.points, nodes);
  EXPECT_EQ(fields.cells, parsed(toy_run() / "summary.json")["mesh"]["elements"]);
  EXPECT_EQ(fields.point_arrays,
            (std::vector<std::string>{"temperature_C", "displacement_um", "stress_MPa", "von_mises_MPa"}));
  EXPECT_TRUE(fields.finite);
  EXPECT_GT(fields.time, 0);
  EXPECT_GT(fields.highest_C, 30);
  EXPECT_GT(fields.lowest_C, 15);
  const VtkFile poses = read_vtk(toy_run() / "fields/poses.vtp");
  EXPECT_EQ(poses.points, 27);
  EXPECT_NE(std::find(poses.point_arrays.begin(), poses.point_arrays.end(), "error_um"), poses.point_arrays.end());
  const std::string series = read(toy_run() / "fields/warm_up.pvd");
  EXPECT_SAYS(series, "type=\"Collection\"");
  EXPECT_SAYS(series, "file=\"warm_up.vtu\"");
}

TEST(WholeChain, SimulationGivesASeriesOfFields) {
  const Toy toy;
  const Result result =
      toy.run({"simulate", toy.path(), "--load", "ambient", "--pose", "X=100,Z=20,B=45", "--fields-every", "7200"});
  ASSERT_EQ(result.status, 0) << result.err;
  const fs::path folder = toy.result("simulate/ambient");
  const std::string series = read(folder / "fields.pvd");
  for (int i = 0; i < 3; ++i) {
    const std::string name = "fields/00000" + std::to_string(i) + ".vtu";
    EXPECT_SAYS(series, "file=\"" + name + "\"");
    EXPECT_DOUBLE_EQ(read_vtk(folder / name).time, 7200.0 * i);
  }
  const core::Table tcp = core::read_csv(folder / "tcp.csv");
  EXPECT_EQ(tcp.rows(), 17);
  EXPECT_EQ(tcp.column("X_mm")[3], 100);
  EXPECT_EQ(tcp.column("B_deg")[3], 45);
  EXPECT_EQ(core::read_csv(folder / "sensors.csv").rows(), 17);
}

// From its own folder, with the CAD files that the case has.
TEST(WholeChain, ExtendedMachineCanBeMeshedAndMeasuresBetter) {
  const Toy toy;
  const Result mesh = toy.run({"mesh", (toy_run() / "diagnosis/extended").string(), "--json"});
  ASSERT_EQ(mesh.status, 0) << mesh.err;
  const Result nominal = thermotwin({"mesh", toy.path(), "--json", "--out", toy.out()});
  const json extended = json::parse(mesh.out);
  EXPECT_EQ(extended, json::parse(nominal.out));
  for (const json& body : extended["bodies"]) {
    const VtkFile file = read_vtk(toy.result("mesh/" + body["id"].get<std::string>() + ".vtu"));
    EXPECT_EQ(file.points, body["nodes"]);
  }

  const auto rms = [&](const std::string& model) {
    const Result result = toy.run({"evaluate", "--data", (toy_run() / "measurement").string(), "--model",
                                   (toy_run() / model).string(), "--models", "static_regression", "--json"});
    EXPECT_EQ(result.status, 0) << result.err;
    const json summary = json::parse(result.out);
    for (const json& row : summary["rows"])
      if (row["model"] == "reduced_model" && row["channel"] == "dz@1") return row["rms"].get<double>();
    return std::nan("");
  };
  EXPECT_LT(rms("diagnosis/extended/model.rom.h5"), 0.5 * rms("model.rom.h5"));
}

TEST(WholeChain, ExtendedMachineStandsByItself) {
  const Toy toy;
  toy.take_results();
  toy.take_measurement();
  ASSERT_EQ(toy.run({"diagnose", toy.path(), "--data", toy.path() + "/measurement", "--model",
                     toy.result("model.rom.h5").string()})
                .status,
            0);
  // What a diagnosis reads it must not replace.
  const auto before = files_in(toy.result("diagnosis/extended"));
  const Result again = toy.run({"diagnose", "--data", toy.path() + "/measurement", "--model",
                                toy.result("diagnosis/extended/model.rom.h5").string()});
  EXPECT_EQ(again.status, 3);
  EXPECT_SAYS(again.err, "another folder as --out");
  EXPECT_EQ(files_in(toy.result("diagnosis/extended")), before);
  const core::TemporaryFolder elsewhere;
  std::filesystem::copy(toy.result("diagnosis/extended"), elsewhere / "sent", std::filesystem::copy_options::recursive);
  std::filesystem::rename(toy.path(), toy.path() + "_gone");
  const Result result = thermotwin({"mesh", (elsewhere / "sent").string(), "--out", (elsewhere / "out").string()});
  EXPECT_EQ(result.status, 0) << result.err;
}

// Bit for bit, from the mesh to the diagnosis; toy_run had all cores.
TEST(WholeChain, DoesNotDependOnThreads) {
  auto expected = files_in(toy_run());
  // A run has the fields of more programs in it than a reduction, and a page names the commands that may follow.
  const std::set<std::string> own{"scene.bin", "diagnosis/report.html"};
  for (const std::string& name : own) expected.erase(name);
  for (const char* threads : {"1", "2"}) {
    const Toy toy;
    ASSERT_EQ(toy.run({"reduce", toy_case().string(), "--threads", threads}).status, 0);
    ASSERT_EQ(toy.run({"diagnose", toy_case().string(), "--model", toy.result("model.rom.h5").string(), "--data",
                       (toy_run() / "measurement").string(), "--threads", threads})
                  .status,
              0);
    for (const auto& [name, bytes] : results_in(toy.out())) {
      if (name.starts_with("cache/")) continue;
      if (own.contains(name)) expected.emplace(name, bytes);
      ASSERT_EQ(expected.count(name), 1U) << name;
      EXPECT_TRUE(expected.at(name) == bytes) << name << " with " << threads << " threads";
    }
    EXPECT_TRUE(fs::exists(toy.result("campaign/mixed/tcp.csv")));
  }
}

// An earlier run's measurement or snapshots must not pass for those of a changed case.
TEST(WholeChain, ResumeSeesWhatChanged) {
  const Toy toy;
  toy.take_results();
  toy.edit("loads/warm_up.toml", "spindle_rpm = 9000", "spindle_rpm = 10000");
  toy.edit("loads/mixed.toml", "spindle_rpm = 6000", "spindle_rpm = 5000");
  // Tables of the changed programs, without the snapshots that a reduction needs.
  ASSERT_EQ(toy.run({"campaign", toy.path()}).status, 0);
  ASSERT_EQ(toy.run({"run", toy.path(), "--resume"}).status, 0);
  const std::string fresh = toy.file("fresh");
  ASSERT_EQ(thermotwin({"run", toy.path(), "--out", fresh}).status, 0);
  auto expected = results_in(fresh), found = results_in(toy.out());
  // The summary states times; the campaign's page and the fields in it are of that verb alone.
  for (auto* files : {&expected, &found}) {
    for (const char* name : {"summary.json", "machine.png", "campaign/report.html"}) files->erase(name);
    std::erase_if(*files, [](const auto& file) { return file.first.ends_with("/fields.bin"); });
  }
  EXPECT_EQ(changes(expected, found), std::vector<std::string>());
}

}  // namespace
}  // namespace thermotwin::cases
