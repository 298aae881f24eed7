// SPDX-License-Identifier: GPL-3.0-or-later
// The verb that chooses places for temperature sensors, and confirms the choice on machines measured virtually.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <iterator>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/folder_guard.h"
#include "core/folder_lock.h"
#include "core/text.h"
#include "core/units.h"
#include "study/placement/placed_model.h"
#include "study/units/unit_files.h"
#include "tools/chain.h"
#include "tools/page.h"
#include "tools/study/chosen_sensors.h"
#include "tools/study/sensor_confirmation.h"
#include "tools/study/sensors_page.h"
#include "tools/study/study.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;
using Eigen::MatrixXd;
using nlohmann::json;

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

json summary_of(const ChosenSensors& choice, Index order, double seconds) {
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
                  {"order", order},
                  {"seconds", seconds},
                  {"peak_GiB", peak_memory_GiB()}};
  if (choice.confirmed) {
    const ConfirmedSensors& on = *choice.confirmed;
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
    for (const ConfirmedLoad& load : on.loads) {
      summary["confirmed"]["loads"].push_back({{"load", load.load},
                                               {"without_um", load.without_um},
                                               {"own_um", load.own_um},
                                               {"chosen_um", load.chosen_um}});
    }
  }
  return summary;
}

}  // namespace

void study_sensors(const StudySensorsOptions& given) {
  const Stopwatch time;
  StudySensorsOptions options = given;
  const solver::Case machine_case = open_case(options.case_path, options.size, options.mesh_order);
  if (options.loads.empty()) options.loads = machine_case.holdout;
  const std::vector<solver::LoadProgram> loads = load_programs(machine_case, options.loads);
  if (loads.empty()) throw core::UsageError("--load: the case holds no load program out");
  if (options.confirm > 0) require_confirmable(machine_case);
  const fs::path folder = options.out / "study/sensors";
  require_writable(folder);
  const core::FolderLock lock(folder);
  core::write_file(folder / study::origin_note, fs::canonical(options.case_path).string() + "\n");
  const core::FolderGuard guard(options.out, folder / study::origin_note);
  const solver::FullModel full = build(machine_case, options.out);
  sensor_places(options, full.mesh);  // what is wrong with the rules is said before the reduced model is made
  const ReducedCase made = make_reduced_model(full, machine_case, {}, true, options.out);
  ChosenSensors choice = chosen_sensors(options, machine_case, full, made.model, made.summary.basis, loads);
  std::vector<study::Place> places;
  MatrixXd rows(std::ssize(choice.chosen), made.model.system.order());
  for (const int index : choice.chosen) {
    rows.row(std::ssize(places)) = made.summary.basis.row(choice.places[index].node).head(rows.cols());
    places.push_back(choice.places[index]);
  }
  const std::vector<mesh::SensorSpec> sensors = study::placed_sensors(machine_case.machine, places);
  // The choice stays if the confirmation, which takes far longer, does not come to its end.
  std::string curve = "sensors,left_um,left_after_loss_um\n";
  for (const CurvePoint& point : choice.curve)
    curve += fmt::format("{},{:.9g},{:.9g}\n", point.count, point.left_um, point.after_loss_um);
  core::write_file(folder / "curve.csv", curve);
  core::write_file(folder / "sensors.toml", toml_of(sensors));
  const auto write = [&] {
    const json summary = summary_of(choice, made.model.system.order(), time.seconds());
    core::write_file(folder / "sensors.json", summary.dump(1) + "\n");
    write_page(folder / "report.html", [&] { return sensors_page(options, full.mesh, choice, sensors); });
    return summary;
  };
  json summary = write();
  if (options.confirm > 0) {
    choice.confirmed = confirmed_sensors(options, machine_case, study::placed_case(machine_case, sensors), made.model,
                                         rows, full.mesh.nodes());
    summary = write();
  }
  std::string text = core::format_table(sensor_table(sensors, choice));
  text += fmt::format(
      "\n{} places; left of the TCP error: {:.2f} um without sensors, {:.2f} um with the {} of the case, "
      "{:.2f} um with {}; after the loss of the worst {:.2f} um, {:.2f} um\n",
      choice.places.size(), choice.without_um, choice.own_um, choice.own.size(), choice.chosen_um,
      choice.chosen.size() == 1 ? "this one" : fmt::format("these {}", choice.chosen.size()), choice.own_after_loss_um,
      choice.chosen_after_loss_um);
  text += mesh_error_sentence(choice) + "\n";
  if (!choice.directions.empty()) text += choice.directions + "\n";
  for (const std::string& sentence : confirmation_sentences(choice)) text += sentence + "\n";
  if (choice.confirmed) text += core::format_table(confirmation_table(*choice.confirmed));
  text += fmt::format("sensors.toml, curve.csv and report.html in {}; {:.0f} s\n", folder.string(), time.seconds());
  print_summary(options, text, summary.dump());
}

}  // namespace thermotwin::tools
