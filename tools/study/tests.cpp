// SPDX-License-Identifier: GPL-3.0-or-later
// The verb that chooses load programs and their order for a test, and confirms it on machines measured virtually.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/file.h"
#include "core/folder_guard.h"
#include "core/folder_lock.h"
#include "core/progress.h"
#include "core/table.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/plan/plan_files.h"
#include "metrology/probe/probe_setup.h"
#include "solver/elastic/tcp.h"
#include "study/tests/stated_parameters.h"
#include "study/tests/test_blocks.h"
#include "study/units/unit_files.h"
#include "tools/chain.h"
#include "tools/page.h"
#include "tools/study/tests_page.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;
using nlohmann::json;
using study::TestBlock;
using study::TestOrder;
using study::TestPath;

constexpr double before_end_s = 1.0;  ///< of the standstill, when the probe is read

study::BlockOptions block_options(const StudyTestsOptions& options, const mesh::Machine& machine) {
  study::BlockOptions blocks;
  blocks.block_s = options.block_min * core::units::minute;
  blocks.interval_s = options.interval_min * core::units::minute;
  blocks.probe_every_s = options.no_probe ? 0.0 : options.probe_every_min * core::units::minute;
  blocks.probe_pose = mesh::parse_pose(machine, options.probe_pose, "--probe-pose");
  blocks.seed = options.seed;
  return blocks;
}

study::TestSetup setup_of(const StudyTestsOptions& options, const reduction::ReducedModel& model) {
  const mesh::Machine& machine = model.machine;
  study::TestSetup setup;
  setup.parameters =
      study::chosen_parameters(study::stated_parameters(machine, model.parts.has_value()), options.parameters, machine);
  for (study::UncertainParameter& one : study::uncertain_parameters(model))
    if (one.parameter.kind == diagnosis::Kind::ambient_offset) setup.surroundings.push_back(std::move(one));
  for (int s = 0; s < std::ssize(machine.sensors); ++s) setup.sensors.push_back(s);
  if (!options.no_probe) setup.probes.push_back(mesh::parse_pose(machine, options.probe_pose, "--probe-pose"));
  const int air = machine.ambient_index("air");
  setup.start_C = air < 0 ? machine.reference_C : machine.ambients[air].default_C.value;
  setup.reading_s = options.every_min * core::units::minute;
  setup.step_s = std::min(setup.step_s, setup.reading_s);
  setup.bias_K = options.bias_K;
  setup.probe_std_um = options.probe_um;
  if (setup.sensors.empty() && setup.probes.empty()) {
    throw core::InputError(machine.path.string(), "no [[sensor]], and --no-probe",
                           "a [[sensor]] that the test reads, or a probe (without --no-probe)");
  }
  return setup;
}

/// @param left_out  receives the names of programs that set the surroundings
std::vector<TestBlock> candidate_blocks(const StudyTestsOptions& options, const solver::Case& machine_case,
                                        const study::BlockOptions& how, std::vector<std::string>& left_out) {
  const mesh::Machine& machine = machine_case.machine;
  std::vector<TestBlock> blocks;
  if (!options.no_standard) blocks = study::standard_blocks(machine, how);
  if (!options.no_programs) {
    for (const solver::LoadProgram& load :
         load_programs(machine_case, options.programs.empty() ? machine_case.train : options.programs)) {
      if (!options.chamber && study::moves_surroundings(machine, load))
        left_out.push_back(load.name());
      else
        blocks.push_back(study::program_block(machine, load, how, load.duration()));
    }
  }
  const double seconds = options.hours * core::units::hour;
  std::erase_if(blocks, [&](const TestBlock& block) { return block.seconds() > seconds + 1e-3; });
  if (!blocks.empty()) return blocks;
  throw core::InputError("--hours", fmt::format("{:g} h", options.hours),
                         left_out.empty() ? "at least the length of one block"
                                          : "at least the length of one block; " + core::join(left_out) +
                                                " set the temperature of the surroundings: --chamber allows them");
}

