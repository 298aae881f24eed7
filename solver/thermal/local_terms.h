// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What depends on the temperature from place to place and is no coefficient of a whole term:
// conductivity and specific heat over temperature, radiation by fourth powers. Evaluated between the
// start and the expected end of a step, they change the matrices and the right-hand side of that
// step, which is then solved anew until its end is the expected one:
//   K   int k((T0 + T1)/2) grad N grad N
//   E   int rho c N N, c the secant of the specific enthalpy between T0 and T1: heat is conserved
//   radiation  h N N and h U N with h = eps sigma (T^2 + U^2)(T + U), T = (T0 + T1)/2, less what the
//              film's own coefficient has for the surface's mean temperature
// Second order in time. Quadrature of degree 2 (order 1) or 5; of degree 5 on surfaces.

#include <Eigen/SparseCore>

#include <vector>

#include "mesh/body/shape.h"
#include "mesh/machine_mesh.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/element_matrix.h"

namespace thermotwin::solver {

class LocalTerms {
public:
  /// @param mesh  must outlive this object   @param size  of the system: nodes and fluids
  LocalTerms(const mesh::MachineMesh& mesh, Eigen::Index size);
  bool empty() const { return bodies_.empty() && faces_.empty(); }

  struct Change {
    SparseMatrix conduction, capacity;  ///< (size x size), to be added to K and E
    Eigen::VectorXd source;             ///< (size) W
    bool empty() const { return source.size() == 0; }
  };
  /// @param start, end  (size) K above the reference
  void evaluate(const Eigen::VectorXd& start, const Eigen::VectorXd& end, const Coefficients& c, Change& change) const;

private:
  /// A property over temperature, with its integral.
  struct Curve {
    mesh::Curve table;
    std::vector<double> integral;
    double nominal = 0, factor = 1;  ///< the matrices hold factor * nominal
    double value(double T_C) const { return factor * table(T_C); }
    double secant(double from_C, double to_C) const;
  };
  static Curve make_curve(const mesh::Curve& table, double nominal, double reference_C);
  static double integral_to(const Curve& curve, double T_C);

  struct Body {
    const mesh::TetMesh* mesh;
    int first_node;
    double density;
    bool has_conductivity, has_heat;
    Curve conductivity, heat;
  };
  struct Face {
    const mesh::TetMesh* mesh;
    int face, first_node, film;
  };

  struct Quadrature;

  void make_pattern(Eigen::Index size);
  /// @param place  first of the body's (face's) entries in the pattern's values   @return the next one's
  const int* add_body(const Body& body, const Eigen::VectorXd& start, const Eigen::VectorXd& end, const int* place,
                      Change& change) const;
  const int* add_radiation(const Face& face, const Eigen::VectorXd& start, const Eigen::VectorXd& end,
                           const Coefficients& c, const int* place, Change& change) const;
  /// @param before, after  degC at the element's nodes
  static void add_conduction(const Body& body, Eigen::Index element, const Quadrature& at,
                             const mesh::TetValues& before, const mesh::TetValues& after, Eigen::MatrixXd& k);
  void add_capacity(const Body& body, Eigen::Index element, const Quadrature& at, const mesh::TetValues& before,
                    const mesh::TetValues& after, Eigen::MatrixXd& m) const;

  std::vector<Body> bodies_;
  std::vector<Face> faces_;
  SparseMatrix pattern_;                           // all entries 0
  std::vector<int> element_places_, face_places_;  // of the entries in the pattern's values
  double reference_C_;
  bool lumped_;
};

}  // namespace thermotwin::solver
