// SPDX-License-Identifier: GPL-3.0-or-later
// `mesh MACHINE`: what the meshed machine consists of, body by body and joint by joint.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/file.h"
#include "core/progress.h"
#include "core/text.h"
#include "mesh/body_check.h"
#include "mesh/import/import.h"
#include "mesh/import/vtk_mesh_io.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "mesh/surface_area.h"
#include "solver/contact/contact.h"
#include "solver/elastic/drives.h"
#include "tools/chain.h"

namespace thermotwin::tools {

namespace {

using Table = std::vector<std::vector<std::string>>;

/// Grams below 1 kg.
std::string mass_text(double kg) {
  return kg < 1.0    ? fmt::format("{:.3g} g", 1e3 * kg)
         : kg < 10.0 ? fmt::format("{:.2f} kg", kg)
                     : fmt::format("{:.0f} kg", kg);
}

/// @return mass of all bodies, kg
double add_bodies(const mesh::MachineMesh& meshed, Table& table, nlohmann::json& json) {
  table = {{"body", "material", "solids", "pieces", "nodes", "elements", "quality min", "mean", "edge mm", "mass"}};
  double mass = 0;
  for (std::size_t b = 0; b < meshed.bodies.size(); ++b) {
    const mesh::TetMesh& body = meshed.bodies[b];
    const mesh::BodySpec& spec = meshed.machine.bodies[b];
    const mesh::Quality quality = mesh::quality(body);
    const int pieces = mesh::connected_pieces(body).count;
    const double kg = body.total_volume() * meshed.machine.material(spec.material).density;
    mass += kg;
    table.push_back({spec.id, spec.material, body.solids > 0 ? std::to_string(body.solids) : "-",
                     std::to_string(pieces), std::to_string(body.nodes()), std::to_string(body.elements()),
                     fmt::format("{:.3f}{}", quality.minimum, quality.minimum < mesh::poor_quality ? " poor" : ""),
                     fmt::format("{:.2f}", quality.mean),
                     fmt::format("{:.0f}-{:.0f}", 1e3 * quality.shortest_edge, 1e3 * quality.longest_edge),
                     mass_text(kg)});
    json["bodies"].push_back({{"id", spec.id},
                              {"solids", body.solids},
                              {"pieces", pieces},
                              {"nodes", body.nodes()},
                              {"elements", body.elements()},
                              {"quality_min", quality.minimum},
                              {"quality_mean", quality.mean},
                              {"mass_kg", kg}});
  }
  return mass;
}

/// Beside the area of the triangles that of the same faces cut at the boxes of rules.
void add_surfaces(const mesh::MachineMesh& meshed, Table& table, nlohmann::json& json) {
  table = {{"surface", "triangles", "area cm2", "cut at its box cm2"}};
  const std::vector<double> cut = mesh::cut_areas(meshed);
  for (std::size_t s = 0; s < meshed.surfaces.size(); ++s) {
    const double area = meshed.surface_area(s);
    const bool has_box = !std::isnan(cut[s]);
    table.push_back({meshed.machine.surfaces[s].id, std::to_string(meshed.surfaces[s].size()),
                     fmt::format("{:.1f}", 1e4 * area), has_box ? fmt::format("{:.1f}", 1e4 * cut[s]) : "-"});
    nlohmann::json row = {{"id", meshed.machine.surfaces[s].id}, {"area_m2", area}};
    if (has_box) row["cut_area_m2"] = cut[s];
    json["surfaces"].push_back(row);
  }
}

/// Contact of a joint with all axes at home.
struct Contact {
  double area = 0;                              ///< m^2
  double gap = 0, least_gap = 0, most_gap = 0;  ///< m along the slave's normal, mean over the area; negative: overlap
  std::vector<solver::ContactPoint> points;     ///< none on the ground
};

int body_of_surface(const mesh::Machine& machine, const std::string& surface) {
  return machine.body_index(machine.surfaces[machine.surface_index(surface)].body);
}

Contact contact_of(const mesh::MachineMesh& meshed, const mesh::JointSpec& joint) {
  const mesh::Machine& machine = meshed.machine;
  Contact contact;
  if (joint.master.empty()) {
    contact.area = meshed.surface_area(machine.surface_index(joint.slave));
    return contact;
  }
  const int slave = body_of_surface(machine, joint.slave), master = body_of_surface(machine, joint.master);
  const mesh::Pose home = mesh::home_pose(machine);
  const Eigen::Isometry3d slave_from_home = mesh::body_transform(machine, slave, home),
                          master_from_home = mesh::body_transform(machine, master, home);
  const mesh::TetMesh& base = meshed.bodies[master];
  contact.least_gap = std::numeric_limits<double>::infinity();
  contact.most_gap = -contact.least_gap;
  contact.points = solver::find_contact(meshed, joint, slave_from_home, master_from_home);
  for (const solver::ContactPoint& point : contact.points) {
    Eigen::Vector3d opposite = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) opposite += point.master_weights[i] * base.points.col(base.faces(i, point.master_face));
    const Eigen::Vector3d across = slave_from_home.inverse() * (master_from_home * opposite) - point.position;
    const double gap = across.dot(point.normal);
    contact.area += point.area;
    contact.gap += point.area * gap;
    contact.least_gap = std::min(contact.least_gap, gap);
    contact.most_gap = std::max(contact.most_gap, gap);
  }
  if (contact.area > 0.0) contact.gap /= contact.area;
  return contact;
}

std::vector<Contact> contacts_of(const mesh::MachineMesh& meshed) {
  std::vector<Contact> contacts;
  for (const mesh::JointSpec& joint : meshed.machine.joints) contacts.push_back(contact_of(meshed, joint));
  return contacts;
}

/// The boundary triangles of all bodies, and a number for each.
using OfFaces = std::vector<std::vector<double>>;

OfFaces zero_of_faces(const mesh::MachineMesh& meshed) {
  OfFaces of_faces;
  for (const mesh::TetMesh& body : meshed.bodies) of_faces.emplace_back(body.face_count(), 0.0);
  return of_faces;
}

/// The area in m^2 of each triangle that a joint covers, on both of its sides.
void add_covered(const mesh::MachineMesh& meshed, const mesh::JointSpec& joint, const Contact& contact,
                 OfFaces& covered) {
  const mesh::Machine& machine = meshed.machine;
  const int slave = body_of_surface(machine, joint.slave);
  if (joint.master.empty()) {
    for (const int face : meshed.surfaces[machine.surface_index(joint.slave)])
      covered[slave][face] += meshed.bodies[slave].face_area(face);
    return;
  }
  const int master = body_of_surface(machine, joint.master);
  for (const solver::ContactPoint& point : contact.points) {
    covered[slave][point.slave_face] += point.area;
    covered[master][point.master_face] += point.area;
  }
}

/// A joint between the same surfaces as one before it covers nothing more.
bool covers_again(const mesh::Machine& machine, std::size_t joint) {
  const mesh::JointSpec& own = machine.joints[joint];
  return std::any_of(machine.joints.begin(), machine.joints.begin() + joint, [&](const mesh::JointSpec& other) {
    return other.slave == own.slave && other.master == own.master;
  });
}

/// What joints that never move cover, and what guides, nuts and bearings of axes cover at home.
struct Covered {
  OfFaces fixed, moving;
};

Covered covered_by(const mesh::MachineMesh& meshed, const std::vector<Contact>& contacts) {
  Covered covered{zero_of_faces(meshed), zero_of_faces(meshed)};
  for (std::size_t j = 0; j < contacts.size(); ++j) {
    const mesh::JointSpec& joint = meshed.machine.joints[j];
    if (!covers_again(meshed.machine, j))
      add_covered(meshed, joint, contacts[j], joint.axis.empty() ? covered.fixed : covered.moving);
  }
  return covered;
}

/// A film cools what a joint covers as well, though no air is there.
constexpr double much_covered = 0.5;  ///< less may be an edge of a plane that goes on beside the joint

void warn_of_covered(const mesh::FilmSpec& film, double area, double fixed, const std::string& machine) {
  if (fixed < much_covered * area) return;
  core::warn(
      fmt::format("{} film '{}': {:.0f} % of its {:.1f} cm2 lie under joints that do not move. The film cools this "
                  "area although no air reaches it; exclude the surfaces of these joints from the film",
                  machine, film.id, 100.0 * fixed / area, 1e4 * area));
}

void add_films(const mesh::MachineMesh& meshed, const std::vector<Contact>& contacts, Table& table,
               nlohmann::json& json) {
  const mesh::Machine& machine = meshed.machine;
  const Covered covered = covered_by(meshed, contacts);
  table = {{"film (axes at home)", "area cm2", "under fixed joints %", "under moving joints %"}};
  for (const mesh::FilmSpec& film : machine.films) {
    double area = 0.0, fixed = 0.0, moving = 0.0;
    for (const std::string& surface : film.surfaces) {
      const int body = body_of_surface(machine, surface);
      for (const int face : meshed.surfaces[machine.surface_index(surface)]) {
        const double own = meshed.bodies[body].face_area(face), under = std::min(own, covered.fixed[body][face]);
        area += own;
        fixed += under;
        moving += std::min(own - under, covered.moving[body][face]);
      }
    }
    const auto percent = [&](double part) { return area > 0.0 ? 100.0 * part / area : 0.0; };
    table.push_back({film.id, fmt::format("{:.1f}", 1e4 * area), fmt::format("{:.1f}", percent(fixed)),
                     fmt::format("{:.1f}", percent(moving))});
    json["films"].push_back({{"id", film.id},
                             {"area_m2", area},
                             {"under_fixed_joints_percent", percent(fixed)},
                             {"under_moving_joints_percent", percent(moving)}});
    warn_of_covered(film, area, fixed, machine.path.string());
  }
}

void add_joints(const mesh::MachineMesh& meshed, const std::vector<Contact>& contacts, Table& table,
                nlohmann::json& json) {
  table = {{"joint (axes at home)", "contact cm2", "of the slave %", "gap mm", "smallest", "largest"}};
  for (std::size_t j = 0; j < contacts.size(); ++j) {
    const mesh::JointSpec& joint = meshed.machine.joints[j];
    const Contact& contact = contacts[j];
    const double share = 100.0 * contact.area / meshed.surface_area(meshed.machine.surface_index(joint.slave));
    const bool on_ground = joint.master.empty(), touches = contact.area > 0.0;
    const auto gap_text = [&](double gap) {
      return on_ground || !touches ? std::string("-") : fmt::format("{:.3f}", 1e3 * gap);
    };
    table.push_back({joint.id, fmt::format("{:.1f}", 1e4 * contact.area), fmt::format("{:.0f}", share),
                     gap_text(contact.gap), gap_text(contact.least_gap), gap_text(contact.most_gap)});
    nlohmann::json row = {{"id", joint.id}, {"contact_area_m2", contact.area}, {"share_of_slave_percent", share}};
    if (!on_ground && touches)
      row.update({{"gap_mean_m", contact.gap}, {"gap_least_m", contact.least_gap}, {"gap_most_m", contact.most_gap}});
    json["joints"].push_back(row);
    if (!touches) {
      core::warn(
          fmt::format("joint '{}': '{}' and '{}' do not touch with all axes at home, because no triangles face each "
                      "other within reach_mm = {:g}. A larger reach_mm bridges a gap in the CAD",
                      joint.id, joint.slave, joint.master, 1e3 * joint.reach));
    }
  }
}

/// Displacements will be refused; temperatures alone need nothing that holds an axis.
void warn_of_unheld_axes(const mesh::Machine& machine) {
  for (const auto& [axis, body] : solver::unheld_axes(machine)) {
    core::warn(fmt::format("{} axis '{}': nothing holds body '{}' along it; displacements need {}",
                           machine.path.string(), axis, body, solver::what_holds_an_axis));
  }
}

}  // namespace

