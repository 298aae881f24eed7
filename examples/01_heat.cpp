// SPDX-License-Identifier: GPL-3.0-or-later
// Example 1: heat in one body, from a CAD file to temperatures.
//
// A wall takes up a power P on its top face, gives it to the air on its bottom face through a film h, and is insulated
// elsewhere. With the capacity matrix E, the conduction matrix K and the load f of finite elements,
//
//   E dT/dt + K T = f.
//
// In a prism of cross-section A and conductivity k the steady temperature is linear,
//
//   T(z) = T_air + P / (h A) + P (z - z_bottom) / (k A),
//
// and linear tetrahedra represent it exactly. The example checks that, and that a transient conserves heat.
//
// Usage: 01_heat [FILE]    FILE: CAD, surface or mesh file in mm; default: the column of the toy machine, a box
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/error.h"
#include "mesh/body/shape.h"
#include "mesh/import/import.h"
#include "mesh/selection.h"
#include "solver/linear/spd_solver.h"
#include "solver/thermal/elements.h"

using namespace thermotwin;

namespace {

constexpr double power_W = 30.0, film_W_m2K = 15.0, air_C = 20.0;

int run(const char* file) {
  // 1. A tetrahedral mesh. Everything inside the library is in SI units: unit_m is the length of one unit of the file.
  const mesh::TetMesh wall = mesh::import_body(file, {.body = "wall", .unit_m = 0.001, .element_size_m = 0.06});
  std::printf("mesh        %td nodes, %td tetrahedra, %.4f m3\n", wall.nodes(), wall.elements(), wall.total_volume());

  // 2. Faces by a geometric rule: all conditions of a rule have to hold; here the outward normal is the only one.
  mesh::Rule upwards, downwards;
  upwards.normal = Eigen::Vector3d::UnitZ();
  downwards.normal = -Eigen::Vector3d::UnitZ();
  const std::vector<int> top = mesh::select_faces(wall, upwards), bottom = mesh::select_faces(wall, downwards);

  // 3. Element integrals of the body.
  mesh::Material iron;
  iron.density = 7200.0;
  iron.specific_heat = {500.0};
  iron.conductivity = 46.0;
  const solver::BodyHeat heat = solver::assemble_heat(wall, iron, /*lumped=*/false);

  // 4. The film adds h times the integral of N N^T to K and h T_air times the integral of N to f; the heat adds its
  //    flux density times the integral of N. face_mass() and face_load() are these integrals on a triangle of area 1.
  std::vector<Eigen::Triplet<double>> film;
  Eigen::VectorXd load = Eigen::VectorXd::Zero(wall.nodes()), film_load = load;
  double top_area = 0.0;
  for (const int face : bottom) {
    const mesh::FaceNodes node = mesh::face_nodes(wall, face);
    const double h_area = film_W_m2K * wall.face_area(face);
    for (Eigen::Index i = 0; i < node.size(); ++i) {
      film_load[node[i]] += h_area * solver::face_load(wall.order())[i];
      for (Eigen::Index j = 0; j < node.size(); ++j)
        film.emplace_back(node[i], node[j], h_area * solver::face_mass(wall.order())(i, j));
    }
  }
  for (const int face : top) top_area += wall.face_area(face);
  for (const int face : top) {
    const mesh::FaceNodes node = mesh::face_nodes(wall, face);
    for (Eigen::Index i = 0; i < node.size(); ++i)
      load[node[i]] += power_W * wall.face_area(face) / top_area * solver::face_load(wall.order())[i];
  }
  load += air_C * film_load;
  solver::SparseMatrix conduction(wall.nodes(), wall.nodes());
  conduction.setFromTriplets(film.begin(), film.end());
  conduction += heat.conduction;

  // 5. Steady state: one factorisation by CHOLMOD.
  const Eigen::VectorXd steady_C = solver::SpdSolver(conduction, {}).solve(load);
  const double bottom_z = wall.points.row(2).minCoeff(), height = wall.points.row(2).maxCoeff() - bottom_z;
  const auto exact_C = [&](double z) {
    return air_C + power_W / top_area * (1.0 / film_W_m2K + (z - bottom_z) / iron.conductivity);
  };
  double error_K = 0.0;
  for (Eigen::Index n = 0; n < wall.nodes(); ++n)
    error_K = std::max(error_K, std::abs(steady_C[n] - exact_C(wall.points(2, n))));
  std::printf("steady      %.3f to %.3f degC, at most %.1e K from the exact solution\n", steady_C.minCoeff(),
              steady_C.maxCoeff(), error_K);

  // 6. Transient from the air's temperature: backward Euler, whose matrix is factorised once for all steps.
  const double step_s = 1800.0;
  const solver::SpdSolver stepper(solver::SparseMatrix(heat.capacity / step_s + conduction), {});
  Eigen::VectorXd temperature_C = Eigen::VectorXd::Constant(wall.nodes(), air_C);
  const double start_J = (heat.capacity * temperature_C).sum();
  double supplied_J = 0.0;
  for (int hour = 1; hour <= 24; ++hour) {
    for (int half = 0; half < 2; ++half) {
      temperature_C = stepper.solve(load + heat.capacity * temperature_C / step_s);
      supplied_J += step_s * (power_W - film_load.dot(temperature_C) + air_C * film_load.sum());
    }
    if (hour % 6 == 0)
      std::printf("%8d h  %.3f to %.3f degC\n", hour, temperature_C.minCoeff(), temperature_C.maxCoeff());
  }
  const double stored_J = (heat.capacity * temperature_C).sum() - start_J;
  const double gap = std::abs(stored_J - supplied_J) / supplied_J;
  std::printf("heat        %.0f J stored, %.0f J supplied, difference %.1e of it\n", stored_J, supplied_J, gap);

  const bool prism = std::abs(wall.total_volume() - top_area * height) < 1e-9 * wall.total_volume();
  return gap < 1e-9 && (!prism || error_K < 1e-7) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? argv[1] : TOY_CASE "/cad/column.stl");
  } catch (const core::Error& error) {  // says file, value and what is allowed
    std::fprintf(stderr, "%s\n", error.what());
    return error.exit_status();
  }
}
