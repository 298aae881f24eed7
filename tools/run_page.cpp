// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/run_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/file.h"
#include "core/html_page.h"
#include "core/quoted.h"
#include "core/text.h"
#include "solver/export/scene_file.h"
#include "tools/error_tables.h"
#include "tools/page.h"
#include "tools/reduced_scene.h"

namespace thermotwin::tools {
namespace {

double largest_error(const ReducedCase& made) {
  double largest = 0.0;
  for (const reduction::ReductionErrors& e : made.model.errors) largest = std::max(largest, e.max_um);
  return largest;
}

std::string headline(const RunResults& r) {
  using compensation::ValidationRow;
  const std::string& load = r.validation.rows.front().load;
  const double removed = r.validation.median_reduction(load, true);
  const core::Tone tone = removed > 50.0 ? core::Tone::good : core::Tone::warn;
  std::vector<std::string> sentences{
      fmt::format("Compensation removes {:.1f}&#8239;% of the TCP error of the unseen program {}: {:.1f} µm RMS become "
                  "{:.1f} µm.",
                  removed, core::xml_text(load), r.validation.rms(load, &ValidationRow::rms_before_um),
                  r.validation.rms(load, &ValidationRow::rms_sensors_um))};
  if (const std::string stays = r.validation.unmoved_sentence(load, "µm"); !stays.empty()) sentences.push_back(stays);
  const std::string page = core::html_finding(tone, "compensation", sentences);
  std::vector<std::string> tiles{
      core::html_tile("nodes of the full model", std::to_string(r.full.mesh.nodes()),
                      fmt::format("{} bodies, {} joints", r.machine_case.machine.bodies.size(),
                                  r.machine_case.machine.joints.size())),
      core::html_tile("campaign", fmt::format("{} × {}", r.made.loads, r.made.poses), "load programs × poses"),
      core::html_tile("order of the reduced model", std::to_string(r.made.summary.order),
                      fmt::format("for {} temperatures", r.full.thermal.size)),
      core::html_tile("reduced against full", fmt::format("{:.3f} µm", largest_error(r.made)),
                      "largest TCP difference, held-out loads"),
      core::html_tile("removed, sensors", fmt::format("{:.1f}&#8239;%", removed), "of the RMS, unseen program"),
      core::html_tile("removed, no sensors", fmt::format("{:.1f}&#8239;%", r.validation.median_reduction(load, false)),
                      "by the model and inputs alone")};
  return page + core::html_tiles(tiles);
}

std::string compensation_section(const RunResults& r) {
  std::vector<std::vector<std::string>> rows{{"check point", "RMS before um", "model alone um", "surroundings known um",
                                              "with sensors um", "largest before um", "largest after um"}};
  const bool stays = !r.validation.unmoved_directions.empty();
  if (stays) rows.front().push_back("no axis moves um");
  for (const compensation::ValidationRow& row : r.validation.rows) {
    rows.push_back({row.pose, fmt::format("{:.2f}", row.rms_before_um), fmt::format("{:.2f}", row.rms_model_um),
                    fmt::format("{:.2f}", row.rms_told_um), fmt::format("{:.2f}", row.rms_sensors_um),
                    fmt::format("{:.2f}", row.largest_before_um), fmt::format("{:.2f}", row.largest_sensors_um)});
    if (stays) rows.back().push_back(fmt::format("{:.2f}", row.rms_unmoved_um));
  }
  return core::html_section("Compensation in numbers",
                            fmt::format("{} on a machine measured virtually: {} nodes, perturbed parameters, noise",
                                        core::xml_text(r.validation.rows.front().load), r.validation.measured_nodes),
                            core::html_table(rows) +
                                "<p class=\"below\">RMS and largest value of the length of the translations. Model "
                                "alone: inputs of the control, no temperature sensor. Surroundings known: the same, "
                                "with every ambient at the hall temperature. With sensors: temperature sensors correct "
                                "the state of the model.</p>\n");
}

std::string reduced_section(const RunResults& r) {
  std::string tables = core::html_table(heldout_rows(r.made));
  if (!r.made.off_grid.empty()) tables += "<br>" + core::html_table(off_grid_rows(r.made));
  if (!r.made.sensors.empty()) tables += "<br>" + core::html_table(sensor_rows(r.made));
  std::string picture;
  const auto file = r.options.out / "order.svg";
  if (std::filesystem::exists(file)) picture = core::html_wide(760, core::read_file(file));
  return core::html_section("Order and error of the reduced model", "against the full model; held-out loads as dots",
                            picture) +
         core::html_section("The reduced model on held-out loads", "none of these loads formed the basis", tables);
}

std::string diagnosis_section(const RunResults& r) {
  return core::html_section(
      "Diagnosis of the measurement", "",
      "<p>" + core::html_sentence(r.diagnosed.sentence) + "</p>" +
          (r.hidden.empty() ? "" : "<p>For comparison, " + core::html_sentence(r.hidden) + ".</p>") +
          "<p><a href=\"diagnosis/report.html\">diagnosis/report.html</a> shows residuals, "
          "causes and the extension of the model.</p>");
}

std::string next_steps(const RunResults& r) {
  const std::string folder = core::shell_word(r.options.case_path), out = core::shell_word(r.options.out),
                    load = r.machine_case.holdout.front();
  return core::html_next_steps(
      {{"How much is removed on many machines, not one:",
        fmt::format("thermotwin validate {} --model {}/model.rom.h5 --draws 20 --out {}", folder, out, out)},
       {"Offsets for rows as a control has them; these are of a load program of the campaign:",
        fmt::format("thermotwin compensate {0}/model.rom.h5 --in {0}/campaign/{1}/inputs.csv --out offsets.csv", out,
                    load)},
       {"Another load program, in seconds; write it to the case's loads folder first:",
        fmt::format("thermotwin campaign {} --reduced --load {} --out {}", folder, load, out)}});
}

}  // namespace

std::string run_page(const RunResults& r) {
  std::vector<std::string> names = r.machine_case.train;
  names.insert(names.end(), r.machine_case.holdout.begin(), r.machine_case.holdout.end());
  const std::vector<solver::LoadProgram> loads = load_programs(r.machine_case, names);
  solver::MachineScene scene = reduced_scene(r.full, r.made.model, r.made.summary.basis, loads);
  scene.first_load = r.made.largest_load;  // that of machine.png
  solver::write_scene(r.options.out / "scene.bin", scene, scene_stamp(r.made.model));
  const bool judged = !r.validation.rows.empty();
  const std::string& name = r.machine_case.machine.name;
  return core::html_document(
      "Thermal twin of " + name,
      core::html_title("Thermal twin of " + name,
                       fmt::format("mesh size {}; fields and errors by the reduced model of order {}",
                                   r.machine_case.size, r.made.summary.order)) +
          (judged ? headline(r) : "") + solver::machine_scene_html(scene) + traces_section(r.validation.traces) +
          (judged ? compensation_section(r) : "") + diagnosis_section(r) + reduced_section(r) +
          loads_section(loads, scene) + mesh_section(r.full) + next_steps(r));
}

}  // namespace thermotwin::tools
