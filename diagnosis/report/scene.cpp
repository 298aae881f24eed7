// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <set>

#include "core/base64.h"
#include "core/page_text.h"
#include "core/text.h"
#include "core/view_script.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/machine_value.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/report/scene_script.h"

namespace thermotwin::diagnosis {

using Eigen::Index;

namespace {

constexpr Index most_triangles = 100'000;
// One for each cause, in its order; more causes than colours begin anew.
constexpr const char* colours[] = {"#e8622c", "#2f7fd0", "#2e9e5b", "#9a52c7",
                                   "#c9a227", "#d6448f", "#17a2a2", "#8a5a33"};

/// What of the machine a cause is about.
struct Where {
  std::set<std::string> surfaces, bodies, points;
};

/// The number of a cause in the picture; 0 is none.
unsigned char mark_of(std::size_t cause) { return cause % std::size(colours) + 1; }

/// The slave's side, which lies on the other one: joints may share a master that is larger than what they touch.
void add_joint(const mesh::JointSpec& joint, Where& where) { where.surfaces.insert(joint.slave); }

void add_places(const mesh::Machine& machine, const mesh::SourceSpec& source, Where& where) {
  for (const mesh::SourcePlace& place : source.places) {
    if (!place.surface.empty()) where.surfaces.insert(place.surface);
    if (const int joint = machine.joint_index(place.joint); joint >= 0) add_joint(machine.joints[joint], where);
  }
}

void add_ambient(const mesh::Machine& machine, const std::string& id, Where& where) {
  for (const mesh::FilmSpec& film : machine.films)
    if (film.ambient == id) where.surfaces.insert(film.surfaces.begin(), film.surfaces.end());
  for (const mesh::JointSpec& joint : machine.joints)
    if (joint.master.empty() && joint.ambient == id) where.surfaces.insert(joint.slave);
}

void add_coolants(const mesh::Machine& machine, const Parameter& cause, Where& where) {
  for (const mesh::CoolantSpec& coolant : machine.coolants) {
    if (cause.kind == Kind::control_sensor_offset && coolant.id == cause.where && !coolant.guide_sensor.empty())
      where.points.insert(coolant.guide_sensor);
    for (const mesh::CoolantSegment& segment : coolant.segments) {
      if (cause.where == coolant.id || cause.where == coolant.id + "." + segment.id)
        where.surfaces.insert(segment.surface);
    }
  }
}

Where where_of(const mesh::Machine& machine, const Parameter& cause) {
  Where where;
  const auto named = [&](const auto& items, const auto& add) {
    for (const auto& item : items)
      if (item.id == cause.where) add(item);
  };
  switch (row_of(cause.kind).target) {
    case Target::source: named(machine.sources, [&](const auto& source) { add_places(machine, source, where); }); break;
    case Target::film:
      named(machine.films,
            [&](const auto& film) { where.surfaces.insert(film.surfaces.begin(), film.surfaces.end()); });
      break;
    case Target::joint: named(machine.joints, [&](const auto& joint) { add_joint(joint, where); }); break;
    case Target::ambient: add_ambient(machine, cause.where, where); break;
    case Target::coolant:
    case Target::segment: add_coolants(machine, cause, where); break;
    case Target::body:
      where.bodies.insert(cause.where);
      if (machine.body_index(cause.where) < 0)
        for (const mesh::BodySpec* body : bodies_of_material(machine, cause.where)) where.bodies.insert(body->id);
      break;
    case Target::scale:
      for (const mesh::ScaleSpec& scale : machine.scales)
        if (scale.axis == cause.where) where.bodies.insert(scale.carrier);
      break;
    case Target::screw:
      for (const mesh::ScrewSpec& screw : machine.screws)
        if (screw.axis == cause.where) where.bodies.insert(screw.body);
      break;
    case Target::sensor:
    case Target::reading: where.points.insert(cause.item.empty() ? "tool" : cause.item); break;
    case Target::volume:  // no surface of its own: films name it as their ambient
    case Target::exchange:
    case Target::nothing: break;
  }
  return where;
}

/// Triangles of a body that a cause is about get its number, those that have one already keep it.
void mark(const mesh::MachineMesh& mesh, int b, const Where& where, unsigned char number, Scene::Body& body) {
  const auto give = [&](unsigned char& triangle) { triangle = triangle == 0 ? number : triangle; };
  if (where.bodies.contains(body.id))
    for (unsigned char& triangle : body.marked) give(triangle);
  for (std::size_t s = 0; s < mesh.machine.surfaces.size(); ++s) {
    const mesh::SurfaceSpec& surface = mesh.machine.surfaces[s];
    if (mesh.machine.body_index(surface.body) != b || !where.surfaces.contains(surface.id)) continue;
    for (const int face : mesh.surfaces[s]) give(body.marked[face]);
  }
}

Scene::Body body_of(const mesh::MachineMesh& mesh, int b, const std::vector<Where>& places) {
  const mesh::TetMesh& tets = mesh.bodies[b];
  Scene::Body body;
  body.id = mesh.machine.bodies[b].id;
  body.marked.assign(tets.face_count(), 0);
  for (std::size_t k = 0; k < places.size(); ++k) mark(mesh, b, places[k], mark_of(k), body);
  // Only nodes of the boundary.
  std::vector<int> number(tets.nodes(), -1);
  std::vector<int> kept;
  body.triangles = tets.faces;
  for (int& node : body.triangles.reshaped()) {
    int& n = number[node];
    if (n < 0) n = std::ssize(kept), kept.push_back(node);
    node = n;
  }
  body.points = tets.points(Eigen::all, kept).cast<float>();
  return body;
}

/// The number of the first cause that a point belongs to, 0 of none.
unsigned char mark_of_point(const std::string& id, const std::vector<Where>& places) {
  for (std::size_t k = 0; k < places.size(); ++k)
    if (places[k].points.contains(id)) return mark_of(k);
  return 0;
}

}  // namespace

Index Scene::triangles() const {
  Index total = 0;
  for (const Body& body : bodies) total += body.triangles.cols();
  return total;
}

Scene make_scene(const mesh::MachineMesh& mesh, const std::vector<Parameter>& causes) {
  const mesh::Machine& machine = mesh.machine;
  Scene scene;
  std::vector<Where> places;
  for (const Parameter& cause : causes) {
    const unsigned char number = mark_of(places.size());
    places.push_back(where_of(machine, cause));
    scene.legend.push_back({name_of(cause), colours[number - 1]});
    if (cause.missing) scene.points.push_back({"unknown source", cause.missing->centre.cast<float>(), number});
  }
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) scene.bodies.push_back(body_of(mesh, b, places));
  for (const mesh::SensorSpec& sensor : machine.sensors) {
    if (!sensor.body.empty())
      scene.points.push_back({sensor.id, sensor.point.cast<float>(), mark_of_point(sensor.id, places)});
  }
  scene.points.push_back({"tool", machine.tcp.tool_point.cast<float>(), mark_of_point("tool", places)});
  return scene;
}

