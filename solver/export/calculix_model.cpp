// SPDX-License-Identifier: GPL-3.0-or-later
// Nodes, elements, materials, surfaces and contact pairs of a CalculiX deck.

#include "solver/export/calculix_model.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/character.h"
#include "core/error.h"
#include "core/text.h"
#include "solver/contact/grid.h"
#include "solver/operation/layout.h"

namespace thermotwin::solver::calculix {

using Eigen::Index;
using mesh::TetMesh;

std::string Names::of(const std::string& kind, const std::string& id) {
  const auto at = known_.find({kind, id});
  if (at != known_.end()) return at->second;
  constexpr std::size_t longest = 60;  // ccx: 80 characters with what it adds itself
  std::string name = kind + "_" + id;
  for (char& c : name) {
    c = core::is_letter_or_digit(c) ? core::upper(c) : '_';
  }
  name.resize(std::min(name.size(), longest));
  const auto used = [&](const std::string& wanted) {
    return std::any_of(known_.begin(), known_.end(), [&](const auto& entry) { return entry.second == wanted; });
  };
  std::string unique = name;
  for (int i = 2; used(unique); ++i) unique = name + "_" + std::to_string(i);
  return known_[{kind, id}] = unique;
}

Model::Model(const mesh::MachineMesh& machine_mesh, const DeckOptions& deck_options)
    : mesh(machine_mesh),
      options(deck_options),
      pose(deck_options.pose.size() > 0 ? deck_options.pose : mesh::home_pose(machine_mesh.machine)),
      taken(machine_mesh.bodies.size(), deck_options.body.empty() ? 1 : 0),
      first_element{0} {
  if (!options.body.empty()) {
    const int only = machine().body_index(options.body);
    if (only < 0) {
      std::vector<std::string> ids;
      for (const mesh::BodySpec& body : machine().bodies) ids.push_back(body.id);
      throw core::InputError("body", "'" + options.body + "' (nearest: " + core::nearest(options.body, ids) + ")",
                             core::join(ids));
    }
    taken[only] = 1;
  }
  for (const TetMesh& body : mesh.bodies) first_element.push_back(first_element.back() + body.elements());
  next_node = mesh.nodes() + 1;
  next_element = first_element.back() + 1;
}

int Model::body_of_surface(int surface) const { return machine().body_index(machine().surfaces[surface].body); }

int element_face(const TetMesh& mesh, int face) {
  // ccx: face 1 holds nodes 1 2 3, 2: 1 4 2, 3: 2 4 3, 4: 3 4 1.
  constexpr int opposite_of_node[4] = {3, 4, 2, 1};
  const int element = mesh.face_tet[face];
  const Eigen::Vector3i nodes = mesh.faces.col(face);
  int at = 0;
  while (at < 3 && (nodes.array() == mesh.tets(at, element)).any()) ++at;
  return opposite_of_node[at];
}

std::string wrapped(const std::vector<std::string>& entries, std::size_t per_line) {
  std::string text;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    text += entries[i];
    if (i + 1 == entries.size())
      text += "\n";
    else
      text += (i + 1) % per_line == 0 ? ",\n" : ", ";
  }
  return text;
}

std::string nodes_text(const Model& model) {
  std::string text = "*NODE, NSET=NODES\n";
  for (int b = 0; b < std::ssize(model.taken); ++b) {
    if (!model.takes(b)) continue;
    const TetMesh& body = model.mesh.bodies[b];
    const Eigen::Isometry3d frame = model.frame(b);
    for (Index i = 0; i < body.nodes(); ++i) {
      const Eigen::Vector3d p = frame * Eigen::Vector3d(body.points.col(i));
      fmt::format_to(std::back_inserter(text), "{}, {:.12e}, {:.12e}, {:.12e}\n", model.node(b, i), p.x(), p.y(),
                     p.z());
    }
  }
  return text;
}

std::string elements_text(Model& model, bool elastic) {
  std::string text;
  for (int b = 0; b < std::ssize(model.taken); ++b) {
    if (!model.takes(b) || model.machine().bodies[b].elastic != elastic) continue;
    const TetMesh& body = model.mesh.bodies[b];
    text += fmt::format("*ELEMENT, TYPE={}, ELSET={}\n", body.order() == 2 ? "C3D10" : "C3D4", model.body_name(b));
    for (Index e = 0; e < body.elements(); ++e) {
      fmt::format_to(std::back_inserter(text), "{}", model.element(b, e));
      for (const int node : mesh::tet_nodes(body, e))
        fmt::format_to(std::back_inserter(text), ", {}", model.node(b, node));
      text += "\n";
    }
  }
  return text;
}

