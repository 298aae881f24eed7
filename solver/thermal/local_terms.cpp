// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/local_terms.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "solver/operation/film_laws.h"
#include "solver/thermal/elements.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double same_K = 1e-4;  // closer than that the secant is the value in between

}  // namespace

LocalTerms::Curve LocalTerms::make_curve(const mesh::Curve& table, double nominal, double reference_C) {
  Curve curve{table, {0.0}, nominal, nominal / table(reference_C)};
  for (std::size_t i = 1; i < table.at.size(); ++i) {
    curve.integral.push_back(curve.integral.back() +
                             0.5 * (table.value[i] + table.value[i - 1]) * (table.at[i] - table.at[i - 1]));
  }
  return curve;
}

double LocalTerms::integral_to(const Curve& curve, double T_C) {
  const std::vector<double>& at = curve.table.at;
  if (T_C <= at.front()) return (T_C - at.front()) * curve.table.value.front();
  if (T_C >= at.back()) return curve.integral.back() + (T_C - at.back()) * curve.table.value.back();
  const std::size_t left = std::upper_bound(at.begin(), at.end(), T_C) - at.begin() - 1;
  return curve.integral[left] + 0.5 * (curve.table.value[left] + curve.table(T_C)) * (T_C - at[left]);
}

double LocalTerms::Curve::secant(double from_C, double to_C) const {
  if (std::abs(to_C - from_C) < same_K) return value(0.5 * (from_C + to_C));
  return factor * (integral_to(*this, to_C) - integral_to(*this, from_C)) / (to_C - from_C);
}

LocalTerms::LocalTerms(const mesh::MachineMesh& mesh, Index size)
    : reference_C_(mesh.machine.reference_C),
      lumped_(mesh.machine.lumped_capacity) {
  const mesh::Machine& machine = mesh.machine;
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    const mesh::Material& material = machine.material(machine.bodies[b].material);
    Body body{&mesh.bodies[b],
              static_cast<int>(mesh.first_node[b]),
              material.density,
              !material.conductivity_table.at.empty(),
              !material.specific_heat_table.at.empty(),
              {},
              {}};
    if (body.has_conductivity)
      body.conductivity = make_curve(material.conductivity_table, material.conductivity, reference_C_);
    if (body.has_heat) body.heat = make_curve(material.specific_heat_table, material.specific_heat.value, reference_C_);
    if (body.has_conductivity || body.has_heat) bodies_.push_back(std::move(body));
  }
  for (std::size_t f = 0; f < machine.films.size(); ++f) {
    if (!(machine.films[f].emissivity.value > 0.0 && machine.films[f].exact_radiation)) continue;
    for (const std::string& id : machine.films[f].surfaces) {
      const std::size_t surface = machine.surface_index(id);
      const std::size_t body = machine.body_index(machine.surfaces[surface].body);
      for (const int face : mesh.surfaces[surface])
        faces_.push_back({&mesh.bodies[body], face, static_cast<int>(mesh.first_node[body]), static_cast<int>(f)});
    }
  }
  if (!empty()) make_pattern(size);
}

void LocalTerms::make_pattern(Index size) {
  const auto visit = [&](const auto& put_element, const auto& put_face) {
    for (const Body& body : bodies_) {
      for (Index e = 0; e < body.mesh->elements(); ++e) {
        const mesh::TetNodes nodes = mesh::tet_nodes(*body.mesh, e).array() + body.first_node;
        for (Index i = 0; i < nodes.size(); ++i)
          for (Index j = 0; j < nodes.size(); ++j) put_element(nodes[i], nodes[j]);
      }
    }
    for (const Face& face : faces_) {
      const mesh::FaceNodes nodes = mesh::face_nodes(*face.mesh, face.face).array() + face.first_node;
      for (Index i = 0; i < nodes.size(); ++i)
        for (Index j = 0; j < nodes.size(); ++j) put_face(nodes[i], nodes[j]);
    }
  };
  std::vector<Eigen::Triplet<double, int>> entries;
  const auto note = [&](int row, int column) { entries.emplace_back(row, column, 0.0); };
  visit(note, note);
  pattern_.resize(size, size);
  pattern_.setFromTriplets(entries.begin(), entries.end());
  pattern_.makeCompressed();
  const auto place = [&](int row, int column) -> int {
    const int *first = pattern_.innerIndexPtr() + pattern_.outerIndexPtr()[column],
              *last = pattern_.innerIndexPtr() + pattern_.outerIndexPtr()[column + 1];
    return std::lower_bound(first, last, row) - pattern_.innerIndexPtr();
  };
  visit([&](int row, int column) { element_places_.push_back(place(row, column)); },
        [&](int row, int column) { face_places_.push_back(place(row, column)); });
}

void LocalTerms::evaluate(const VectorXd& start, const VectorXd& end, const Coefficients& c, Change& change) const {
  change.conduction = pattern_;
  change.capacity = pattern_;
  change.source.setZero(start.size());
  const int* place = element_places_.data();
  for (const Body& body : bodies_) place = add_body(body, start, end, place, change);
  place = face_places_.data();
  for (const Face& face : faces_) place = add_radiation(face, start, end, c, place, change);
}