core::Table points_of(const mesh::Machine& machine, const TestPath& path, const mesh::Pose& probe) {
  core::Table table;
  table.source = "points.csv";
  table.columns = {"time_s", "cycle"};
  for (const std::string& column : mesh::pose_columns(machine)) table.columns.push_back(column);
  for (const char* column : {"x_mm", "y_mm", "z_mm"}) table.columns.emplace_back(column);
  std::vector<double> times{0.0};
  double now = 0.0;
  for (const TestBlock* block : path.blocks) {
    for (const study::TestPhase& phase : block->phases) {
      now += phase.seconds;
      if (phase.probes) times.push_back(now - before_end_s);
    }
  }
  table.values.resize(std::ssize(times), std::ssize(table.columns));
  const Eigen::Vector3d point = solver::tcp_position(machine, probe) / core::units::mm;
  for (Index i = 0; i < table.rows(); ++i) {
    table.values(i, 0) = times[i];
    table.values(i, 1) = i + 1;
    table.values.row(i).segment(2, std::ssize(machine.axes)) = mesh::pose_values(machine, probe).transpose();
    table.values.row(i).tail<3>() = point.transpose();
  }
  return table;
}

std::string csv_word(const std::string& words) {
  return words.find(',') == std::string::npos ? words : '"' + words + '"';
}

std::string tests_csv(const TestStudy& study) {
  std::string text = "hours,block,variance_um2,left_um,tells\n";
  text += fmt::format("0,-,{:.9g},{:.9g},\n", study.prior_um2, std::sqrt(study.prior_um2));
  for (std::size_t i = 0; i < study.chosen.blocks.size(); ++i) {
    text +=
        fmt::format("{:.9g},{},{:.9g},{:.9g},{}\n", study.chosen.hours[i], csv_word(study.chosen.blocks[i]->name),
                    study.chosen.variance_um2[i], std::sqrt(study.chosen.variance_um2[i]), csv_word(told_by(study, i)));
  }
  return text;
}

std::string orders_csv(const TestStudy& study) {
  std::string text = "order,hours,block,variance_um2,left_um\n";
  const auto add = [&](const std::string& name, const TestPath& path) {
    for (std::size_t i = 0; i < path.blocks.size(); ++i) {
      text += fmt::format("{},{:.9g},{},{:.9g},{:.9g}\n", name, path.hours[i], csv_word(path.blocks[i]->name),
                          path.variance_um2[i], std::sqrt(path.variance_um2[i]));
    }
  };
  add("chosen", study.chosen);
  add("iso_230_3", study.iso);
  for (std::size_t r = 0; r < study.random.size(); ++r) add(fmt::format("random_{}", r + 1), study.random[r]);
  return text;
}

std::string parameters_csv(const TestStudy& study) {
  std::string text = "parameter,prior_percent,chosen_percent,random_percent,iso_230_3_percent,gain_um2\n";
  const auto rows = parameter_table(study);
  for (std::size_t i = 1; i < rows.size(); ++i) text += core::join(rows[i], ",") + "\n";
  return text;
}

json json_of_tests(const TestStudy& study, std::size_t candidates) {
  json blocks = json::array(), random = json::array();
  for (std::size_t i = 0; i < study.chosen.blocks.size(); ++i) {
    blocks.push_back({{"block", study.chosen.blocks[i]->name},
                      {"until_h", study.chosen.hours[i]},
                      {"variance_um2", study.chosen.variance_um2[i]},
                      {"tells", told_by(study, i)}});
  }
  for (const TestPath& path : study.random) random.push_back(path.end_um2());
  json summary = {{"parameters", study.parameters.size()},
                  {"candidates", candidates},
                  {"left_out", study.left_out},
                  {"prior_um2", study.prior_um2},
                  {"chosen_um2", study.chosen.end_um2()},
                  {"start", study.start},
                  {"greedy_um2", study.greedy_um2},
                  {"random_um2", random},
                  {"best_random_um2", study.best().end_um2()},
                  {"iso_230_3_um2", study.iso.end_um2()},
                  {"below_best_random_percent", study.gain_percent(study.best())},
                  {"below_iso_230_3_percent", study.gain_percent(study.iso)},
                  {"blocks", blocks}};
  if (study.leave_um > 0) {
    const auto hours = [&](const TestPath& path) {
      const std::optional<double> until = study.hours_until(path);
      return until ? json(*until) : json();
    };
    summary["leave_um"] = study.leave_um;
    summary["hours_until"] = {{"chosen", hours(study.chosen)}, {"iso_230_3", hours(study.iso)}};
    for (const TestPath& path : study.random) summary["hours_until"]["random"].push_back(hours(path));
  }
  if (!study.confirmed.empty()) {
    json nominal = json::array(), chosen = json::array(), other = json::array();
    for (const study::ConfirmedMachine& one : study.confirmed) {
      nominal.push_back(one.nominal_um);
      chosen.push_back(one.tests_um[0]);
      other.push_back(one.tests_um[1]);
    }
    summary["confirmed"] = {{"nominal_um", nominal}, {"chosen_um", chosen}, {"random_um", other}};
  }
  return summary;
}

