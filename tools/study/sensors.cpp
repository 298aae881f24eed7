// SPDX-License-Identifier: GPL-3.0-or-later
// The verb that chooses places for temperature sensors, and confirms the choice on machines measured virtually.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

#include "compensation/evaluation/validation.h"
#include "compensation/online/axis_reach.h"
#include "core/error.h"
#include "core/file.h"
#include "core/folder_lock.h"
#include "core/html_page.h"
#include "core/plot.h"
#include "core/progress.h"
#include "core/quoted.h"
#include "core/text.h"
#include "core/units.h"
#include "diagnosis/report/scene.h"
#include "study/placement/candidates.h"
#include "study/placement/model_errors.h"
#include "study/placement/placed_model.h"
#include "study/placement/responses.h"
#include "study/placement/sensor_choice.h"
#include "tools/chain.h"
#include "tools/page.h"
#include "tools/shell_command.h"
#include "tools/study/study.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;
using Eigen::MatrixXd;
using nlohmann::json;

struct CurvePoint {
  int count;
  double left_um, after_loss_um;
};

/// RMS of the TCP error that the compensator leaves on each machine, um.
struct Confirmed {
  std::vector<double> own, chosen;
  bool own_mesh = false;  ///< of the model: its error takes no part
  double own_um() const { return core::median(own); }
  double chosen_um() const { return core::median(chosen); }
  double change_percent() const { return 100.0 * (chosen_um() / own_um() - 1.0); }
  int better() const {
    int count = 0;
    for (std::size_t i = 0; i < own.size(); ++i) count += chosen[i] < own[i] ? 1 : 0;
    return count;
  }
};

struct Choice {
  std::vector<study::Place> places;  ///< all
  std::vector<int> own, chosen;      ///< indices of the case's sensors (after the places), of the chosen places
  std::vector<CurvePoint> curve;
  std::string second_mesh;  ///< in words; empty: none
  std::string directions;   ///< of the TCP error that count, a sentence; empty: all
  study::Left without_left, own_left, chosen_left;
  double without_um = 0, own_um = 0, own_after_loss_um = 0, chosen_um = 0, chosen_after_loss_um = 0;
  std::vector<double> without_one_um;  ///< after the loss of each chosen one
  std::optional<Confirmed> confirmed;
  /// The criterion of what the machines differ by from the model.
  double predicted_um(const study::Left& of) const { return confirmed->own_mesh ? of.parameters_um : of.all_um(); }
  /// Whether the machines say of choice and case what the criterion says.
  bool borne_out() const {
    return (confirmed->chosen_um() < confirmed->own_um()) == (predicted_um(chosen_left) < predicted_um(own_left));
  }
};

/// Translations at the poses, um per K of state.
MatrixXd translation_rows(const reduction::ReducedModel& model, const std::vector<mesh::Pose>& poses) {
  const MatrixXd all = reduction::value_rows(model, poses);
  MatrixXd rows(3 * std::ssize(poses), all.cols());
  for (Index p = 0; p < std::ssize(poses); ++p) rows.middleRows<3>(3 * p) = all.middleRows<3>(18 * p);
  return rows;
}

bool has_linear_axis(const mesh::Machine& machine) {
  return std::any_of(machine.axes.begin(), machine.axes.end(),
                     [](const mesh::Axis& axis) { return axis.kind == mesh::AxisKind::linear; });
}

/// Offsets remove an error only in directions that a linear axis moves: rows of 3 a pose keep that part. A machine
/// without linear axes keeps all.
class Reach {
public:
  Reach(const mesh::Machine& machine, const std::vector<mesh::Pose>& poses) : moves_(has_linear_axis(machine)) {
    for (const mesh::Pose& pose : poses) reaches_.emplace_back(machine, pose);
  }