void mesh_machine(const MeshOptions& options) {
  const std::filesystem::path file =
      std::filesystem::is_directory(options.machine) ? options.machine / "machine.toml" : options.machine;
  mesh::Machine machine = mesh::read_machine(file);
  if (options.mesh_order > 0) machine.order = options.mesh_order;
  require_writable(options.out);
  warn_of_unheld_axes(machine);
  const mesh::MachineMesh meshed =
      mesh::build_machine_mesh(machine, {mesh::size_factor(machine, options.size), options.out / "cache"});
  core::write_files_by(options.out / "mesh", [&](const std::filesystem::path& staged) {
    std::vector<std::filesystem::path> files;
    for (std::size_t b = 0; b < machine.bodies.size(); ++b) {
      files.emplace_back(machine.bodies[b].id + ".vtu");
      mesh::write_vtu(staged / files.back(), meshed.bodies[b]);
    }
    return files;
  });
  nlohmann::json json = {{"machine", machine.name}, {"nodes", meshed.nodes()}, {"order", machine.order}};
  Table bodies, surfaces, joints, films;
  const std::vector<Contact> contacts = contacts_of(meshed);
  const double mass = add_bodies(meshed, bodies, json);
  add_surfaces(meshed, surfaces, json);
  add_joints(meshed, contacts, joints, json);
  add_films(meshed, contacts, films, json);
  json["mass_kg"] = mass;
  std::string text = core::format_table(bodies) + "\n" + core::format_table(surfaces) + "\n";
  for (const Table& table : {joints, films})
    if (table.size() > 1) text += core::format_table(table) + "\n";
  print_summary(options,
                text + fmt::format("{}: {} bodies, {} nodes of {} tetrahedra, {}; meshes in {}\n", machine.name,
                                   machine.bodies.size(), meshed.nodes(), machine.order == 2 ? "quadratic" : "linear",
                                   mass_text(mass), (options.out / "mesh").string()),
                json.dump());
}

}  // namespace thermotwin::tools