namespace {

/// Lines of a property over temperature, or its one value.
std::string property_text(const mesh::Curve& table, double scale, double value) {
  if (table.at.empty()) return fmt::format("{:.10g}\n", value);
  std::string text;
  for (std::size_t i = 0; i < table.at.size(); ++i)
    text += fmt::format("{:.10g}, {:.10g}\n", scale * table.value[i], table.at[i]);
  return text;
}

}  // namespace

std::string materials_text(Model& model, bool elastic) {
  const mesh::Machine& machine = model.machine();
  std::string text;
  std::set<std::string> written;
  for (int b = 0; b < std::ssize(model.taken); ++b) {
    const mesh::BodySpec& body = machine.bodies[b];
    if (!model.takes(b) || body.elastic != elastic) continue;
    const mesh::Material& material = machine.material(body.material);
    // A tensor turns with the body: then each body has a material of its own.
    const std::string name = material.conductivity_tensor
                                 ? model.names.of("MATERIAL", material.id + "." + body.id)
                                 : model.names.of(elastic ? "MATERIAL" : "HEAT_MATERIAL", material.id);
    if (written.insert(name).second) {
      text += fmt::format("*MATERIAL, NAME={}\n*ELASTIC\n{:.10g}, {:.10g}\n", name, material.young, material.poisson);
      text += fmt::format("*EXPANSION, ZERO={:.10g}\n{:.10g}\n", machine.reference_C, material.expansion.value);
      if (material.conductivity_tensor) {
        const Eigen::Matrix3d turn = model.frame(b).linear();
        const Eigen::Matrix3d k = turn * *material.conductivity_tensor * turn.transpose();
        text += fmt::format("*CONDUCTIVITY, TYPE=ANISO\n{:.10g}, {:.10g}, {:.10g}, {:.10g}, {:.10g}, {:.10g}\n",
                            k(0, 0), k(1, 1), k(2, 2), k(0, 1), k(0, 2), k(1, 2));
      } else {
        text += "*CONDUCTIVITY\n" + property_text(material.conductivity_table, 1.0, material.conductivity);
      }
      const mesh::Curve& heat = material.specific_heat_table;
      const double scale = heat.at.empty() ? 1.0 : material.specific_heat.value / heat(machine.reference_C);
      text += fmt::format("*DENSITY\n{:.10g}\n*SPECIFIC HEAT\n", material.density) +
              property_text(heat, scale, material.specific_heat.value);
    }
    text += fmt::format("*SOLID SECTION, ELSET={}, MATERIAL={}\n", model.body_name(b), name);
  }
  return text;
}

std::string surface_text(const Model& model, const std::string& name, int body, const std::vector<int>& faces) {
  const TetMesh& mesh = model.mesh.bodies[body];
  std::string text = "*SURFACE, NAME=" + name + ", TYPE=ELEMENT\n";
  for (const int face : faces) {
    fmt::format_to(std::back_inserter(text), "{}, S{}\n", model.element(body, mesh.face_tet[face]),
                   element_face(mesh, face));
  }
  return text;
}

std::vector<std::vector<ContactPoint>> contacts(const Model& model) {
  const mesh::Machine& machine = model.machine();
  std::vector<std::vector<ContactPoint>> all;
  for (const mesh::JointSpec& joint : machine.joints) {
    all.emplace_back();
    const int slave = model.body_of_surface(machine.surface_index(joint.slave));
    const int master = joint.master.empty() ? -1 : model.body_of_surface(machine.surface_index(joint.master));
    if (!model.takes(slave) || (master >= 0 && !model.takes(master))) continue;
    all.back() = find_contact(model.mesh, joint, model.frame(slave),
                              master < 0 ? Eigen::Isometry3d::Identity() : model.frame(master));
  }
  return all;
}

namespace {

/// One side of a joint: a surface with the connected set of each of its triangles.
struct Side {
  int body;
  std::map<int, int> set_of_face;

  Side(const Model& model, const std::string& surface)
      : body(model.body_of_surface(model.machine().surface_index(surface))) {
    const std::vector<int>& faces = model.mesh.surfaces[model.machine().surface_index(surface)];
    const std::vector<int> sets = connected_sets(model.mesh.bodies[body], faces);
    for (std::size_t f = 0; f < faces.size(); ++f) set_of_face[faces[f]] = sets[f];
  }
  std::set<int> faces_of(int set) const {
    std::set<int> faces;
    for (const auto& [face, of] : set_of_face)
      if (of == set) faces.insert(face);
    return faces;
  }
  /// The triangles and those that share a node with one of them.
  std::set<int> with_neighbours(const Model& model, const std::set<int>& faces) const {
    const mesh::TetMesh& mesh = model.mesh.bodies[body];
    std::set<int> nodes, wider;
    for (const int face : faces)
      for (int i = 0; i < 3; ++i) nodes.insert(mesh.faces(i, face));
    for (const auto& [face, set] : set_of_face) {
      for (int i = 0; i < 3; ++i)
        if (nodes.contains(mesh.faces(i, face))) wider.insert(face);
    }
    return wider;
  }
};

/// Contact pairs of ccx. A triangle may be a master once only: where two pairs share one, ccx loses
/// its way from one triangle to the next, and with it a part of the contact. Then the sides change
/// their parts, which changes nothing else in tied contact.
class PairWriter {
public:
  PairWriter(Model& model) : model_(model) {}