  bool moves() const { return moves_; }
  /// "z (dz)": what no axis moves; empty: nothing, or there is no axis.
  std::string unmoved() const { return moves_ && !reaches_.empty() ? reaches_.front().unmoved_directions() : ""; }
  template <class Rows>
  void keep(Eigen::MatrixBase<Rows>& rows) const {
    if (!moves_) return;
    for (std::size_t p = 0; p < reaches_.size(); ++p) {
      for (Index c = 0; c < rows.cols(); ++c) {
        const Eigen::Vector3d all = rows.template block<3, 1>(3 * p, c);
        rows.template block<3, 1>(3 * p, c) -= reaches_[p].unmoved(all);
      }
    }
  }

private:
  bool moves_ = false;
  std::vector<compensation::AxisReach> reaches_;
};

/// In the directions that axes move.
double rms_left(const compensation::Validation& validation, int draw) {
  double sum = 0.0;
  int count = 0;
  for (const compensation::ValidationRow& row : validation.rows) {
    if (row.draw != draw) continue;
    sum += row.rms_sensors_um * row.rms_sensors_um - row.rms_unmoved_um * row.rms_unmoved_um;
    ++count;
  }
  return std::sqrt(std::max(0.0, sum) / std::max(count, 1));
}

/// @param nodes  receives those of the machines' mesh
std::vector<double> left_on_machines(const StudySensorsOptions& options, const solver::Case& machine_case,
                                     const reduction::ReducedModel& model, const std::string& name, Index& nodes) {
  compensation::ValidationOptions settings;
  settings.loads = options.loads;
  settings.draws = options.confirm;
  settings.machine.what = compensation::Perturb::thermal;
  settings.machine.probe_noise_um = 0.0;  // it would count to what the compensator leaves
  settings.machine.mesh_cache = options.out / "cache";
  settings.keep = options.out / "study/sensors/measured" / name;
  const compensation::Validation validation = compensation::validate_online(machine_case, model, settings);
  nodes = validation.measured_nodes;
  std::vector<double> left;
  for (int draw = 0; draw < options.confirm; ++draw) left.push_back(rms_left(validation, draw));
  return left;
}

/// @param rows   (places x order) temperatures of the chosen places
/// @param nodes  of the model's mesh
Confirmed confirmed(const StudySensorsOptions& options, const solver::Case& machine_case, const solver::Case& placed,
                    const reduction::ReducedModel& model, const MatrixXd& rows, Index nodes) {
  Confirmed on;
  Index measured = 0;
  on.own = left_on_machines(options, machine_case, model, "own", measured);
  on.chosen = left_on_machines(options, placed, study::placed_model(model, placed.machine, rows), "chosen", measured);
  on.own_mesh = measured == nodes;
  return on;
}

std::string toml_of(const std::vector<mesh::SensorSpec>& sensors) {
  std::string text = "# Sensors chosen by `thermotwin study sensors`, in place of those of machine.toml.\n";
  for (const mesh::SensorSpec& sensor : sensors) {
    const auto word = [&](const char* key, const std::string& value) {
      if (!value.empty()) text += fmt::format("{} = \"{}\"\n", key, value);
    };
    const auto number = [&](const char* key, double value, double otherwise = 0.0) {
      if (value != otherwise) text += fmt::format("{} = {:.9g}\n", key, value);
    };
    text += "[[sensor]]\n";
    word("id", sensor.id);
    word("body", sensor.body);
    if (!sensor.body.empty()) {
      const Eigen::Vector3d mm = sensor.point / core::units::mm;
      text += fmt::format("point_mm = [{:.6g}, {:.6g}, {:.6g}]\n", mm.x(), mm.y(), mm.z());
    }
    word("volume", sensor.volume);
    word("return_of", sensor.return_of);
    number("offset_K", sensor.offset);
    number("drift_K_h", sensor.drift * core::units::hour);
    number("time_constant_s", sensor.lag);
    number("air_share", sensor.air_share);
    number("uncertainty_K", sensor.uncertainty, mesh::SensorSpec{}.uncertainty);
  }
  return text;
}

