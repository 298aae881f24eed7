// SPDX-License-Identifier: GPL-3.0-or-later
// The main job: mesh, campaign, reduced model, compensation of an unseen program on a machine
// measured virtually, diagnosis of a measurement, measured drift; a screenful of what was found.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <vector>

#include "compensation/evaluation/evaluate.h"
#include "compensation/evaluation/result.h"
#include "compensation/evaluation/validation.h"
#include "compensation/measurement/measurement_check.h"
#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/toml_place.h"
#include "core/units.h"
#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/machine_value.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/report/diagnosis_json.h"
#include "diagnosis/report/write_diagnosis.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/case.h"
#include "solver/campaign/files.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "solver/elastic/stress.h"
#include "solver/elastic/tcp.h"
#include "solver/export/picture.h"
#include "solver/export/vtk_output.h"
#include "tools/chain.h"
#include "tools/measured_model.h"
#include "tools/options.h"
#include "tools/page.h"
#include "tools/run_page.h"
#include "tools/second_mesh.h"

namespace thermotwin::tools {
namespace {

/// The machine that is measured where there is no measurement.
mesh::Machine measured_machine(const solver::Case& machine_case) {
  const solver::MeasuredMachine& wrong = *machine_case.measured_machine;
  try {
    return diagnosis::with_parameter(compensation::perturbed(machine_case.machine, wrong.seed),
                                     diagnosis::make_parameter(diagnosis::kind_named(wrong.kind), wrong.where),
                                     wrong.factor);
  } catch (const core::InputError& error) {
    throw core::InputError(core::toml_place(machine_case.folder / "case.toml", "measured_machine", "where") + ": " +
                           error.what());
  }
}

/// What only the last steps of the chain need should not be missed after the long ones.
void require_whole_chain(const solver::Case& machine_case) {
  const std::string file = (machine_case.folder / "case.toml").string();
  const auto require = [&](bool given, const char* key, const char* allowed) {
    if (!given) throw core::InputError(file + " " + key, "missing or empty", allowed);
  };
  require(!machine_case.train.empty(), "train", "one or more training loads");
  require(!machine_case.holdout.empty(), "holdout", "one or more held-out loads");
  require(!machine_case.check_points.empty(), "check_points.poses",
          "one or more poses at which the compensation is judged");
  require(!machine_case.measurement.empty() || machine_case.measured_machine, "measurement",
          "a measurement folder, or [measured_machine] to simulate one, for the diagnosis");
  load_programs(machine_case, machine_case.train);
  load_programs(machine_case, machine_case.holdout);
  if (!machine_case.measurement.empty()) {
    compensation::Measurement measurement = compensation::read_measurement(machine_case.measurement);
    keep_plausible(measurement, machine_case.machine.plausible_range());
    compensation::require_fits(measurement, machine_case.machine);
  } else {
    measured_machine(machine_case);
    machine_case.load(machine_case.measured_machine->load);
  }
}

/// The measurement that the case names, or one of the machine that it describes.
compensation::Measurement measurement_of(const solver::Case& machine_case, bool resume,
                                         const std::filesystem::path& out) {
  if (!machine_case.measurement.empty()) return compensation::read_measurement(machine_case.measurement);
  const solver::MeasuredMachine& wrong = *machine_case.measured_machine;
  const mesh::Machine machine = measured_machine(machine_case);
  compensation::VirtualOptions options;
  options.size_factor = wrong.size_factor * mesh::size_factor(machine_case.machine, machine_case.size);
  options.refine = wrong.refine;
  options.seed = wrong.seed;
  options.mesh_cache = out / "cache";

  const auto folder = out / "measurement";
  const mesh::MeshOptions mesh_options{options.size_factor, options.mesh_cache};
  std::string inputs = fmt::format("{} {} {} {} {} {} {} {} {} {}", machine.hash, wrong.load, wrong.kind, wrong.where,
                                   wrong.factor, wrong.seed, options.size_factor, wrong.refine,
                                   solver::word(options.time.scheme), options.time.tolerance_K);
  inputs += solver::hash_of_mesh(mesh::build_machine_mesh(machine, mesh_options));
  inputs += core::read_file(machine_case.folder / "loads" / (wrong.load + ".toml"));
  for (const mesh::Pose& pose : machine_case.check_points) inputs += mesh::format_pose(machine, pose) + " ";
  const std::string made_from = core::content_hash(inputs) + "\n";
  const auto stamp = folder / "made_from.txt";
  if (resume && std::filesystem::exists(stamp) && core::read_file(stamp) == made_from)
    return compensation::read_measurement(folder);

  const solver::FullModel full = solver::build_full_model(machine, mesh_options);
  core::log_line(fmt::format("measuring a machine of {} nodes virtually, {}", full.mesh.nodes(), wrong.load));
  const compensation::Measurement measured =
      compensation::measure_virtually(full, machine_case.load(wrong.load), machine_case.check_points, options);
  core::write_files_by(folder, [&](const std::filesystem::path& staged) {
    compensation::write_measurement(staged, measured);
    core::write_file(staged / "made_from.txt", made_from);
    return std::vector<std::filesystem::path>{"data.csv", "channels.toml", "made_from.txt"};
  });
  return compensation::read_measurement(folder);
}

/// Temperature and deformation of one load when its error in mid-workspace is largest, and the poses' errors.
void write_pictures(const solver::FullModel& full, const solver::Case& machine_case, const std::filesystem::path& out,
                    const std::string& load) {
  const mesh::Machine& machine = machine_case.machine;
  solver::CampaignOptions options;
  options.keep_snapshots = true;
  const auto poses = mesh::workspace_poses(machine);
  options.poses = {poses[poses.size() / 2]};
  const solver::LoadResult result = solver::run_campaign(full, {machine_case.load(load)}, options).front();
  Eigen::Index worst = 0;
  const Eigen::VectorXd dz = result.tcp.column("dz_um"), dy = result.tcp.column("dy_um"),
                        dx = result.tcp.column("dx_um");
  (dx.array().square() + dy.array().square() + dz.array().square()).maxCoeff(&worst);
  const Eigen::VectorXd state = result.snapshots.col(worst);
  const Eigen::VectorXd temperature_C = (state.head(full.mesh.nodes()).array() + machine.reference_C).matrix();
  const mesh::Pose& pose = options.poses.front();
  const Eigen::Matrix3Xd displacement = full.elastic.displacement(state, pose);
  const double time = result.sensors.values(worst, 0);

  std::vector<solver::TcpError> errors;
  for (const mesh::Pose& p : poses) {
    const solver::OutputRows rows = full.elastic.output_rows(p);
    errors.push_back(solver::tcp_error(machine, p, rows.tool * state, rows.table_axis * state, rows.table_own * state));
  }
  core::write_files_by(out / "fields", [&](const std::filesystem::path& staged) {
    const std::string name = load + ".vtu", series = load + ".pvd";
    solver::write_fields(staged / name, full.mesh, pose, temperature_C, displacement, time,
                         solver::MachineStress(full.mesh).nodal(displacement, state));
    solver::write_poses(staged / "poses.vtp", machine, poses, errors);
    solver::write_pvd(staged / series, {{time, name}});
    return std::vector<std::filesystem::path>{name, "poses.vtp", series};
  });
  if (solver::has_display()) {
    solver::write_picture(
        out / "machine.png", full.mesh, pose, temperature_C, displacement, 3000,
        fmt::format("{}: {} after {:.1f} h, deformation x 3000", machine.name, load, time / core::units::hour));
  } else
    core::log_line("machine.png is not written, because there is no display; xvfb-run -a provides one");
}

/// Three models on the measured drift, or nothing where there are no data.
std::optional<compensation::Evaluation> measured_drift() {
  const char* folder = std::getenv("THERMOTWIN_DATA");
  if (!folder) return std::nullopt;
  const auto data = std::filesystem::path(folder) / "measured_drift";
  if (!std::filesystem::exists(data / "data.csv")) return std::nullopt;
  compensation::EvaluateOptions options;
  options.models = {"static_regression", "first_order", "grey_box"};
  return compensation::evaluate(compensation::read_measurement(data), nullptr, options);
}

/// A line per model: RMS removed per axis on each held-out day.
std::string drift_lines(const compensation::Evaluation& drift, nlohmann::json& json) {
  std::map<std::string, std::map<std::string, std::string>> lines;
  for (const auto& row : drift.rows) {
    if (row.training) continue;
    std::string& days = lines[row.model][row.channel];
    days += fmt::format("{}{:.0f}", days.empty() ? "" : ", ", row.measures.rms_reduction_percent);
    json["measured_drift"].push_back({{"model", row.model},
                                      {"channel", row.channel},
                                      {"part", row.segment},
                                      {"rms_reduction_percent", row.measures.rms_reduction_percent}});
  }
  std::string text;
  for (const auto& [model, channels] : lines) {
    text += fmt::format("            {:18}", model);
    for (const auto& [channel, days] : channels) text += fmt::format("  {} {} %", channel, days);
    text += '\n';
  }
  return text;
}

/// What is hidden in a measurement that was made here, as a ratio of the nominal machine's value; may be empty.
std::string hidden_truth(const solver::Case& machine_case) {
  if (!machine_case.measured_machine || !machine_case.measurement.empty()) return "";
  const solver::MeasuredMachine& wrong = *machine_case.measured_machine;
  mesh::Machine nominal = machine_case.machine;
  mesh::Machine measured = measured_machine(machine_case);
  const diagnosis::Parameter effect = diagnosis::make_parameter(diagnosis::kind_named(wrong.kind), wrong.where);
  const double ratio = *diagnosis::machine_values(measured, effect).front().value /
                       *diagnosis::machine_values(nominal, effect).front().value;
  return fmt::format("hidden in the virtual measurement of {}: {} of {} x {:.3g}", wrong.load, wrong.kind, wrong.where,
                     ratio);
}

/// What each step of the chain adds to the terminal's text and to summary.json.
struct Findings {
  std::string text;
  nlohmann::json json;
};

void add_mesh(const solver::Case& machine_case, const solver::FullModel& full, double seconds, Findings& found) {
  const mesh::Machine& machine = machine_case.machine;
  Eigen::Index elements = 0;
  for (const mesh::TetMesh& body : full.mesh.bodies) elements += body.elements();
  found.text +=
      fmt::format("mesh        {} bodies, {} nodes, {} tetrahedra, {} joints ({}); {:.0f} s\n", machine.bodies.size(),
                  full.mesh.nodes(), elements, machine.joints.size(), machine_case.size, seconds);
  found.json["mesh"] = {{"bodies", machine.bodies.size()}, {"nodes", full.mesh.nodes()}, {"elements", elements}};
}

void add_reduced(const ReducedCase& made, Eigen::Index unknowns, Findings& found) {
  auto& [text, json] = found;
  text +=
      fmt::format("campaign    {} load programs x {} poses; {:.0f} s\n", made.loads, made.poses, made.campaign_seconds);
  text += fmt::format("reduced     order {} for {} unknowns; basis and projection {:.0f} s\n", made.summary.order,
                      unknowns, made.summary.basis_seconds + made.summary.projection_seconds);
  json["campaign"] = {{"loads", made.loads}, {"poses", made.poses}, {"seconds", made.campaign_seconds}};
  json["reduced"]["order"] = made.summary.order;
  for (const reduction::ReductionErrors& e : made.model.errors) {
    text += fmt::format("  held out  {:18} reduced against full: {:.3f} um at most, {:.2f} % of the peak {:.1f} um{}\n",
                        e.load, e.max_um, 100 * e.max_um / e.peak_um, e.peak_um,
                        e.estimate_max_um > 0 ? fmt::format("; estimated {:.3f}", e.estimate_max_um) : "");
    json["reduced"]["heldout"].push_back({{"load", e.load}, {"max_um", e.max_um}, {"peak_um", e.peak_um}});
  }
}

/// Null where the machine has no linear axis.
nlohmann::json moved_median(const compensation::Validation& validation, const std::string& load) {
  const double removed = compensation::quantile(validation.moved_reductions(load, compensation::With::sensors), 0.5);
  return std::isfinite(removed) ? nlohmann::json(removed) : nlohmann::json();
}

/// An unseen program on one machine that is measured virtually.
compensation::Validation compensate_unseen(const solver::Case& machine_case, const reduction::ReducedModel& model,
                                           const std::filesystem::path& out, Findings& found) {
  const Stopwatch step;
  compensation::ValidationOptions options;
  options.loads = {machine_case.holdout.front()};
  options.draws = options.traced_draws = 1;
  options.machine.size_factor *= mesh::size_factor(machine_case.machine, machine_case.size);
  options.machine.mesh_cache = out / "cache";
  compensation::Validation validation = compensation::validate_online(machine_case, model, options);
  const std::string& unseen = options.loads.front();
  const double bare = validation.median_reduction(unseen, false), sensed = validation.median_reduction(unseen, true);
  using compensation::ValidationRow;
  found.text += fmt::format(
      "compensated {} on a virtual machine ({} nodes, perturbed parameters, noise), {} check points:\n            RMS "
      "{:.1f} um -> {:.1f} um, {:.1f} % removed; without temperature sensors {:.1f} %; {:.0f} s\n",
      unseen, validation.measured_nodes, validation.rows.size(), validation.rms(unseen, &ValidationRow::rms_before_um),
      validation.rms(unseen, &ValidationRow::rms_sensors_um), sensed, bare, step.seconds());
  if (const std::string stays = validation.unmoved_sentence(unseen); !stays.empty())
    found.text += "            " + stays + "\n";
  const std::string mesh = about_measured_mesh(model, validation.measured_nodes);
  found.text += "            measured on " + mesh + "\n";
  found.json["compensation"] = {{"load", unseen},
                                {"reduction_percent", sensed},
                                {"reduction_no_sensors_percent", bare},
                                {"unmoved_directions", validation.unmoved_directions},
                                {"unmoved_rms_um", validation.rms(unseen, &ValidationRow::rms_unmoved_um)},
                                {"reduction_moved_percent", moved_median(validation, unseen)},
                                {"measured_mesh", mesh}};
  return validation;
}

diagnosis::Diagnosis diagnose_measurement(const solver::Case& machine_case, const solver::FullModel& full,
                                          const reduction::ReducedModel& model, const RunOptions& options,
                                          Findings& found) {
  const mesh::Machine& machine = machine_case.machine;
  compensation::Measurement measurement = measurement_of(machine_case, options.resume, options.out);
  compensation::blank_implausible(measurement, machine.plausible_range());  // warned of before the long work
  compensation::require_fits(measurement, machine);
  diagnosis::Diagnosis diagnosed =
      diagnosis::diagnose(model, measurement, {.programs = programs_of(machine_case, machine)});
  const auto data = machine_case.measurement.empty() ? options.out / "measurement" : machine_case.measurement;
  diagnosis::write_diagnosis(
      options.out / "diagnosis", diagnosed, model,
      diagnosis::make_scene(full.mesh, diagnosis::marked_causes(diagnosed)),
      steps_after(diagnosed, options.case_path, {data}, options.out / "model.rom.h5", options.out));
  found.text += fmt::format("diagnosis   {}\n", diagnosed.sentence);
  if (const std::string hidden = hidden_truth(machine_case); !hidden.empty())
    found.text += "            " + hidden + "\n";
  found.json["diagnosis"] = nlohmann::json::parse(diagnosis::diagnosis_json(diagnosed));
  return diagnosed;
}

}  // namespace

void run(const RunOptions& options) {
  const Stopwatch total;
  const solver::Case machine_case = open_case(options.case_path, options.size, options.mesh_order);
  require_whole_chain(machine_case);
  Findings found{"", {{"machine", machine_case.machine.name}, {"size", machine_case.size}}};

  const Stopwatch building;
  const solver::FullModel full = build(machine_case, options.out, options.solver);
  add_mesh(machine_case, full, building.seconds(), found);

  const ReducedCase made = make_reduced_model(full, machine_case, {}, options.resume, options.out);
  write_order_picture(options.out / "order.svg", made, machine_case.tolerance_um);
  add_reduced(made, full.thermal.size, found);

  const compensation::Validation validation = compensate_unseen(machine_case, made.model, options.out, found);
  const diagnosis::Diagnosis diagnosed = diagnose_measurement(machine_case, full, made.model, options, found);
  write_pictures(full, machine_case, options.out, made.largest_load);

  if (const auto drift = measured_drift()) {
    found.text +=
        "measured    drift of a real machine, models fitted on the first day; RMS removed on the later days:\n" +
        drift_lines(*drift, found.json);
    core::write_csv(options.out / "evaluation" / "measured_drift.csv", drift->predictions);
  }

  write_page(options.out / "report.html", [&] {
    return run_page({machine_case, options, full, made, validation, diagnosed, hidden_truth(machine_case)});
  });
  found.text += fmt::format(
      "look at     {0}/report.html, {3}{0}/diagnosis/report.html,\n"
      "            {0}/fields/*.pvd and poses.vtp (ParaView), {0}/campaign/*/tcp.csv, {0}/model.rom.h5\n"
      "total       {1:.0f} s, peak memory {2:.2f} GiB\n",
      options.out.string(), total.seconds(), peak_memory_GiB(),
      std::filesystem::exists(options.out / "machine.png") ? options.out.string() + "/machine.png, " : "");
  found.json["seconds"] = total.seconds();
  found.json["peak_memory_GiB"] = peak_memory_GiB();
  core::write_file(options.out / "summary.json", found.json.dump(1) + "\n");
  print_summary(options, found.text, found.json.dump());
}

}  // namespace thermotwin::tools
