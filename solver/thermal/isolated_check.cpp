// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/isolated_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "core/text.h"

namespace thermotwin::solver {

namespace {

using Eigen::Index;

/// Unknowns that exchange heat with each other.
class Groups {
public:
  explicit Groups(Index size) : root_(size) { std::iota(root_.begin(), root_.end(), Index{0}); }
  Index find(Index i) {
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  }
  void join(const SparseMatrix& matrix) {
    for (Index j = 0; j < matrix.outerSize(); ++j) {
      for (SparseMatrix::InnerIterator it(matrix, j); it; ++it)
        if (it.value() != 0.0) at(find(it.row())) = find(j);
    }
  }

private:
  Index& at(Index i) { return root_[i]; }
  std::vector<Index> root_;
};

/// A film or joint whose coefficient is nought at all times. What a state switches may be on.
bool never_exchanges(const mesh::Machine& machine, const Term& term) {
  if (term.kind == TermKind::contact) return machine.joints[term.item].conductance.value == 0.0;
  if (term.kind != TermKind::film) return false;
  const mesh::FilmSpec& film = machine.films[term.item];
  const std::vector<double>& table = film.table.power;
  const bool of_noughts = film.kind == mesh::FilmKind::table &&
                          std::all_of(table.begin(), table.end(), [](double value) { return value == 0.0; });
  return (of_noughts || film.coefficient.value == 0.0) && film.emissivity.value == 0.0;
}

}  // namespace

std::vector<std::string> isolated_parts(const mesh::MachineMesh& mesh, const ThermalSystem& thermal) {
  Groups groups(thermal.size);
  groups.join(thermal.conduction);
  const std::vector<Term>& terms = thermal.layout.terms;
  for (std::size_t t = 0; t < terms.size(); ++t)
    if (!never_exchanges(mesh.machine, terms[t])) groups.join(thermal.terms[t]);
  // A term that an input drives ends at a temperature that the machine does not change.
  std::map<Index, bool> leads_away;
  for (Index i = 0; i < thermal.size; ++i) leads_away.emplace(groups.find(i), false);
  for (std::size_t k = 0; k < thermal.layout.inputs.size(); ++k) {
    const int term = thermal.layout.inputs[k].term;
    if (term < 0 || never_exchanges(mesh.machine, terms[term])) continue;
    for (SparseMatrix::InnerIterator it(thermal.inputs, k); it; ++it) leads_away[groups.find(it.row())] = true;
  }
  struct Part {
    Index nodes = 0;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    std::vector<std::string> bodies;
  };
  std::map<Index, Part> parts;
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    for (Index n = 0; n < mesh.bodies[b].nodes(); ++n) {
      const Index root = groups.find(mesh.first_node[b] + n);
      if (leads_away.at(root)) continue;
      Part& part = parts[root];
      ++part.nodes;
      part.middle += mesh.bodies[b].points.col(n);
      if (const std::string& id = mesh.machine.bodies[b].id; part.bodies.empty() || part.bodies.back() != id)
        part.bodies.push_back(id);
    }
  }
  std::vector<std::string> sentences;
  for (const auto& [root, part] : parts) {
    const Eigen::Vector3d at = 1e3 * part.middle / part.nodes;
    sentences.push_back(fmt::format(
        "nothing takes heat from {} of '{}' ({} nodes around [{:.3g}, {:.3g}, {:.3g}] mm): no film, joint or coolant "
        "connects it to an ambient or an inlet, so its temperature rises without limit",
        part.bodies.size() == 1 ? "a part" : "parts", core::join(part.bodies), part.nodes, at.x(), at.y(), at.z()));
  }
  return sentences;
}

}  // namespace thermotwin::solver