std::string curve_svg(const Choice& choice) {
  Eigen::VectorXd count(std::ssize(choice.curve)), left(count.size()), loss(count.size());
  for (Index i = 0; i < count.size(); ++i) {
    count[i] = choice.curve[i].count;
    left[i] = choice.curve[i].left_um;
    loss[i] = choice.curve[i].after_loss_um;
  }
  core::Axis across{"number of sensors"}, up{"left of the TCP error, um"};
  across.whole = true;
  across.include(count);
  across.close();
  up.include(0.0);
  up.include(left);
  up.include(loss);
  up.include(choice.own_um);
  up.close(0.05);
  core::Plot plot(820, 340, "number of sensors against the TCP error that remains");
  core::Panel panel(plot, {64, 34, 620, 250}, across, up);
  panel.y_axis();
  panel.x_axis();
  panel.line(count, left, core::Ink::blue);
  panel.dots(count, left, core::Ink::blue);
  panel.line(count, loss, core::Ink::orange);
  panel.level(choice.own_um, "sensors of the case");
  plot.key(plot.key(64, 18, "all sensors work", core::Ink::blue), 18, "after the loss of the worst", core::Ink::orange);
  return core::html_wide(900, plot.inset());
}

std::vector<std::vector<std::string>> table_of(const std::vector<mesh::SensorSpec>& sensors, const Choice& choice) {
  std::vector<std::vector<std::string>> rows{{"sensor", "body", "x mm", "y mm", "z mm", "left without it um"}};
  for (std::size_t i = 0; i < choice.chosen.size(); ++i) {
    const Eigen::Vector3d mm = sensors[i].point / core::units::mm;
    rows.push_back({sensors[i].id, sensors[i].body, fmt::format("{:.1f}", mm.x()), fmt::format("{:.1f}", mm.y()),
                    fmt::format("{:.1f}", mm.z()), fmt::format("{:.2f}", choice.without_one_um[i])});
  }
  return rows;
}

/// One sentence each.
std::vector<std::string> confirmation(const Choice& choice) {
  if (!choice.confirmed) return {};
  const Confirmed& on = *choice.confirmed;
  const bool better = on.chosen_um() < on.own_um();
  std::vector<std::string> sentences{fmt::format(
      "On {} machines measured virtually the choice is {} than the sensors of the case by {:.0f} %: {:.2f} um against "
      "{:.2f} um (medians; better on {} of {}).",
      on.own.size(), better ? "better" : "worse", std::abs(on.change_percent()), on.chosen_um(), on.own_um(),
      on.better(), on.own.size())};
  const double chosen = choice.predicted_um(choice.chosen_left), own = choice.predicted_um(choice.own_left);
  sentences.push_back(
      fmt::format("Predicted were {:.2f} um and {:.2f} um ({:+.0f} %){}.", chosen, own,
                  own > 0.0 ? 100.0 * (chosen / own - 1.0) : 0.0,
                  on.own_mesh ? ", without the mesh error: these machines have the model's own mesh" : ""));
  if (choice.borne_out())
    sentences.emplace_back("The machines bear out the prediction.");
  else
    sentences.emplace_back("The machines do not bear out the prediction.");
  if (!better && !on.own_mesh) sentences.emplace_back("Keep the sensors of the case.");
  return sentences;
}

/// Of the criterion's two parts, where a second mesh tells the one of the mesh.
std::string parts(const Choice& choice) {
  if (choice.second_mesh.empty()) return "Without a second mesh the mesh error is not part of this.";
  return fmt::format("Of these, {:.2f} um, {:.2f} um and {:.2f} um come from the mesh error (against {}).",
                     choice.chosen_left.mesh_um, choice.own_left.mesh_um, choice.without_left.mesh_um,
                     choice.second_mesh);
}

/// The same choice again.
std::string command_of(const StudySensorsOptions& options, std::size_t count) {
  const StudySensorsOptions usual;
  return ShellCommand(fmt::format("thermotwin study sensors {} --count {}", core::shell_word(options.case_path), count))
      .texts("--load", options.loads)
      .texts("--body", options.bodies)
      .texts("--without", options.without)
      .number("--spacing", options.spacing_mm, usual.spacing_mm)
      .number("--noise", options.noise_K, usual.noise_K)
      .number("--bias", options.bias_K, usual.bias_K)
      .number("--every", options.every_min, usual.every_min)
      .number("--exchanges", options.exchanges, usual.exchanges)
      .flag("--any-loss", options.any_loss)
      .flag("--on-contacts", options.on_contacts)
      .flag("--on-rotating", options.on_rotating)
      .text("--out", options.out)
      .words();
}

