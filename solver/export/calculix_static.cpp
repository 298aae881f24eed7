// SPDX-License-Identifier: GPL-3.0-or-later
// What holds the elastic bodies of a CalculiX deck: springs between mean displacements, scales with
// thermometers for their tapes, or supports.

#include "solver/export/calculix_static.h"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/minimum_norm.h"
#include "solver/elastic/assembly.h"
#include "solver/elastic/springs.h"
#include "solver/elastic/system.h"
#include "solver/export/calculix_model.h"
#include "solver/operation/layout.h"

namespace thermotwin::solver::calculix {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

struct Entry {
  Index node;
  int direction;  ///< 1 to 3
  double factor;
};

std::string equation(const std::vector<Entry>& entries) {
  std::vector<std::string> terms;
  for (const Entry& entry : entries)
    terms.push_back(fmt::format("{}, {}, {:.12e}", entry.node, entry.direction, entry.factor));
  std::string text = fmt::format("*EQUATION\n{}\n", entries.size());
  for (std::size_t i = 0; i < terms.size(); i += 4) {
    for (std::size_t k = i; k < std::min(i + 4, terms.size()); ++k) text += (k > i ? ", " : "") + terms[k];
    text += "\n";
  }
  return text;
}

constexpr std::size_t most_nodes = 400, kept_nodes = 150;

/// The mean motion of a large surface by some of its nodes: an equation of ccx ties all its nodes to
/// each other, which would fill the matrix. The same value for every motion that is linear in space
/// (rigid, even warming, shear); weights are those of least squares.
Functional thinned(const mesh::TetMesh& body, const Functional& functional) {
  std::map<Index, Vector3d> weights;
  for (const auto& [dof, weight] : functional)
    weights.try_emplace(dof / 3, Vector3d::Zero()).first->second[dof % 3] += weight;
  if (weights.size() <= most_nodes) return functional;
  Vector3d centre = Vector3d::Zero();
  for (const auto& [node, weight] : weights) centre += body.points.col(node) / std::ssize(weights);
  double size = 0.0;
  for (const auto& [node, weight] : weights) size = std::max(size, (body.points.col(node) - centre).norm());
  const auto linear = [&](Index node) {
    Eigen::Vector4d values;
    values << 1.0, (body.points.col(node) - centre) / size;
    return values;
  };
  std::vector<Index> kept;
  std::size_t at = 0;
  Eigen::Matrix4d gram = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 3, 4> moments = Eigen::Matrix<double, 3, 4>::Zero();
  for (const auto& [node, weight] : weights) {
    moments += weight * linear(node).transpose();
    if (at++ * kept_nodes / weights.size() < kept.size()) continue;
    kept.push_back(node);
    gram += linear(node) * linear(node).transpose();
  }
  // A flat surface says nothing across itself: the least solution.
  const Eigen::Matrix<double, 4, 3> factors =
      core::minimum_norm_solution(Eigen::MatrixXd(gram), Eigen::MatrixXd(moments.transpose()));
  Functional thin;
  for (const Index node : kept) {
    const Vector3d weight = factors.transpose() * linear(node);
    for (int i = 0; i < 3; ++i) thin.emplace_back(3 * node + i, weight[i]);
  }
  return thin;
}

/// The gap of a spring by displacements in the machine's frame.
std::vector<Entry> gap_entries(const Model& model, const UnitFunctionals& units, const Spring& spring) {
  std::map<Index, Vector3d> of_node;
  double largest = 0.0;
  for (const UnitTerm& term : spring.gap) {
    const Eigen::Matrix3d turn = model.frame(term.body).linear();
    const mesh::TetMesh& body = model.mesh.bodies[term.body];
    for (const auto& [dof, weight] : thinned(body, units.of(term.body)[term.unit])) {
      const auto at = of_node.try_emplace(model.node(term.body, dof / 3), Vector3d::Zero()).first;
      at->second += term.weight * weight * turn.col(dof % 3);
      largest = std::max(largest, at->second.cwiseAbs().maxCoeff());
    }
  }
  constexpr double rounding = 1e-14;
  std::vector<Entry> entries;
  for (const auto& [node, factor] : of_node) {
    for (int i = 0; i < 3; ++i)
      if (std::abs(factor[i]) > rounding * largest) entries.push_back({node, i + 1, factor[i]});
  }
  return entries;
}

class StaticWriter {
public:
  explicit StaticWriter(Model& model) : model_(model), units_(model.mesh.bodies.size()) {}

  Statics text() {
    std::vector<int> elastic;
    for (int b = 0; b < std::ssize(model_.taken); ++b)
      if (model_.takes(b) && model_.machine().bodies[b].elastic) elastic.push_back(b);
    const bool whole = model_.options.body.empty();
    const std::vector<Spring> springs = whole ? make_springs() : std::vector<Spring>();
    if (springs.empty()) {
      for (const int body : elastic) support(body);
      model_.notes.push_back(std::string(whole ? "no joint has stiffness" : "the body stands alone") +
                             ": it is held at three nodes without strain (3-2-1)");
      return statics_;
    }
    require_held(model_.machine(), elastic, springs);
    for (const Spring& spring : springs) spring.flexibility > 0.0 ? add_spring(spring) : add_scale(spring);
    model_.notes.push_back(
        fmt::format("joints in static.inp are springs between mean displacements of their pads, as in thermotwin. "
                    "Means over more than {} nodes use {} of them, which is exact for motions linear in space",
                    most_nodes, kept_nodes));
    return statics_;
  }

private:
  std::vector<Spring> make_springs() {
    std::vector<JointGrid> grids;  // of this pose alone
    for (const mesh::JointSpec& joint : model_.machine().joints) {
      const int axis = joint.axis.empty() ? -1 : model_.machine().axis_index(joint.axis);
      grids.push_back({axis, false, {axis < 0 ? 0.0 : model_.pose[axis]}});
    }
    return SpringSet(model_.mesh, grids, units_).at(model_.machine(), model_.pose);
  }