std::string scene_html(const Scene& scene) {
  if (scene.empty()) return "";
  Eigen::Vector3f low = scene.bodies.front().points.col(0), high = low;
  for (const Scene::Body& body : scene.bodies) {
    low = low.cwiseMin(body.points.rowwise().minCoeff());
    high = high.cwiseMax(body.points.rowwise().maxCoeff());
  }
  // 16 bits a coordinate within the box; every so many triangles of large meshes stay.
  const float size = std::max((high - low).maxCoeff(), 1e-6F);
  const Index stride = (scene.triangles() + most_triangles - 1) / most_triangles;
  std::vector<std::uint8_t> points, triangles, marks;
  std::uint32_t first = 0;
  for (const Scene::Body& body : scene.bodies) {
    for (Index n = 0; n < body.points.cols(); ++n) {
      for (int c = 0; c < 3; ++c)
        core::put_bytes<std::uint16_t>(points, std::lround(65535.0F * (body.points(c, n) - low[c]) / size));
    }
    for (Index t = 0; t < body.triangles.cols(); ++t) {
      if (body.marked[t] == 0 && t % stride != 0) continue;
      for (int c = 0; c < 3; ++c) core::put_bytes<std::uint32_t>(triangles, first + body.triangles(c, t));
      marks.push_back(body.marked[t]);
    }
    first += body.points.cols();
  }
  std::string dots;
  for (const Scene::Point& p : scene.points) {
    const Eigen::Vector3f at = (p.at - low) / size;
    dots += fmt::format("{}[{:.5f},{:.5f},{:.5f},{},{}]", dots.empty() ? "" : ",", at.x(), at.y(), at.z(),
                        core::json_text(p.label), p.marked);
  }
  const Eigen::Vector3f extent = (high - low) / size;
  std::string legend;
  for (const Scene::Entry& entry : scene.legend) {
    legend += fmt::format("<span><i class=\"m\" style=\"background:{}\"></i>{}</span>", entry.colour,
                          core::xml_text(entry.words));
  }
  if (legend.empty()) legend = "<span>" + core::xml_text(scene.unmarked) + "</span>";
  return "<h2>Where</h2>\n<section class=\"card\"><div class=\"legend\">" + legend +
         "<span>drag turns, wheel zooms</span></div><canvas id=\"machine\" width=\"1100\" "
         "height=\"560\"></canvas></section>\n"
         "<script type=\"application/json\" id=\"scene\">{" +
         fmt::format(
             "\"extent\":[{:.5f},{:.5f},{:.5f}],\"points\":\"{}\",\"triangles\":\"{}\",\"marks\":\"{}\",\"dots\":[{}],"
             "\"colours\":[\"{}\"]",
             extent.x(), extent.y(), extent.z(), core::base64(points), core::base64(triangles), core::base64(marks),
             dots, fmt::join(colours, "\",\"")) +
         "}</script>\n<script>" + core::view_script + scene_script + "</script>\n";
}

}  // namespace thermotwin::diagnosis