std::string page_of(const StudySensorsOptions& options, const mesh::MachineMesh& mesh, const Choice& choice,
                    const std::vector<mesh::SensorSpec>& sensors) {
  const std::string title = "Sensors of " + mesh.machine.name;
  std::vector<std::string> sentences{core::html_sentence(fmt::format(
      "{} of this choice leave{} {:.2f} um of the TCP error, the {} of the case {:.2f} um, none {:.2f} um (RMS over "
      "poses and times).",
      choice.chosen.size() == 1 ? "The sensor" : fmt::format("The {} sensors", choice.chosen.size()),
      choice.chosen.size() == 1 ? "s" : "", choice.chosen_um, choice.own.size(), choice.own_um, choice.without_um))};
  sentences.push_back(core::html_sentence(parts(choice)));
  if (!choice.directions.empty()) sentences.push_back(core::html_sentence(choice.directions));
  for (const std::string& sentence : confirmation(choice)) sentences.push_back(core::html_sentence(sentence));
  const bool good =
      choice.confirmed ? choice.confirmed->chosen_um() < choice.confirmed->own_um() : choice.chosen_um < choice.own_um;
  mesh::MachineMesh shown = mesh;
  shown.machine.sensors = sensors;
  diagnosis::Scene scene = diagnosis::make_scene(shown, {});
  scene.unmarked = "dots are the chosen sensors";
  return core::html_document(
      title,
      core::html_title(title, "places that leave the observer the least variance of the TCP error") +
          core::html_finding(good ? core::Tone::good : core::Tone::plain, "sensors", sentences) +
          core::html_section("Number of sensors", "chosen one after another; the last point after exchanges",
                             curve_svg(choice)) +
          diagnosis::scene_html(scene) +
          core::html_section("Places", "in the machine's frame at home", core::html_table(table_of(sensors, choice))) +
          core::html_next_steps({{"Confirm the choice on machines measured virtually:",
                                  command_of(options, choice.chosen.size()) + " --confirm 20"}}));
}

/// The places and then the case's own sensors, as a second mesh reads them.
std::vector<mesh::SensorSpec> read_sensors(const mesh::Machine& machine, const std::vector<study::Place>& places) {
  std::vector<mesh::SensorSpec> sensors = study::placed_sensors(machine, places);
  sensors.resize(places.size());  // without those of chillers, which are among the case's own
  for (mesh::SensorSpec& sensor : sensors) sensor.id = "place " + sensor.id;
  for (mesh::SensorSpec own : machine.sensors) {
    own.offset = own.drift = own.lag = own.air_share = 0.0;
    sensors.push_back(std::move(own));
  }
  return sensors;
}

study::PlaceRules rules_of(const StudySensorsOptions& options) {
  study::PlaceRules rules;
  rules.spacing = options.spacing_mm * core::units::mm;
  rules.bodies = options.bodies;
  rules.without = options.without;
  rules.on_contacts = options.on_contacts;
  rules.on_rotating = options.on_rotating;
  return rules;
}

/// In one sentence; empty: all.
std::string directions(const Reach& reach) {
  if (!reach.moves()) return "No linear axis moves the tool: the prediction's error counts in all directions.";
  if (reach.unmoved().empty()) return "";
  return "No linear axis moves " + reach.unmoved() + ": errors there stay and do not count.";
}

/// The filter corrects at stored rows only. @param used  time of the first correction, s
void warn_of_rows(const solver::LoadProgram& load, double every_s, double used) {
  if (std::abs(used - every_s) <= 0.01 * every_s) return;
  if (every_s > load.duration()) {
    core::warn(fmt::format("--every {:.4g}: '{}' lasts {:.4g} min, so the filter corrects once, at its end",
                           every_s / core::units::minute, load.name(), load.duration() / core::units::minute));
  } else {
    core::warn(fmt::format("--every {:.4g}: '{}' has a row every {:.4g} min, so the filter corrects every {:.4g} min",
                           every_s / core::units::minute, load.name(), load.output_interval() / core::units::minute,
                           used / core::units::minute));
  }
}