/// Shape functions at the points of a quadrature.
struct LocalTerms::Quadrature {
  const std::vector<mesh::TetPoint>& rule;
  std::vector<mesh::TetValues> shapes;
  std::vector<mesh::TetSlopes> slopes;
  VectorXd lumped;  // (corners) shares of the volume

  explicit Quadrature(int order)
      : rule(mesh::tet_rule(order == 1 ? 2 : 5)),
        lumped(VectorXd::Zero(order == 1 ? 4 : 10)) {
    for (const mesh::TetPoint& point : rule) {
      shapes.push_back(mesh::tet_shape(order, point.at));
      slopes.push_back(mesh::tet_slopes(order, point.at));
      lumped += point.share * shapes.back().cwiseAbs2();
    }
    lumped /= lumped.sum();
  }
};

const int* LocalTerms::add_body(const Body& body, const VectorXd& start, const VectorXd& end, const int* place,
                                Change& change) const {
  double *conduction = change.conduction.valuePtr(), *capacity = change.capacity.valuePtr();
  const Quadrature at(body.mesh->order());
  const Index corners = at.lumped.size();
  mesh::TetValues before(corners), after(corners);
  MatrixXd k(corners, corners), m(corners, corners);
  for (Index e = 0; e < body.mesh->elements(); ++e) {
    const mesh::TetNodes nodes = mesh::tet_nodes(*body.mesh, e).array() + body.first_node;
    for (Index i = 0; i < corners; ++i) {
      before[i] = start[nodes[i]] + reference_C_;
      after[i] = end[nodes[i]] + reference_C_;
    }
    k.setZero();
    m.setZero();
    if (body.has_conductivity) add_conduction(body, e, at, before, after, k);
    if (body.has_heat) add_capacity(body, e, at, before, after, m);
    for (Index i = 0; i < corners; ++i) {
      for (Index j = 0; j < corners; ++j, ++place) {
        conduction[*place] += k(i, j);
        capacity[*place] += m(i, j);
      }
    }
  }
  return place;
}

void LocalTerms::add_conduction(const Body& body, Index element, const Quadrature& at, const mesh::TetValues& before,
                                const mesh::TetValues& after, MatrixXd& k) {
  const Eigen::Matrix<double, 4, 3> gradients = mesh::barycentric_gradients(*body.mesh, element);
  const Eigen::Matrix4d g = body.mesh->volume(element) * gradients * gradients.transpose();
  for (std::size_t q = 0; q < at.rule.size(); ++q) {
    const double T = 0.5 * at.shapes[q].dot(before + after);
    k += at.rule[q].share * (body.conductivity.value(T) - body.conductivity.nominal) * at.slopes[q] * g *
         at.slopes[q].transpose();
  }
}

void LocalTerms::add_capacity(const Body& body, Index element, const Quadrature& at, const mesh::TetValues& before,
                              const mesh::TetValues& after, MatrixXd& m) const {
  const double volume = body.mesh->volume(element);
  if (lumped_) {
    for (Index i = 0; i < m.rows(); ++i)
      m(i, i) = body.density * volume * at.lumped[i] * (body.heat.secant(before[i], after[i]) - body.heat.nominal);
    return;
  }
  for (std::size_t q = 0; q < at.rule.size(); ++q) {
    const double secant = body.heat.secant(at.shapes[q].dot(before), at.shapes[q].dot(after));
    m += at.rule[q].share * body.density * volume * (secant - body.heat.nominal) * at.shapes[q] *
         at.shapes[q].transpose();
  }
}

const int* LocalTerms::add_radiation(const Face& face, const VectorXd& start, const VectorXd& end,
                                     const Coefficients& c, const int* place, Change& change) const {
  const mesh::FaceNodes nodes = mesh::face_nodes(*face.mesh, face.face).array() + face.first_node;
  const auto of_film =
      std::find_if(c.radiation.begin(), c.radiation.end(), [&](const auto& r) { return r.film == face.film; });
  const Index corners = nodes.size();
  if (of_film == c.radiation.end()) return place + corners * corners;
  const double reference_K = reference_C_ + core::units::zero_C_in_K;
  const double area = face.mesh->face_area(face.face);
  MatrixXd k = MatrixXd::Zero(corners, corners);
  for (const mesh::FacePoint& point : mesh::face_rule(5)) {
    const mesh::FaceValues shape = mesh::face_shape(face.mesh->order(), point.at);
    double T = 0.0;
    for (Index i = 0; i < corners; ++i) T += 0.5 * shape[i] * (start[nodes[i]] + end[nodes[i]]);
    const double h = radiation_between(of_film->emissivity, T + reference_K, of_film->surroundings_K + reference_K) -
                     of_film->film_coefficient;
    const double weight = area * point.share * h;
    k += weight * shape * shape.transpose();
    for (Index i = 0; i < corners; ++i) change.source[nodes[i]] += weight * shape[i] * of_film->surroundings_K;
  }
  double* conduction = change.conduction.valuePtr();
  for (Index i = 0; i < corners; ++i)
    for (Index j = 0; j < corners; ++j, ++place) conduction[*place] += k(i, j);
  return place;
}

}  // namespace thermotwin::solver
