// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/page.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <deque>
#include <iostream>
#include <malloc.h>
#include <string>
#include <utility>
#include <vector>

#include "compensation/control/online_file.h"
#include "compensation/online/output_map.h"
#include "core/error.h"
#include "core/html_page.h"
#include "core/module.h"
#include "core/progress.h"
#include "core/text.h"
#include "solver/export/scene_file.h"
#include "tools/reduced_scene.h"
#include "tools/serve/day_file.h"
#include "tools/serve/page_feed.h"
#include "tools/serve/page_script.h"

namespace thermotwin::tools {
namespace {

constexpr double point_s = 60.0, field_s = 300.0, day_s = 86400.0;

/// The machine at the reference temperature; the script brings the fields.
std::string scene_markup(const reduction::ReducedModel& model, const std::filesystem::path& model_file) {
  solver::MachineScene scene;
  if (auto stored = solver::read_scene(model_file.parent_path() / "scene.bin", model.machine, scene_stamp(model))) {
    scene = std::move(*stored);
  } else {
    scene.machine = model.machine;
    scene.poses = mesh::workspace_poses(scene.machine);
    scene.keys = solver::key_poses(scene.machine, scene.poses);
  }
  const auto values = 3 * std::ssize(scene.poses);
  scene.loads.push_back({"last 24 h", Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Zero(scene.turn.cols(), 1),
                         Eigen::MatrixXd::Zero(values, 1)});
  return solver::machine_scene_html(scene);
}

std::string tile(const std::string& label, const std::string& id, const std::string& below) {
  return core::html_tile(label, "<span id=\"" + id + "\">&ndash;</span>", below);
}

std::string page_of(const std::filesystem::path& model_file) {
  const compensation::OnlineData data = compensation::online_data({model_file, 0, {}});
  const reduction::ReducedModel& model = data.model;
  const compensation::OutputMap map(model);
  std::vector<std::string> tiles;
  for (const std::string& axis : map.axes())
    tiles.push_back(tile("offset " + axis, "served-" + core::lower(axis), "with one standard deviation"));
  tiles.push_back(tile("status", "served-status", "of the last row"));
  tiles.push_back(tile("guard", "served-guard", "limits size and rate"));
  tiles.push_back(tile("model", "served-model", core::xml_text(model.machine.name)));
  tiles.push_back(tile("time", "served-time", "<span id=\"served-link\">connecting</span>"));
  std::string legend = "<div class=\"legend\">";
  constexpr const char* colours[] = {"blue", "orange", "green"};
  for (std::size_t i = 0; i < map.axes().size(); ++i)
    legend += fmt::format("<span><i class=\"{}\"></i>{}</span>", colours[i % 3], core::xml_text(map.axes()[i]));
  legend += "</div>";
  const std::string sensors =
      "<p id=\"served-failed\"></p><table id=\"served-sensors\"><tr><th>sensor</th><th>reading, &deg;C</th>"
      "<th>prediction, &deg;C</th><th>difference, K</th><th>state</th></tr></table>";
  return core::html_document(
      "thermotwin serve: " + model.machine.name,
      "<style>.warned { color: #c0392b; font-weight: 600 }</style>" +
          core::html_title(model.machine.name, "thermal offsets beside the control") + core::html_tiles(tiles) +
          core::html_section("Offsets of the last 24 h", "bands: one standard deviation, drawn up to 50 &micro;m",
                             legend + "<canvas id=\"served-chart\" width=\"1100\" height=\"260\"></canvas>") +
          core::html_section("Sensors", "predictions are those before the last correction", sensors) +
          scene_markup(model, model_file) + "<script>" + served_page_script + "</script>");
}

/// One entry each `every` seconds of the last 24 h.
class Day {
public:
  explicit Day(double every) : every_(every) {}
  /// @return whether it is one of the entries
  bool add(double time, const nlohmann::json& entry) {
    if (!entries_.empty() && time - entries_.back().first < every_) return false;
    entries_.emplace_back(time, entry.dump());
    while (entries_.front().first < time - day_s) entries_.pop_front();
    return true;
  }
  std::string list() const {
    std::string text;
    for (const auto& [time, entry] : entries_) text += (text.empty() ? "" : ",") + entry;
    return "[" + text + "]";
  }

private:
  double every_;
  std::deque<std::pair<double, std::string>> entries_;
};

class Moments {
public:
  Moments(PageFeed& feed, const std::filesystem::path& day_file) : feed_(feed), on_disk_(day_file) {}

  void show(const std::string& line) {
    const nlohmann::json moment = nlohmann::json::parse(line, nullptr, false);
    if (!moment.is_object() || !moment.contains("run_s")) return;
    const double time = moment["run_s"];
    const std::lock_guard lock(feed_.mutex);
    if (std::exchange(is_first_, false)) {
      for (const std::string& earlier : on_disk_.before(time)) {
        const nlohmann::json before = nlohmann::json::parse(earlier, nullptr, false);
        keep(before, before["run_s"]);
      }
    }
    if (keep(moment, time)) on_disk_.append(time, line);
    feed_.now = line;
    if (moment.contains("sensors")) sensors_ = moment["sensors"].dump();
    feed_.history = [this] {
      return "{\"points\":" + points_.list() + ",\"fields\":" + fields_.list() + ",\"sensors\":" + sensors_ + "}";
    };
    ++feed_.version;
    feed_.changed.notify_all();
  }

private:
  /// @return whether a point of the last day was added
  bool keep(const nlohmann::json& moment, double time) {
    nlohmann::json point = {{"t", time}};
    for (const std::string axis : moment["axes"]) {
      point["o"].push_back(moment["offset_um"][axis]);
      point["s"].push_back(moment["std_um"][axis]);
    }
    const bool is_point = points_.add(time, point);
    if (!moment.contains("errors_um")) return is_point;
    nlohmann::json field = {{"t", time}, {"errors_um", moment["errors_um"]}};
    if (moment.contains("modes")) field["modes"] = moment["modes"];
    return fields_.add(time, field) || is_point;
  }

  PageFeed& feed_;
  DayFile on_disk_;
  bool is_first_ = true;
  std::string sensors_ = "[]";  ///< JSON of the newest moment that has them
  Day points_{point_s}, fields_{field_s};
};

}  // namespace

void show_page(const std::filesystem::path& model_file, const std::filesystem::path& day_file, int port) {
  // The server's threads live as long as the process, and so does what they read.
  static PageFeed& feed = *new PageFeed;
  feed.page = page_of(model_file);
  ::malloc_trim(0);  // the model is not needed any more
  const auto start = reinterpret_cast<StartPageServer>(core::module_function(
      "libthermotwin_page_server.so", start_page_server_name, "serve --port", "serve without --port"));
  if (start(port, &feed) < 0)
    throw core::InputError(fmt::format("--port {}", port), "cannot be had on 127.0.0.1",
                           "a port that no other program has");
  core::log_line(fmt::format("page: http://127.0.0.1:{}/", port));
  Moments moments(feed, day_file);
  for (std::string line; std::getline(std::cin, line);) {
    core::check_interrupt();
    moments.show(line);
  }
  const std::lock_guard lock(feed.mutex);
  feed.ended = true;
  feed.changed.notify_all();
}

}  // namespace thermotwin::tools