Choice choose(const StudySensorsOptions& options, const solver::Case& machine_case, const solver::FullModel& full,
              const reduction::ReducedModel& model, const MatrixXd& basis,
              const std::vector<solver::LoadProgram>& loads) {
  Choice choice;
  choice.places = study::sensor_places(full.mesh, rules_of(options));
  const Index places = std::ssize(choice.places), own = std::ssize(model.machine.sensors);
  MatrixXd rows(places + own, model.system.order());
  for (Index i = 0; i < places; ++i) rows.row(i) = basis.row(choice.places[i].node).head(rows.cols());
  rows.bottomRows(own) = model.system.sensors.topRows(own);
  for (Index i = 0; i < own; ++i) choice.own.push_back(static_cast<int>(places + i));

  const std::vector<study::UncertainParameter> parameters = study::uncertain_parameters(model);
  std::vector<study::LoadResponses> along;
  const double every_s = options.every_min * core::units::minute;
  for (const solver::LoadProgram& load : loads) {
    along.push_back(study::responses(model, parameters, load, every_s));
    warn_of_rows(load, every_s, along.back().times.front());
  }
  study::ChoiceOptions how;
  how.noise_K = options.noise_K;
  how.bias_K = options.bias_K;
  how.exchanges = options.exchanges;
  how.any_loss = options.any_loss;
  how.choosable = places;
  const std::vector<mesh::Pose> poses = mesh::workspace_poses(model.machine);
  const Reach reach(model.machine, poses);
  choice.directions = directions(reach);
  MatrixXd tcp = translation_rows(model, poses);
  std::vector<study::ModelErrors> errors =
      study::model_errors(machine_case, full.mesh, model, read_sensors(model.machine, choice.places), rows, tcp, loads,
                          along, options.out / "cache", choice.second_mesh);
  reach.keep(tcp);
  for (study::ModelErrors& error : errors)
    for (Eigen::VectorXd& at : error.tcp_um) reach.keep(at);
  const study::SensorChoice judge(along, parameters, rows, tcp, how, errors);
  const int count = options.count > 0 ? options.count : static_cast<int>(own);
  if (count < 1 || count > places) {
    throw core::InputError("--count", std::to_string(count),
                           fmt::format("1 to {}: the places that the rules leave", places));
  }
  const std::vector<int> greedy = judge.greedy(count);
  for (int k = 1; k <= count; ++k) {
    const std::vector<int> first(greedy.begin(), greedy.begin() + k);
    choice.curve.push_back({k, judge.left_um(first), judge.left_after_loss_um(first)});
  }
  choice.chosen = judge.chosen(greedy);
  choice.without_left = judge.left({});
  choice.own_left = judge.left(choice.own);
  choice.chosen_left = judge.left(choice.chosen);
  choice.without_um = choice.without_left.all_um();
  choice.own_um = choice.own_left.all_um();
  choice.own_after_loss_um = own > 0 ? judge.left_after_loss_um(choice.own) : choice.without_um;
  choice.chosen_um = choice.chosen_left.all_um();
  choice.chosen_after_loss_um = judge.left_after_loss_um(choice.chosen);
  choice.curve.back() = {count, choice.chosen_um, choice.chosen_after_loss_um};
  for (std::size_t lost = 0; lost < choice.chosen.size(); ++lost) {
    std::vector<int> rest = choice.chosen;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(lost));
    choice.without_one_um.push_back(judge.left_um(rest));
  }
  return choice;
}

void require_confirmable(const solver::Case& machine_case) {
  if (machine_case.check_points.empty()) {
    throw core::InputError((machine_case.folder / "case.toml").string(), "no check points, which --confirm compares at",
                           "[check_points] with poses, or no --confirm");
  }
  if (!has_linear_axis(machine_case.machine)) {
    throw core::InputError(machine_case.machine.path.string(), "no linear axis, whose offsets --confirm judges",
                           "a machine with a linear axis, or no --confirm");
  }
}

}  // namespace

