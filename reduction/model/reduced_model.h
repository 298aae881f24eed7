// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The reduced state-space model: the affine equation of operating_model.h projected on a basis V
// (Galerkin: E_r = V^T E V, so stability is kept), with sensors and TCP outputs. Terms and inputs
// keep their order and meaning, so films, contacts, flows and axis positions act on it without a
// new reduction. V is orthonormal in the capacity's inner product: E_r = 1.

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"
#include "reduction/model/trained_range.h"
#include "solver/elastic/model.h"
#include "solver/elastic/tcp.h"
#include "solver/operation/layout.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/stepper.h"
#include "solver/thermal/system.h"

namespace thermotwin::reduction {

struct ReducedSystem {
  solver::Layout layout;
  Eigen::MatrixXd capacity, conduction;  ///< (r x r)
  std::vector<Eigen::MatrixXd> terms;    ///< (r x r) each
  Eigen::MatrixXd inputs;                ///< (r x inputs)
  Eigen::MatrixXd sensors;               ///< (sensors + layout.observed x r)
  Eigen::VectorXd one_kelvin;            ///< (r) state of uniform 1 K above the reference
  Eigen::Index order() const { return conduction.rows(); }
};

/// Output rows, times the basis. The tool side is stored at the poses of output_grid.h, the table side
/// at the positions of the table's tilt axes (interpolation is exact for 1, sine and cosine) and of
/// linear axes that carry the table (quadratic), each in the frames of solver::OutputRows.
/// What the other axes do to the table side by way of the bed (0.1 um) is taken over by the tool's.
struct ReducedOutputs {
  std::vector<mesh::Pose> tool_poses;   ///< the workspace grid, first axis slowest, and what output_grid.h adds to it
  std::vector<Eigen::MatrixXd> tool;    ///< (6 x r) each
  std::vector<mesh::Pose> table_poses;  ///< grid of the table side, table axis at 0
  std::vector<Eigen::MatrixXd> table_axis, table_own;  ///< (6 x r), (7 x r) each
};

/// What heat content and outputs owe to each part of the machine. The capacity is a sum over bodies and volumes, the
/// output rows are sums over the expansions of bodies, tapes and screws, so both are affine in
/// material data of single bodies:
///   E = E_0 + sum_b (c_b / c_b0 - 1) E_b,   C = C_0 + sum_b (a_b / a_b0 - 1) C_b.
/// With a joint's stiffness k (normal and tangential alike) the rows change by C' ((k / k0)^n - 1) / n, C' the
/// derivative by ln k, and n one number a joint that makes the second derivative right where the joint
/// acts most: -1 where rows follow the compliance, 0 where they follow ln k.
struct Parts {
  /// (bodies, then volumes) (r x r) each. Models of earlier versions have those of bodies only.
  std::vector<Eigen::MatrixXd> capacity;
  /// One an item of the machine, rows at the poses of the model's own outputs (which are not repeated
  /// here); without rows where the item takes no share.
  std::vector<ReducedOutputs> bodies, scales, screws;
  std::vector<ReducedOutputs> stiffness;  ///< (joints) C'
  Eigen::VectorXd stiffness_exponent;     ///< (joints) n

  /// What multiplies C' of a joint whose stiffness has changed by this in ln k.
  double stiffness_amount(Eigen::Index joint, double ln_ratio) const;
};

/// A piece of a body's skin that may turn out to be warmed by something unknown (patches.h).
struct Patch {
  mesh::SurfaceSpec surface;                         ///< of no machine.toml yet: "<body>.patch_<k>", a box as rule
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m, home frame
  double area = 0;                                   ///< m^2
};
mesh::SurfaceSpec patch_surface(const std::string& body, int index, const Eigen::Vector3d& box_min,
                                const Eigen::Vector3d& box_max);

struct Patches {
  std::vector<Patch> items;
  Eigen::MatrixXd inputs;  ///< (r x patches) of 1 W, spread evenly
};

struct ReductionErrors {
  std::string load;               ///< held-out load
  double peak_um = 0;             ///< largest |TCP error| of the full model, translations
  double max_um = 0, rms_um = 0;  ///< reduced minus full, translations, all poses
  double estimate_max_um = 0;     ///< largest estimate of that (error_estimate.h); 0: none made
  double effectivity = 0;         ///< median of estimated over true
};

struct ReducedModel {
  mesh::Machine machine;  ///< parsed from the text that the file keeps
  std::string size;       ///< mesh it comes from, with number of nodes
  Eigen::Index full_size = 0;
  ReducedSystem system;
  ReducedOutputs outputs;
  std::vector<ReductionErrors> errors;
  TrainedRange trained;
  std::optional<Parts> parts;  ///< if they were made (basis/parameter_parts.h)
  Patches patches;             ///< empty: none were made

  /// TCP error at any pose of the workspace. @param state (r)
  solver::TcpError tcp(const Eigen::VectorXd& state, const mesh::Pose& pose) const;
};

/// Tool side (6), table side (6 and 7) of outputs between the stored poses, (19 x r), as
/// solver::tcp_error wants them.
Eigen::MatrixXd side_rows(const mesh::Machine& machine, const ReducedOutputs& outputs, const mesh::Pose& pose);

/// All of solver::tcp_values at the poses, in um and um/m: (18 poses x r), to be multiplied by states.
Eigen::MatrixXd value_rows(const ReducedModel& model, const std::vector<mesh::Pose>& poses);

struct StepperOptions {
  double refresh_tolerance = 1e-9;  ///< relative residual below which an older factor is good
  void validate() const;            ///< @throws InputError
};

/// Time scheme as the full model (SDIRK2). The system must outlive the stepper. The dense factor of one step size and
/// coefficient set is kept; small changes are met by refinement with it, larger ones by a new factor.
class ReducedStepper final : public solver::ThermalStepper {
public:
  explicit ReducedStepper(const ReducedSystem& system, const StepperOptions& options = {});
  ~ReducedStepper() override;
  ReducedStepper(ReducedStepper&&) noexcept;

  Eigen::Index size() const override;
  const solver::Layout& layout() const override;
  Eigen::VectorXd uniform(double temperature_K) const override;
  void advance(Eigen::MatrixXd& state, const std::vector<solver::Coefficients>& c, double step_s) override;
  /// One state, no allocation after the first call.
  void advance(Eigen::VectorXd& state, const solver::Coefficients& c, double step_s);
  Eigen::MatrixXd sensors(const Eigen::MatrixXd& state) const override;
  /// K0 + sum p K at the coefficients of the last step (r x r), for observers.
  const Eigen::MatrixXd& operator_matrix() const;
  long factorisations() const;

private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace thermotwin::reduction
