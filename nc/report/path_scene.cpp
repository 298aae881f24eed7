// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/path_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>

#include "core/base64.h"
#include "core/html_page.h"
#include "core/units.h"
#include "core/view_script.h"
#include "nc/report/path_scene_script.h"

namespace thermotwin::nc {

namespace units = core::units;

namespace {

using Vectors = std::function<const Eigen::Vector3d&(const PathPoint&)>;

void put_float(std::vector<std::uint8_t>& bytes, double value) {
  core::put_bytes<std::uint32_t>(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

/// Vectors as 16-bit integers with one scale.
std::string short_numbers(const std::vector<PathPoint>& points, const Vectors& of) {
  double largest = 0.0;
  for (const PathPoint& point : points) largest = std::max(largest, of(point).cwiseAbs().maxCoeff());
  const double scale = largest > 0.0 ? largest / 32767.0 : 1.0;
  std::vector<std::uint8_t> bytes;
  bytes.reserve(6 * points.size());
  for (const PathPoint& point : points)
    for (const double value : of(point))
      core::put_bytes<std::uint16_t>(bytes, static_cast<std::uint16_t>(std::lround(value / scale)));
  return fmt::format("{{\"scale\":{:.6g},\"data\":\"{}\"}}", scale, core::base64(bytes));
}

std::string path_json(const std::vector<PathPoint>& points) {
  std::vector<std::uint8_t> place, time, line, rapid;
  for (const PathPoint& point : points) {
    for (const double value : point.place) put_float(place, value / units::mm);
    put_float(time, point.time);
    core::put_bytes<std::uint32_t>(line, point.line);
    rapid.push_back(point.rapid ? 1 : 0);
  }
  return fmt::format("{{\"place\":\"{}\",\"time\":\"{}\",\"line\":\"{}\",\"rapid\":\"{}\",\"error\":{},\"std\":{}}}",
                     core::base64(place), core::base64(time), core::base64(line), core::base64(rapid),
                     short_numbers(points, [](const PathPoint& p) -> const Eigen::Vector3d& { return p.error_um; }),
                     short_numbers(points, [](const PathPoint& p) -> const Eigen::Vector3d& { return p.std_um; }));
}

}  // namespace

std::string path_scene_html(const PathPoints& path, const std::string& below) {
  if (path.points().size() < 2) return "";
  const std::string controls =
      "<div class=\"controls\"><label>colour <select id=\"path-choice\"></select></label><label>time <input "
      "type=\"range\" id=\"path-time\" min=\"0\" max=\"1000\" step=\"any\" value=\"0\"></label>"
      "<label><input type=\"checkbox\" id=\"path-rapid\" checked>rapid moves</label></div>\n";
  const std::string legend =
      "<div class=\"legend\"><span id=\"path-range\"></span><span><i class=\"blue\"></i>X</span><span><i "
      "class=\"orange\"></i>Y</span><span><i class=\"green\"></i>Z</span><span id=\"path-values\"></span><span>drag "
      "turns, wheel zooms</span></div>\n";
  const std::string note = fmt::format(
      "<p class=\"below\">{} of {} points; the others lie within {:.3g} mm of this path, and their errors within "
      "{:.3g} µm of its.</p>\n",
      path.points().size(), path.given(), path.place_tolerance() / units::mm, path.error_tolerance_um());
  return core::html_section(
             "Error along the path", below,
             controls + legend + "<canvas id=\"path\" width=\"1100\" height=\"620\"></canvas>\n" + note) +
         "<script type=\"application/json\" id=\"path-data\">" + path_json(path.points()) + "</script>\n<script>" +
         core::view_script + path_scene_script + "</script>\n";
}

}  // namespace thermotwin::nc