void study_sensors(const StudySensorsOptions& given) {
  const Stopwatch time;
  StudySensorsOptions options = given;
  const solver::Case machine_case = open_case(options.case_path, "", 0);
  if (options.loads.empty()) options.loads = machine_case.holdout;
  const std::vector<solver::LoadProgram> loads = load_programs(machine_case, options.loads);
  if (loads.empty()) throw core::UsageError("--load: the case holds no load program out");
  if (options.confirm > 0) require_confirmable(machine_case);
  const fs::path folder = options.out / "study/sensors";
  require_writable(folder);
  const solver::FullModel full = build(machine_case, options.out);
  const ReducedCase made = make_reduced_model(full, machine_case, {}, true, options.out);
  const core::FolderLock lock(folder);
  Choice choice = choose(options, machine_case, full, made.model, made.summary.basis, loads);
  std::vector<study::Place> places;
  MatrixXd rows(std::ssize(choice.chosen), made.model.system.order());
  for (const int index : choice.chosen) {
    rows.row(std::ssize(places)) = made.summary.basis.row(choice.places[index].node).head(rows.cols());
    places.push_back(choice.places[index]);
  }
  const std::vector<mesh::SensorSpec> sensors = study::placed_sensors(machine_case.machine, places);
  if (options.confirm > 0) {
    choice.confirmed = confirmed(options, machine_case, study::placed_case(machine_case, sensors), made.model, rows,
                                 full.mesh.nodes());
  }
  std::string curve = "sensors,left_um,left_after_loss_um\n";
  for (const CurvePoint& point : choice.curve)
    curve += fmt::format("{},{:.9g},{:.9g}\n", point.count, point.left_um, point.after_loss_um);
  core::write_file(folder / "curve.csv", curve);
  core::write_file(folder / "sensors.toml", toml_of(sensors));
  json summary = {{"places", choice.places.size()},
                  {"second_mesh", choice.second_mesh},
                  {"without_um", choice.without_um},
                  {"without_mesh_um", choice.without_left.mesh_um},
                  {"own",
                   {{"sensors", choice.own.size()},
                    {"left_um", choice.own_um},
                    {"mesh_um", choice.own_left.mesh_um},
                    {"after_loss_um", choice.own_after_loss_um}}},
                  {"chosen",
                   {{"sensors", choice.chosen.size()},
                    {"left_um", choice.chosen_um},
                    {"mesh_um", choice.chosen_left.mesh_um},
                    {"after_loss_um", choice.chosen_after_loss_um}}},
                  {"order", made.model.system.order()},
                  {"seconds", time.seconds()},
                  {"peak_GiB", peak_memory_GiB()}};
  if (choice.confirmed) {
    const Confirmed& on = *choice.confirmed;
    summary["confirmed"] = {{"own_um", on.own},
                            {"chosen_um", on.chosen},
                            {"own_median_um", on.own_um()},
                            {"chosen_median_um", on.chosen_um()},
                            {"change_percent", on.change_percent()},
                            {"better_on", on.better()},
                            {"own_mesh", on.own_mesh},
                            {"predicted_own_um", choice.predicted_um(choice.own_left)},
                            {"predicted_chosen_um", choice.predicted_um(choice.chosen_left)},
                            {"borne_out", choice.borne_out()}};
  }
  core::write_file(folder / "sensors.json", summary.dump(1) + "\n");
  write_page(folder / "report.html", [&] { return page_of(options, full.mesh, choice, sensors); });
  std::string text = core::format_table(table_of(sensors, choice));
  text += fmt::format(
      "\n{} places; left of the TCP error: {:.2f} um without sensors, {:.2f} um with the {} of the case, "
      "{:.2f} um with these {}; after the loss of the worst {:.2f} um, {:.2f} um\n",
      choice.places.size(), choice.without_um, choice.own_um, choice.own.size(), choice.chosen_um, choice.chosen.size(),
      choice.own_after_loss_um, choice.chosen_after_loss_um);
  text += parts(choice) + "\n";
  if (!choice.directions.empty()) text += choice.directions + "\n";
  for (const std::string& sentence : confirmation(choice)) text += sentence + "\n";
  text += fmt::format("sensors.toml, curve.csv and report.html in {}; {:.0f} s\n", folder.string(), time.seconds());
  print_summary(options, text, summary.dump());
}

}  // namespace thermotwin::tools
