// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <system_error>

#include "compensation/evaluation/validation_plots.h"
#include "core/error.h"
#include "core/file.h"
#include "core/html_page.h"
#include "core/progress.h"
#include "core/quoted.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::tools {

void write_page(const std::filesystem::path& file, const std::function<std::string()>& make) {
  try {
    core::write_file(file, make());
  } catch (const core::Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);  // of an earlier run: it would contradict the tables
    core::warn(fmt::format("{} is left out: {}", file.string(), error.what()));
  }
}

std::string mesh_words(const std::string& size, int mesh_order, const std::string& solver) {
  std::string words;
  if (!size.empty()) words += " --size " + core::shell_word(size);
  if (mesh_order > 0) words += fmt::format(" --mesh-order {}", mesh_order);
  if (solver != "auto") words += " --solver " + solver;
  return words;
}

std::vector<core::NextStep> steps_after(const diagnosis::Diagnosis& diagnosed, const std::filesystem::path& folder,
                                        const std::vector<std::filesystem::path>& data,
                                        const std::filesystem::path& model, const std::filesystem::path& out) {
  const std::string machine = folder.empty() ? "" : " " + core::shell_word(folder),
                    of_model = model.empty() ? "" : " --model " + core::shell_word(model);
  const auto command = [&](const char* verb, const std::string& measured, const std::string& more) {
    return fmt::format("thermotwin {}{} --data {}{}{} --out {}", verb, machine, measured, of_model, more,
                       core::shell_word(out));
  };
  std::vector<std::string> words;
  for (const std::filesystem::path& record : data) words.push_back(core::shell_word(record));
  const std::string all = core::join(words, " --data "), first = words.front();
  std::vector<core::NextStep> steps;
  const bool extended = !diagnosed.extended_machine_text.empty();
  if (extended && !folder.empty()) {
    steps.push_back({"Accept the corrected machine as a case of its own, and see what compensation gains from it:",
                     command("diagnose", all, " --accept " + core::shell_word(out / "accepted"))});
  }
  if (extended) {
    steps.push_back(
        {"Judge the corrected model beside the nominal one and the fitted ones:",
         command("evaluate", first, " --extended " + core::shell_word(out / "diagnosis/extended/model.rom.h5"))});
  } else {
    steps.push_back({"Judge compensation on this measurement:", command("evaluate", first, "")});
  }
  steps.push_back({extended ? "After the repair, measure again and confirm that nothing is left:"
                            : "Diagnose a further measurement:",
                   command("diagnose", "NEW_DATA", "")});
  return steps;
}

std::string mesh_section(const solver::FullModel& full) {
  const mesh::Machine& machine = full.mesh.machine;
  std::vector<std::vector<std::string>> rows{{"body", "material", "moved by", "nodes", "tetrahedra", "deforms"}};
  for (std::size_t b = 0; b < machine.bodies.size(); ++b) {
    const mesh::BodySpec& body = machine.bodies[b];
    rows.push_back({body.id, body.material, body.axis.empty() ? "-" : body.axis,
                    std::to_string(full.mesh.bodies[b].nodes()), std::to_string(full.mesh.bodies[b].elements()),
                    body.elastic ? "yes" : "no, carried"});
  }
  return core::html_section("Mesh", fmt::format("{} joints between the bodies", machine.joints.size()),
                            core::html_table(rows));
}

std::string loads_section(const std::vector<solver::LoadProgram>& loads, const solver::MachineScene& scene) {
  std::vector<std::vector<std::string>> rows{
      {"load", "what happens", "duration h", "largest TCP error um", "at pose", "after h"}};
  for (std::size_t l = 0; l < loads.size(); ++l) {
    const solver::SceneLoad& shown = scene.loads[l];
    double largest = 0.0;
    Eigen::Index pose = 0, time = 0;
    for (Eigen::Index t = 0; t < shown.errors_um.cols(); ++t) {
      for (Eigen::Index p = 0; p < std::ssize(scene.poses); ++p) {
        const double length = shown.errors_um.block<3, 1>(3 * p, t).norm();
        if (length > largest) largest = length, pose = p, time = t;
      }
    }
    rows.push_back({loads[l].name(), loads[l].title(), fmt::format("{:.2f}", shown.hours.tail(1).sum()),
                    fmt::format("{:.2f}", largest), mesh::format_pose(scene.machine, scene.poses[pose]),
                    fmt::format("{:.2f}", shown.hours[time])});
  }
  return core::html_section("Load programs", "length of the translations, over the poses of the workspace",
                            core::html_table(rows));
}

std::string traces_section(const std::vector<compensation::ValidationTrace>& traces) {
  if (traces.empty()) return "";
  std::vector<std::pair<std::string, std::string>> items;
  Eigen::Index inside = 0, values = 0;
  double noise_um = 0.0;
  for (const compensation::ValidationTrace& trace : traces) {
    const auto [stated, within] = trace.coverage();
    values += stated, inside += within;
    noise_um = std::max(noise_um, trace.noise_um.maxCoeff());
    items.emplace_back(fmt::format("{}, machine {}, {}", trace.load, trace.draw + 1, trace.pose),
                       compensation::trace_svg(trace));
  }
  const std::string covered =
      values == 0 ? ""
                  : fmt::format(
                        "<p class=\"below\">{:.0f}&#8239;% of the residuals in the directions that axes move "
                        "lie within the band, to which the noise of the measured values contributes its "
                        "standard deviation of {:.2g}&#8239;µm. About 95&#8239;% do where the stated "
                        "uncertainty is right.</p>\n",
                        100.0 * inside / values, noise_um);
  return core::html_section("Error over time, without and with compensation",
                            "on a machine measured virtually, at check points off the pose grid of the model",
                            compensation::trace_legend() + core::html_choice("trace", "check point", items) + covered);
}

}  // namespace thermotwin::tools