  void add(const mesh::JointSpec& joint, double conductance, const std::vector<ContactPoint>& contact) {
    const Side slave(model_, joint.slave), master(model_, joint.master);
    const std::string interaction = model_.names.of("JOINT", joint.id);
    // TIED needs both slopes; a heat step does not use them.
    text_ += fmt::format(
        "** joint {}\n*SURFACE INTERACTION, NAME={}\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n1e12\n"
        "*FRICTION\n0.3, 1e12\n*GAP CONDUCTANCE\n{:.10g}\n",
        joint.id, interaction, conductance);
    // ccx walks over the master from its nearest triangle to the one opposite: it has to get there.
    if (!add_pairs(joint, interaction, slave, master, contact, false) &&
        !add_pairs(joint, interaction, master, slave, contact, true)) {
      throw core::InputError(model_.machine().path.string() + " joint " + joint.id,
                             "both of its surfaces share triangles with other joints",
                             "for a CalculiX deck: surfaces of its own on one side");
    }
  }
  std::string take() { return std::move(text_); }

private:
  bool add_pairs(const mesh::JointSpec& joint, const std::string& interaction, const Side& slave, const Side& master,
                 const std::vector<ContactPoint>& contact, bool swapped) {
    std::map<int, std::set<int>> touching;  // slave's triangles by set of the master
    for (const ContactPoint& point : contact) {
      touching[master.set_of_face.at(swapped ? point.slave_face : point.master_face)].insert(
          swapped ? point.master_face : point.slave_face);
    }
    for (const auto& [set, faces] : touching) {
      for (const int face : master.faces_of(set))
        if (masters_.contains({master.body, face})) return false;
    }
    for (const auto& [set, faces] : touching) {
      const std::set<int> of_set = master.faces_of(set),
                          of_slave = swapped ? slave.with_neighbours(model_, faces) : faces;
      for (const int face : of_set) masters_.insert({master.body, face});
      const std::string part = joint.id + "." + std::to_string(set);
      const std::string slave_name = model_.names.of("SLAVE", part), master_name = model_.names.of("MASTER", part);
      text_ += surface_text(model_, slave_name, slave.body, {of_slave.begin(), of_slave.end()});
      text_ += surface_text(model_, master_name, master.body, {of_set.begin(), of_set.end()});
      text_ += fmt::format("*CONTACT PAIR, INTERACTION={}, TYPE=SURFACE TO SURFACE\n{}, {}\n", interaction, slave_name,
                           master_name);
    }
    return true;
  }

  Model& model_;
  std::set<std::pair<int, int>> masters_;  ///< body, triangle
  std::string text_;
};

}  // namespace

std::string contact_text(Model& model, const Program& program, const std::vector<std::vector<ContactPoint>>& contact) {
  const mesh::Machine& machine = model.machine();
  PairWriter pairs(model);
  bool any = false;
  for (std::size_t j = 0; j < machine.joints.size(); ++j) {
    const mesh::JointSpec& joint = machine.joints[j];
    if (joint.master.empty()) continue;
    const bool slave = model.takes(model.body_of_surface(machine.surface_index(joint.slave)));
    const bool master = model.takes(model.body_of_surface(machine.surface_index(joint.master)));
    if (slave != master) model.notes.push_back("joint " + joint.id + " leads to another body: left out");
    if (!slave || !master) continue;
    if (contact[j].empty()) {
      model.notes.push_back("joint " + joint.id + " has no contact at this pose");
      continue;
    }
    const std::vector<double> conductance = program.coefficient(TermKind::contact, j);
    if (!(conductance.front() > 0.0)) continue;
    any = true;
    pairs.add(joint, conductance.front(), contact[j]);
    if (std::any_of(conductance.begin(), conductance.end(), [&](double h) { return h != conductance.front(); }))
      model.notes.push_back("joint " + joint.id + " keeps its initial conductance, which changes in the load");
  }
  if (any) {
    model.notes.push_back("joints conduct as at this pose; CalculiX integrates the contact areas by its own rule");
  }
  return pairs.take();
}

}  // namespace thermotwin::solver::calculix
