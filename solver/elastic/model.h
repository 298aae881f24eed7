// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Quasi-static thermo-elasticity of the machine: each elastic body factorised
// once in its own frame (statically determinate supports; its six rigid motions are separate
// unknowns), joints as springs between mean displacements of pads (normal and two tangential
// directions, stiffness per area times pad area), linear scales or screws as constraints along their axis.
// A pose changes a small dense system only:
//   [ 1/k + S^T K^+ S   -S^T R ] [f]   [ S^T K^+ F T - g ]
//   [ -R^T S                 0 ] [a] = [ -R^T F T        ]
// f spring forces, a rigid motions, S spring directions, g gap of the scales by their own
// expansion (scale or screw). Outputs are rows C, C T = output, by adjoint solves of the same system.
// Superposition holds for small displacements; gravity and clamping loads are out of scope. Linear
// tetrahedra are too stiff in bending: a free bar under a gradient across it bends by 43 % with one
// element over its height, 88 % with four and 97 % with eight; quadratic ones bend it exactly
// (tests/verification). With linear ones the size factor is to be checked.

#include <Eigen/Core>

#include <memory>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"
#include "solver/thermal/memory_plan.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

/// Rows times temperatures (K above the reference) of all nodes and fluid nodes (size columns).
/// Tool: displacement of tool_point (m) and rotation (rad) in the machine frame.
/// Table side, two parts in the frame of the body that carries the table (its home frame): the
/// rotary table's axis (rigid motion of the seat of its bearing, taken at table_point), and the
/// table's own motion relative to that at the pose's table angle 0, with R0T (radial growth in m at
/// table_radius). A table without rotary axis has zero own rows, but for R0T.
struct OutputRows {
  Eigen::MatrixXd tool;        ///< (6 x size) dx dy dz ra rb rc
  Eigen::MatrixXd table_axis;  ///< (6 x size)
  Eigen::MatrixXd table_own;   ///< (7 x size) ... R0T
};

struct ElasticOptions {
  SolverChoice choice = SolverChoice::direct;
  MemoryPlan* plan = nullptr;  ///< holds what heat needs; completed and decided here. None: as chosen
  double tolerance = 1e-10;    ///< of iterative solves
  void validate() const;       ///< @throws InputError
};

/// Output rows times a basis, by what they owe to each part of the machine: rows are sums over the
/// expansions of bodies, tapes and screws, so each changes with its own coefficient alone. Parts that
/// take no share have empty rows.
struct OutputParts {
  std::vector<OutputRows> bodies, scales, screws;  ///< one an item of the machine, in proportion to its expansion
  std::vector<OutputRows> stiffness;               ///< (joints) derivative of the whole by ln k, both stiffnesses alike
  std::vector<OutputRows> curvature;               ///< (joints) second derivative
};

class ElasticModel {
public:
  /// Factorises all bodies (in parallel) and solves for the unit loads of all pads at all grid
  /// nodes. @throws SolverError, MeshError (a body that no spring holds: its name)
  ElasticModel(const mesh::MachineMesh& mesh, const ThermalSystem& thermal, const ElasticOptions& options = {});
  ~ElasticModel();
  ElasticModel(ElasticModel&&) noexcept;

  /// @throws InputError here and in the other outputs of the TCP: a machine without [tcp]
  OutputRows output_rows(const mesh::Pose& pose) const;

  /// @param basis   (size x r)
  /// @param images  unit_images(basis), which serve all poses
  OutputParts output_parts(const mesh::Pose& pose, const Eigen::MatrixXd& basis,
                           const std::vector<Eigen::MatrixXd>& images) const;
  /// What the unit functionals of each body see of the expansion under each vector, (bodies) (units x r).
  std::vector<Eigen::MatrixXd> unit_images(const Eigen::MatrixXd& basis) const;

  /// Displacements of all nodes (3 x nodes), m, in each body's home frame; bodies with
  /// elastic = false move with their parent rigidly at the nearest node. No columns where no body is
  /// elastic. @param temperature (size)
  Eigen::Matrix3Xd displacement(const Eigen::VectorXd& temperature, const mesh::Pose& pose) const;

  /// Pull of a screw that is stretched between two bearings, N; at 0 it is slack, and the linear
  /// equation, which lets it push, ends.
  struct ScrewTension {
    int screw;
    double tension;
  };  ///< index into Machine::screws
  std::vector<ScrewTension> screw_tensions(const Eigen::VectorXd& temperature, const mesh::Pose& pose) const;

  /// The same outputs from a displacement field, for checks of the adjoint.
  struct Outputs {
    Eigen::Matrix<double, 6, 1> tool, table_axis;
    Eigen::Matrix<double, 7, 1> table_own;
  };
  Outputs outputs_of(const Eigen::Matrix3Xd& displacement, const mesh::Pose& pose) const;

  struct Summary {
    double factor_seconds = 0, unit_seconds = 0, factor_bytes = 0;
    long unit_solves = 0;
    int springs = 0;
    LinearSolver solver = LinearSolver::direct;
  };
  const Summary& summary() const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace thermotwin::solver
