// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One body with films and heat sources on groups of its skin, as the published heat cases have it.

#include "solver/thermal/assembly.h"
#include "solver/thermal/system.h"
#include "tests/verification/fields.h"

namespace thermotwin::test {

inline constexpr double as_good_as_given = 1e8;  ///< W/(m^2 K): the surface takes the ambient's temperature

inline std::string of_order(const std::string& name, int order) { return name + (order == 1 ? ", P1" : ", P2"); }

inline mesh::Material heat_material(double conductivity, double density, double specific_heat) {
  mesh::Material m = steel();
  m.conductivity = conductivity;
  m.density = density;
  m.specific_heat = {specific_heat, 0.0};
  return m;
}

struct GroupFilm {
  std::string group;
  double coefficient, ambient_C;
};
struct GroupFlux {
  std::string group;
  double flux;  ///< W/m^2, inward
};

/// Steady and transient heat of one body; temperatures are above 0 degC.
class HeatRig {
public:
  HeatRig(mesh::TetMesh mesh, const mesh::Material& material, const std::vector<GroupFilm>& films,
          const std::vector<GroupFlux>& fluxes = {})
      : mesh_(made(std::move(mesh), material, films, fluxes)),
        system_(solver::assemble_thermal(mesh_)),
        model_(mesh_.machine, system_.layout),
        coefficients_(model_.coefficients(model_.channels().defaults(), Eigen::VectorXd())) {}

  const mesh::TetMesh& body() const { return mesh_.bodies[0]; }
  const mesh::MachineMesh& machine_mesh() const { return mesh_; }
  const solver::ThermalSystem& system() const { return system_; }
  const solver::Coefficients& coefficients() const { return coefficients_; }

  /// Coefficients with the ambient of the n-th film at another temperature.
  solver::Coefficients with_ambient(std::size_t film, double temperature_C) const {
    Eigen::VectorXd row = model_.channels().defaults();
    row[model_.channels().index("ambient" + std::to_string(film) + ".T_C")] = temperature_C;
    return model_.coefficients(row, Eigen::VectorXd());
  }

  Eigen::VectorXd steady() const { return solver::solve_steady(system_, coefficients_); }

  /// Temperature at a place of the body, by its shape functions.
  double at(const Eigen::VectorXd& state, const Vector3d& place) const {
    double best = -1e300, value = 0.0;
    for (Index e = 0; e < body().elements(); ++e) {
      const Eigen::Vector4d where = mesh::barycentric(body(), e, place);
      if (where.minCoeff() <= best) continue;
      best = where.minCoeff();
      const mesh::TetNodes nodes = mesh::tet_nodes(body(), e);
      const mesh::TetValues n = mesh::tet_shape(body().order(), where);
      value = 0.0;
      for (Index i = 0; i < nodes.size(); ++i) value += n[i] * state[nodes[i]];
    }
    return value;
  }

private:
  static mesh::MachineMesh made(mesh::TetMesh mesh, const mesh::Material& material, const std::vector<GroupFilm>& films,
                                const std::vector<GroupFlux>& fluxes) {
    mesh::Machine m;
    m.reference_C = 0.0;
    m.order = mesh.order();
    m.materials = {material};
    m.bodies = {test::body("body", material.id)};
    for (std::size_t f = 0; f < films.size(); ++f) {
      const std::string number = std::to_string(f);
      m.ambients.push_back(ambient("ambient" + number, films[f].ambient_C));
      m.surfaces.push_back(surface("film" + number, "body", {films[f].group}));
      m.films.push_back(constant_film("film" + number, {"film" + number}, films[f].coefficient, "ambient" + number));
    }
    for (std::size_t f = 0; f < fluxes.size(); ++f) {
      const std::string id = "flux" + std::to_string(f);
      m.surfaces.push_back(surface(id, "body", {fluxes[f].group}));
      double area = 0.0;
      for (const int face : mesh.groups.at(fluxes[f].group)) area += mesh.face_area(face);
      mesh::SourceSpec source;
      source.id = id;
      source.laws = {{"machine.on", {0, 1}, {0, area * fluxes[f].flux}}};
      source.places.resize(1);
      source.places[0].surface = id;
      m.sources.push_back(source);
    }
    return test::machine_mesh(m, {std::move(mesh)});
  }

  mesh::MachineMesh mesh_;
  solver::ThermalSystem system_;
  solver::OperatingModel model_;
  solver::Coefficients coefficients_;
};

inline mesh::TetMesh box_of_order(const Vector3d& low, const Vector3d& high, const Eigen::Vector3i& cells, int order) {
  mesh::TetMesh box = box_mesh(low, high, cells);
  mesh::set_order(box, order);
  return box;
}

}  // namespace thermotwin::test
