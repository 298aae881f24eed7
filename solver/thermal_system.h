// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Matrices of the affine equation on the full mesh. Unknowns: nodes of all bodies (numbered as
// MachineMesh::first_node says), then those of coolants and volumes (fluid_assembly.h). Tetrahedra of the
// mesh's order, consistent or lumped capacity (thermal_elements.h). Contacts are integrated on the slave's triangles against the closest point
// of the master at each grid node of the joint. Coolant flow is upwind, its matrix not symmetric,
// G + G^T >= 0; all others are symmetric and non-negative.

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "core/binary.h"
#include "mesh/machine_mesh.h"
#include "solver/element_matrix.h"
#include "solver/local_terms.h"
#include "solver/linear_solver.h"
#include "solver/operating_model.h"

namespace thermotwin::solver {

struct ThermalSystem {
  Layout layout;
  Eigen::Index nodes = 0;            ///< of the bodies
  Eigen::Index size = 0;             ///< nodes + fluid nodes
  SparseMatrix capacity, conduction; ///< E in J/K, K0 in W/K
  std::vector<SparseMatrix> terms;   ///< K_j for p_j = 1
  SparseMatrix inputs;               ///< (size x inputs) s_k for q_k = 1
  std::shared_ptr<const LocalTerms> local;  ///< what depends on temperature from place to place; null: nothing
  SparseMatrix sensors;              ///< (sensors + layout.observed x size) their temperatures
  LinearSolver solver = LinearSolver::direct;  ///< of the nodes of the bodies, for all that solve
};

/// @throws InputError (a joint without any contact over the travel, a surface of zero area)
ThermalSystem assemble_thermal(const mesh::MachineMesh& mesh);  // local terms refer to the mesh, which must outlive them

/// Advances temperatures by one step; the full and the reduced model each have one.
class ThermalStepper {
 public:
  virtual ~ThermalStepper() = default;
  virtual Eigen::Index size() const = 0;
  virtual const Layout& layout() const = 0;
  /// State of uniform temperature, K above the reference (reduced: its projection).
  virtual Eigen::VectorXd uniform(double temperature_K) const = 0;
  /// @param state  (size x loads), overwritten by the state at the end of the step
  /// @param c      (loads) coefficients, constant over the step   @param step_s  > 0
  /// @throws SolverError if the iteration does not converge
  virtual void advance(Eigen::MatrixXd& state, const std::vector<Coefficients>& c,
                       double step_s) = 0;
  /// Whether matrices depend on the temperature from place to place. Then linearise() says between
  /// which states the next step is expected to go, and the step is repeated until it does.
  virtual bool is_nonlinear() const { return false; }
  virtual void linearise(const Eigen::MatrixXd& /*start*/, const Eigen::MatrixXd& /*end*/, const std::vector<Coefficients>&) {}
  /// Temperatures whose heat flows the last step had, (size x loads), see HeatBalance; null: not kept.
  virtual const Eigen::MatrixXd* mean_over_step() const { return nullptr; }
  /// What was local to a load in the last step; null: nothing.
  virtual const LocalTerms::Change* local_change(std::size_t /*load*/) const { return nullptr; }
  /// (sensors + observed x loads) K above the reference
  virtual Eigen::MatrixXd sensors(const Eigen::MatrixXd& state) const = 0;
  /// What the next steps' bits depend on besides the state, for a checkpoint.
  virtual void save(core::BinaryWriter&) const {}
  virtual void load(core::BinaryReader&) {}
};

/// Time scheme: two-stage, stiffly accurate, second-order SDIRK (Alexander 1977),
/// gamma = 1 - 1/sqrt(2); L-stable. Both stages share the factorised operator E/(gamma h) + K.
inline constexpr double sdirk_gamma = 0.29289321881345254;

struct IntegratorOptions {
  double tolerance = 1e-9;      ///< residual relative to the right-hand side
  int max_iterations = 60;
  int refactor_above = 8;       ///< iterations worth a new factor while coefficients keep changing
  bool keep_mean = false;       ///< for a HeatBalance
  bool backward_euler = false;  ///< first order instead, for comparison and for virtual machines
  double factor_memory = 1e9;   ///< bytes that factors beyond the first may take
};

/// One CHOLMOD factor of the mean operator serves all loads and steps while it is close enough;
/// what differs from it (films, contacts, flows of each load) is iterated by GCR, each load with
/// its own coefficients, their solves in one block. Where coefficients stand for long, each set of
/// loads that share them gets a factor of its own, as far as memory allows.
class ThermalIntegrator final : public ThermalStepper {
 public:
  explicit ThermalIntegrator(const ThermalSystem& system, const IntegratorOptions& options = {});
  ~ThermalIntegrator() override;

  Eigen::Index size() const override { return system_.size; }
  const Layout& layout() const override { return system_.layout; }
  Eigen::VectorXd uniform(double temperature_K) const override;
  void advance(Eigen::MatrixXd& state, const std::vector<Coefficients>& c, double step_s) override;
  bool is_nonlinear() const override { return system_.local != nullptr; }
  void linearise(const Eigen::MatrixXd& start, const Eigen::MatrixXd& end, const std::vector<Coefficients>& c) override;
  const Eigen::MatrixXd* mean_over_step() const override;
  const LocalTerms::Change* local_change(std::size_t load) const override;
  Eigen::MatrixXd sensors(const Eigen::MatrixXd& state) const override;
  void save(core::BinaryWriter& out) const override;
  void load(core::BinaryReader& in) override;

  struct Statistics { long steps = 0, factorisations = 0, iterations = 0; };
  const Statistics& statistics() const { return statistics_; }

 private:
  const ThermalSystem& system_;
  IntegratorOptions options_;
  Statistics statistics_;
  struct Work;
  std::unique_ptr<Work> work_;
};

/// Steady state of (K0 + sum p K) T = S q for one set of coefficients; (size).
Eigen::VectorXd solve_steady(const ThermalSystem& system, const Coefficients& c);

/// Solves (shift E + K0 + sum p K) X = B, shift in 1/s >= 0; X, B (size x m). Factorises once for
/// all columns; transpose for adjoints (coolant flow is not symmetric).
Eigen::MatrixXd solve_shifted(const ThermalSystem& system, const Coefficients& c, double shift,
                              const Eigen::MatrixXd& right_hand_side, bool transpose = false);

}  // namespace thermotwin::solver