  void support(int body) {
    const std::size_t b = body;
    const mesh::BodySpec& spec = model_.machine().bodies[b];
    const Eigen::Isometry3d frame = model_.frame(body);
    const ElasticBody assembled =
        assemble_elastic(model_.mesh.bodies[b], model_.machine().material(spec.material), spec.id);
    for (const Index dof : assembled.fixed) {
      const Vector3d direction = frame.linear().col(dof % 3);
      const Index node = model_.node(body, dof / 3);
      int along = 0;
      if (direction.cwiseAbs().maxCoeff(&along) > 1.0 - 1e-12) {
        statics_.model += fmt::format("*BOUNDARY\n{}, {}, {}\n", node, along + 1, along + 1);
        continue;
      }
      std::vector<Entry> entries{{node, along + 1, direction[along]}};
      for (int i = 0; i < 3; ++i)
        if (i != along && std::abs(direction[i]) > 1e-14) entries.push_back({node, i + 1, direction[i]});
      statics_.model += equation(entries);
    }
  }

  /// A node of the deck's own whose displacement along x is the gap.
  Index gap_node() {
    const Index node = model_.next_node++;
    statics_.model += fmt::format("*NODE\n{}, 0, 0, 0\n*BOUNDARY\n{}, 2, 3\n", node, node);
    return node;
  }

  void add_spring(const Spring& spring) {
    std::vector<Entry> entries = gap_entries(model_, units_, spring);
    add_expansion(spring, entries);
    const Index node = gap_node(), element = model_.next_element++;
    entries.insert(entries.begin(), {node, 1, -1.0});
    const std::string set = "SPRING_" + std::to_string(element);
    statics_.model += equation(entries);
    statics_.model += fmt::format("*ELEMENT, TYPE=SPRING1, ELSET={}\n{}, {}\n*SPRING, ELSET={}\n1\n{:.9e}\n", set,
                                  element, node, set, 1.0 / spring.flexibility);
  }

  /// What a tape or screw expands by comes off the gap: the mean temperature over it, weighted by its
  /// own expansion, is that of a free element of 1 m with an expansion of 1/K.
  void add_expansion(const Spring& spring, std::vector<Entry>& entries) {
    double per_kelvin = 0.0;
    std::map<Index, double> weights;
    for (const auto& [node, factor] : spring.expansion) {
      weights[model_.node(spring.expansion_body, node)] += factor;
      per_kelvin += factor;
    }
    if (per_kelvin != 0.0) entries.push_back({thermometer(weights, per_kelvin), 1, -per_kelvin});
  }

  void add_scale(const Spring& scale) {
    std::vector<Entry> entries = gap_entries(model_, units_, scale);
    // The equation's first unknown is eliminated: one that no other scale has eliminated.
    const auto first = std::max_element(entries.begin(), entries.end(), [&](const Entry& a, const Entry& b) {
      const auto size = [&](const Entry& e) {
        return eliminated_.contains({e.node, e.direction}) ? 0.0 : std::abs(e.factor);
      };
      return size(a) < size(b);
    });
    std::iter_swap(entries.begin(), first);
    eliminated_.insert({entries.front().node, entries.front().direction});
    add_expansion(scale, entries);
    statics_.model += equation(entries);
  }

  /// @return the node that moves by 1 m/K along x
  Index thermometer(const std::map<Index, double>& weights, double per_kelvin) {
    const Index node = model_.next_node, element = model_.next_element++;
    model_.next_node += 4;
    const std::string name = "TAPE_" + std::to_string(element);
    std::string text = fmt::format("*NODE, NSET=TAPES\n{}, 0, 0, 0\n{}, 1, 0, 0\n{}, 0, 1, 0\n{}, 0, 0, 1\n", node,
                                   node + 1, node + 2, node + 3);
    text += fmt::format("*ELEMENT, TYPE=C3D4, ELSET={}\n{}, {}, {}, {}, {}\n", name, element, node, node + 1, node + 2,
                        node + 3);
    text += fmt::format(
        "*MATERIAL, NAME={}\n*ELASTIC\n1e12, 0\n*EXPANSION, ZERO={:.10g}\n1\n*CONDUCTIVITY\n1\n*DENSITY\n1e-9\n"
        "*SPECIFIC HEAT\n1\n*SOLID SECTION, ELSET={}, MATERIAL={}\n",
        name, model_.machine().reference_C, name, name);
    statics_.heat_model += text;
    for (Index i = 0; i < 4; ++i) {
      std::vector<Entry> entries{{node + i, 11, -1.0}};
      for (const auto& [from, weight] : weights)
        if (weight != 0.0) entries.push_back({from, 11, weight / per_kelvin});
      statics_.heat_model += equation(entries);
    }
    statics_.model += text + fmt::format("*BOUNDARY\n{}, 1, 3\n{}, 2, 3\n{}, 3, 3\n", node, node + 1, node + 2);
    return node + 1;
  }

  Model& model_;
  UnitFunctionals units_;
  std::set<std::pair<Index, int>> eliminated_;
  Statics statics_;
};

}  // namespace

Statics statics(Model& model) { return StaticWriter(model).text(); }

}  // namespace thermotwin::solver::calculix