void write_test(const StudyTestsOptions& options, const mesh::Machine& machine, const study::TestSetup& setup,
                const TestStudy& study, const std::string& load, const json& summary) {
  core::write_files_by(options.out / "study/tests", [&](const fs::path& staged) {
    std::vector<fs::path> files{"load.toml", "tests.csv", "orders.csv", "parameters.csv"};
    core::write_file(staged / "load.toml", load);
    core::write_file(staged / "tests.csv", tests_csv(study));
    core::write_file(staged / "orders.csv", orders_csv(study));
    core::write_file(staged / "parameters.csv", parameters_csv(study));
    if (!setup.probes.empty()) {
      core::write_csv(staged / "points.csv", points_of(machine, study.chosen, setup.probes.front()), 12);
      core::write_file(
          staged / "plan.toml",
          fmt::format("# SPDX-License-Identifier: GPL-3.0-or-later\nschema = 1\nkind = \"etve\"\nmachine = "
                      "\"{}\"\nload = \"load.toml\"\n",
                      machine.name) +
              metrology::probes_text(metrology::ProbeSetup{}));
      files.insert(files.end(), {"points.csv", "plan.toml"});
    }
    core::write_file(staged / "tests.json", summary.dump(1) + "\n");
    files.emplace_back("tests.json");
    return files;
  });
}

/// Where another order leaves less than the greedy one, the exchange starts from it as well.
void take_better_start(const StudyTestsOptions& options, const study::TestChoice& choice, TestStudy& study) {
  study.greedy_um2 = study.chosen.end_um2();
  const bool iso = !options.no_standard && study.iso.end_um2() < study.best().end_um2();
  const TestPath& other = iso ? study.iso : study.best();
  if (other.end_um2() >= study.greedy_um2) return;
  study.start = iso ? "iso_230_3" : fmt::format("random_{}", study.best_random + 1);
  TestPath from = choice.evaluate(choice.exchanged(other.blocks, options.exchanges));
  study.chosen = from.end_um2() < other.end_um2() ? std::move(from) : other;
}

/// The shortest test that leaves no more than it may: of the chosen order, or of another that is there sooner.
TestPath quickest(const study::TestChoice& choice, const TestStudy& study) {
  const double variance = study.leave_um * study.leave_um;
  TestPath best = choice.evaluate(choice.shortened(study.chosen.blocks, variance));
  std::vector<const TestPath*> others{&study.iso};
  for (const TestPath& path : study.random) others.push_back(&path);
  for (const TestPath* other : others) {
    const std::optional<double> theirs = study.hours_until(*other), own = study.hours_until(best);
    if (!theirs || (own && *own <= *theirs)) continue;
    best = choice.evaluate(choice.shortened(other->blocks, variance));
  }
  return best;
}

