// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pieces of a CalculiX deck that the files calculix_*.cpp share.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "mesh/body/shape.h"
#include "solver/contact/contact.h"
#include "solver/export/calculix_deck.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::solver::calculix {

/// Names as ccx takes them: letters, digits and underscores, upper case, each once.
class Names {
public:
  /// The name of this thing of this kind ("FILM", "air.skin"), the same at every call.
  std::string of(const std::string& kind, const std::string& id);

private:
  std::map<std::pair<std::string, std::string>, std::string> known_;
};

/// Content and numbering of the deck. Numbers of ccx start at 1. Nodes of the machine keep their order, and the deck's
/// further nodes follow them.
struct Model {
  const mesh::MachineMesh& mesh;
  const DeckOptions& options;
  mesh::Pose pose;
  std::vector<char> taken;                  ///< bodies in the deck
  std::vector<Eigen::Index> first_element;  ///< (bodies + 1), from 0
  Names names;
  std::vector<std::string> notes;
  Eigen::Index next_node = 0, next_element = 0;  ///< free numbers of ccx

  Model(const mesh::MachineMesh& machine_mesh, const DeckOptions& deck_options);

  const mesh::Machine& machine() const { return mesh.machine; }
  int body_of_surface(int surface) const;
  bool takes(int body) const { return body >= 0 && taken[body] != 0; }
  Eigen::Index node(int body, Eigen::Index local) const { return mesh.first_node[body] + local + 1; }
  Eigen::Index element(int body, Eigen::Index local) const { return first_element[body] + local + 1; }
  Eigen::Isometry3d frame(int body) const { return mesh::body_transform(mesh.machine, body, pose); }
  std::string body_name(int body) { return names.of("BODY", machine().bodies[body].id); }
};

/// Number 1 to 4 of the element's face that is this boundary triangle.
int element_face(const mesh::TetMesh& mesh, int face);

/// @return the entries separated by commas, at most per_line of them in a line
std::string wrapped(const std::vector<std::string>& entries, std::size_t per_line);

/// Nodes of all bodies in the deck, and elements of the elastic bodies or of the others.
std::string nodes_text(const Model& model);
std::string elements_text(Model& model, bool elastic);
/// Materials and sections of the elastic bodies, or of the others.
std::string materials_text(Model& model, bool elastic);
/// *SURFACE of boundary triangles of one body.
std::string surface_text(const Model& model, const std::string& name, int body, const std::vector<int>& faces);

/// @return contact points of each joint at the pose; empty for joints with a body outside the deck
std::vector<std::vector<ContactPoint>> contacts(const Model& model);
/// End times of the increments, the channels of each increment, and the coefficients that follow from them. Joints are
/// those at the pose, and laws are evaluated at nominal temperatures. Steady state: one row, no times.
struct Program {
  std::vector<double> ends;
  std::vector<Eigen::VectorXd> rows;
  OperatingModel operating;
  std::vector<Coefficients> coefficients;

  Program(const Model& model);
  bool steady() const { return ends.empty(); }
  /// Coefficient of a film or joint in each increment; term: its index in the layout.
  std::vector<double> coefficient(TermKind kind, int item, int* term = nullptr) const;
};

/// Contact pairs with gap conductance.
std::string contact_text(Model& model, const Program& program, const std::vector<std::vector<ContactPoint>>& contact);

}  // namespace thermotwin::solver::calculix
