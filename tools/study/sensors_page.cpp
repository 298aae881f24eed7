// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/study/sensors_page.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "core/html_page.h"
#include "core/plot.h"
#include "core/quoted.h"
#include "core/units.h"
#include "diagnosis/report/scene.h"
#include "tools/page.h"
#include "tools/shell_command.h"

namespace thermotwin::tools {

namespace {

using Eigen::Index;

std::string curve_svg(const ChosenSensors& choice) {
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

/// The same choice again.
std::string command_of(const StudySensorsOptions& options, std::size_t count) {
  const StudySensorsOptions usual;
  return ShellCommand(fmt::format("thermotwin study sensors {}{} --count {}", core::shell_word(options.case_path),
                                  mesh_words(options.size, options.mesh_order), count))
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

}  // namespace

std::vector<std::vector<std::string>> sensor_table(const std::vector<mesh::SensorSpec>& sensors,
                                                   const ChosenSensors& choice) {
  std::vector<std::vector<std::string>> rows{{"sensor", "body", "x mm", "y mm", "z mm", "left without it um"}};
  for (std::size_t i = 0; i < choice.chosen.size(); ++i) {
    const Eigen::Vector3d mm = sensors[i].point / core::units::mm;
    rows.push_back({sensors[i].id, sensors[i].body, fmt::format("{:.1f}", mm.x()), fmt::format("{:.1f}", mm.y()),
                    fmt::format("{:.1f}", mm.z()), fmt::format("{:.2f}", choice.without_one_um[i])});
  }
  return rows;
}

std::vector<std::string> confirmation_sentences(const ChosenSensors& choice) {
  if (!choice.confirmed) return {};
  const ConfirmedSensors& on = *choice.confirmed;
  const bool better = on.chosen_um() < on.own_um();
  std::vector<std::string> sentences{fmt::format(
      "On {} measured virtually the choice is {} than the sensors of the case by {:.0f} %: it leaves {:.2f} um, the "
      "sensors of the case {:.2f} um (medians; the choice is better on {} of {}).",
      on.own.size() == 1 ? "one machine" : fmt::format("{} machines", on.own.size()), better ? "better" : "worse",
      std::abs(on.change_percent()), on.chosen_um(), on.own_um(), on.better(), on.own.size())};
  const double chosen = choice.predicted_um(choice.chosen_left), own = choice.predicted_um(choice.own_left);
  sentences.push_back(
      fmt::format("Predicted were {:.2f} um with the choice and {:.2f} um with the case's ({:+.0f} %){}.", chosen, own,
                  own > 0.0 ? 100.0 * (chosen / own - 1.0) : 0.0,
                  on.own_mesh ? ", without the mesh error: these machines have the model's own mesh" : ""));
  if (choice.borne_out())
    sentences.emplace_back("The machines bear out the prediction.");
  else
    sentences.emplace_back("The machines do not bear out that the choice is " +
                           std::string(choice.chosen_um < choice.own_um ? "better." : "worse."));
  if (!better) {
    sentences.emplace_back(
        on.own_mesh && choice.chosen_um < choice.own_um
            ? "Keep the sensors of the case, or choose on a finer mesh: most of what the choice gains "
              "is mesh error."
            : "Keep the sensors of the case.");
  }
  return sentences;
}

std::vector<std::vector<std::string>> confirmation_table(const ConfirmedSensors& confirmed) {
  std::vector<std::vector<std::string>> table{
      {"left on the machines, median, um", "no sensors", "of the case", "chosen"}};
  for (const ConfirmedLoad& load : confirmed.loads) {
    table.push_back({load.load, fmt::format("{:.2f}", load.without_um), fmt::format("{:.2f}", load.own_um),
                     fmt::format("{:.2f}", load.chosen_um)});
  }
  return table;
}

std::string mesh_error_sentence(const ChosenSensors& choice) {
  if (choice.second_mesh.empty()) return "Without a second mesh the mesh error is not part of this.";
  const auto told = [&](double left_um) {
    if (left_um == choice.without_left.mesh_um) return "tell nothing of it";
    return left_um < choice.without_left.mesh_um ? "tell a part of it" : "are misled by it";
  };
  return fmt::format(
      "The mesh error (against {}) has a part of {:.2f} um in it without sensors, of {:.2f} um with those of the case, "
      "which {}, and of {:.2f} um with those chosen, which {}.",
      choice.second_mesh, choice.without_left.mesh_um, choice.own_left.mesh_um, told(choice.own_left.mesh_um),
      choice.chosen_left.mesh_um, told(choice.chosen_left.mesh_um));
}

std::string sensors_page(const StudySensorsOptions& options, const mesh::MachineMesh& mesh, const ChosenSensors& choice,
                         const std::vector<mesh::SensorSpec>& sensors) {
  const std::string title = "Sensors of " + mesh.machine.name;
  std::vector<std::string> sentences{core::html_sentence(fmt::format(
      "{} of this choice leave{} {:.2f} um of the TCP error, the {} of the case {:.2f} um, none {:.2f} um (RMS over "
      "poses and times).",
      choice.chosen.size() == 1 ? "The sensor" : fmt::format("The {} sensors", choice.chosen.size()),
      choice.chosen.size() == 1 ? "s" : "", choice.chosen_um, choice.own.size(), choice.own_um, choice.without_um))};
  sentences.push_back(core::html_sentence(mesh_error_sentence(choice)));
  if (!choice.directions.empty()) sentences.push_back(core::html_sentence(choice.directions));
  for (const std::string& sentence : confirmation_sentences(choice)) sentences.push_back(core::html_sentence(sentence));
  const bool good =
      choice.confirmed ? choice.confirmed->chosen_um() < choice.confirmed->own_um() : choice.chosen_um < choice.own_um;
  mesh::MachineMesh shown = mesh;
  shown.machine.sensors = sensors;
  diagnosis::Scene scene = diagnosis::make_scene(shown, {});
  scene.unmarked = "dots are the chosen sensors";
  return core::html_document(
      title, core::html_title(title, "places that leave the observer the least variance of the TCP error") +
                 core::html_finding(good ? core::Tone::good : core::Tone::plain, "sensors", sentences) +
                 core::html_section("Number of sensors", "chosen one after another; the last point after exchanges",
                                    curve_svg(choice)) +
                 diagnosis::scene_html(scene) +
                 (choice.confirmed ? core::html_section("Machines measured virtually", "by load program",
                                                        core::html_table(confirmation_table(*choice.confirmed)))
                                   : "") +
                 core::html_section("Places", "in the machine's frame at home",
                                    core::html_table(sensor_table(sensors, choice))) +
                 core::html_next_steps({{"Confirm the choice on machines measured virtually:",
                                         command_of(options, choice.chosen.size()) + " --confirm 20"}}));
}

}  // namespace thermotwin::tools