/// All orders to their end. @param iso  its blocks
TestStudy compare(const StudyTestsOptions& options, const study::TestChoice& choice,
                  const std::vector<TestBlock>& iso) {
  const double seconds = options.hours * core::units::hour;
  TestStudy study;
  study.prior_um2 = choice.prior_um2();
  study.leave_um = options.leave_um;
  if (study.leave_um * study.leave_um >= study.prior_um2) {
    throw core::InputError("--leave", fmt::format("{:g} um", study.leave_um),
                           fmt::format("less than the {:.3f} um that are left before any test: no test is needed",
                                       std::sqrt(study.prior_um2)));
  }
  study.chosen = choice.evaluate(choice.exchanged(choice.greedy(seconds), options.exchanges));
  TestOrder of_iso;
  for (const TestBlock& block : iso) of_iso.push_back(&block);
  study.iso = choice.evaluate(of_iso);
  core::Progress progress("random orders", options.orders);
  for (int r = 0; r < options.orders; ++r) {
    study.random.push_back(choice.evaluate(choice.random(seconds, options.seed + r)));
    if (study.random.back().end_um2() < study.best().end_um2()) study.best_random = r;
    progress.advance();
  }
  take_better_start(options, choice, study);
  if (study.leave_um > 0) study.chosen = quickest(choice, study);
  return study;
}

}  // namespace

void study_tests(const StudyTestsOptions& given) {
  const Stopwatch time;
  StudyTestsOptions options = given;
  const solver::Case machine_case = open_case(options.case_path, "", 0);
  if (options.loads.empty()) options.loads = machine_case.holdout;
  const std::vector<solver::LoadProgram> loads = load_programs(machine_case, options.loads);
  if (loads.empty()) throw core::UsageError("--load: the case holds no load program out");
  const study::BlockOptions how = block_options(options, machine_case.machine);
  std::vector<std::string> left_out;
  const std::vector<TestBlock> blocks = candidate_blocks(options, machine_case, how, left_out);
  // What is wrong in machine.toml is said before the reduced model is made.
  study::chosen_parameters(study::stated_parameters(machine_case.machine, true), options.parameters,
                           machine_case.machine);
  const fs::path folder = options.out / "study/tests";
  require_writable(folder);
  const core::FolderLock lock(folder);
  core::write_file(folder / study::origin_note, fs::canonical(options.case_path).string() + "\n");
  const core::FolderGuard guard(options.out, folder / study::origin_note);
  if (options.model.empty() && fs::exists(options.out / "model.rom.h5")) options.model = options.out / "model.rom.h5";
  const reduction::ReducedModel model = model_for(options.case_path, options.model, options.out);
  const study::TestSetup setup = setup_of(options, model);
  const std::vector<TestBlock> iso = study::iso_230_3_blocks(model.machine, how, options.hours * core::units::hour);
  Eigen::VectorXd nominal(std::ssize(setup.parameters));
  for (Index p = 0; p < nominal.size(); ++p) nominal[p] = setup.parameters[p].parameter.nominal;
  study::TestRun run(model, nominal, setup);
  const study::TestChoice choice(run, blocks, run.prediction(loads, mesh::workspace_poses(model.machine)));
  TestStudy study = compare(options, choice, iso);
  study.machine = model.machine.name;
  study.parameters = setup.parameters;
  study.left_out = left_out;
  const auto text_of = [&](const TestPath& path, const std::string& title) {
    return study::test_text(model.machine, path.blocks, title, setup.start_C, setup.reading_s);
  };
  const std::string load = text_of(study.chosen, "test chosen by study tests");
  if (options.confirm > 0) {
    study.confirmed =
        study::confirm_tests(machine_case, model, setup,
                             {{"chosen", load}, {"random", text_of(study.random.front(), "random order of blocks")}},
                             options.loads, options.confirm, folder / "measured", options.out / "cache");
  }
  json summary = json_of_tests(study, blocks.size());
  summary["order"] = model.system.order();
  summary["seconds"] = time.seconds();
  summary["peak_GiB"] = peak_memory_GiB();
  write_test(options, model.machine, setup, study, load, summary);
  write_page(folder / "report.html", [&] { return tests_page(options, study); });
  std::string text = core::format_table(test_table(study)) + "\n\n" + test_sentence(study) + "\n";
  if (!study.left_out.empty()) {
    text += "left out, since they set the temperature of the surroundings (--chamber): " + core::join(study.left_out) +
            "\n";
  }
  if (const std::string confirmed = confirmed_sentence(study); !confirmed.empty()) text += confirmed + "\n";
  text += fmt::format("load.toml, tests.csv and report.html in {}; {:.0f} s\n", folder.string(), time.seconds());
  print_summary(options, text, summary.dump());
}

}  // namespace thermotwin::tools
