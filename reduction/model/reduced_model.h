// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The reduced state-space model: the affine equation of operating_model.h projected on a basis V, with sensors and TCP
// outputs. The Galerkin projection E_r = V^T E V keeps stability. Terms and inputs keep their order and meaning, so
// films, contacts, flows and axis positions act on the model without a new reduction. V is orthonormal in the inner
// product of the capacity: E_r = 1.

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

/// Output rows times the basis, at the poses of output_grid.h and in the frames of solver::OutputRows. The table side
/// depends on the table's tilt axes (interpolation exact for 1, sine and cosine) and on linear axes that carry the
/// table (quadratic). The effect of the other axes on the table side through the bed (0.1 um) is included in the tool
/// side.
struct ReducedOutputs {
  std::vector<mesh::Pose> tool_poses;   ///< the workspace grid, first axis slowest, and the lines of output_grid.h
  std::vector<Eigen::MatrixXd> tool;    ///< (6 x r) each
  std::vector<mesh::Pose> table_poses;  ///< grid of the table side, table axis at 0
  std::vector<Eigen::MatrixXd> table_axis, table_own;  ///< (6 x r), (7 x r) each
};

/// Contributions of each part of the machine to capacity and outputs. The capacity is a sum over bodies and volumes,
/// and the output rows are sums over the expansions of bodies, tapes and screws, so both are affine in the material
/// data of bodies:
///   E = E_0 + sum_b (c_b / c_b0 - 1) E_b,   C = C_0 + sum_b (a_b / a_b0 - 1) C_b.
/// With a joint's stiffness k (normal and tangential alike) the rows change by C' ((k / k0)^n - 1) / n, where C' is the
/// derivative with respect to ln k. The exponent n of a joint fits the second derivative where the joint acts most: -1
/// if the rows follow the compliance, 0 if they follow ln k.
struct Parts {
  /// (bodies, then volumes) (r x r) each. Models of earlier versions have those of bodies only.
  std::vector<Eigen::MatrixXd> capacity;
  /// One per item of the machine, with rows at the poses of the model's outputs, which are not repeated here; without
  /// rows if the item has no effect.
  std::vector<ReducedOutputs> bodies, scales, screws;
  std::vector<ReducedOutputs> stiffness;  ///< (joints) C'
  Eigen::VectorXd stiffness_exponent;     ///< (joints) n

  /// @return the factor on C' of a joint whose ln k has changed by this
  double stiffness_amount(Eigen::Index joint, double ln_ratio) const;
};

/// A part of a body's skin where a diagnosis may place an unknown heat source (basis/patches.h).
struct Patch {
  mesh::SurfaceSpec surface;                         ///< "<body>.patch_<k>" with a box as rule; not in machine.toml
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m, home frame
  double area = 0;                                   ///< m^2
};
mesh::SurfaceSpec patch_surface(const std::string& body, int index, const Eigen::Vector3d& box_min,
                                const Eigen::Vector3d& box_max);

struct Patches {
  std::vector<Patch> items;
  Eigen::MatrixXd inputs;  ///< (r x patches) input of 1 W, spread evenly over each patch
};

struct ReductionErrors {
  std::string load;               ///< held-out load
  double peak_um = 0;             ///< largest |TCP error| of the full model, translations
  double max_um = 0, rms_um = 0;  ///< reduced minus full, translations, all poses
  double estimate_max_um = 0;     ///< largest estimate of max_um (error_estimate.h); 0: not estimated
  double effectivity = 0;         ///< median of estimated over true error
};

/// How far the mesh is from convergence (basis/mesh_error.h).
struct MeshError {
  Eigen::VectorXd sensors;  ///< (sensors) share of the change of each temperature
  /// Of dx dy dz ra rb rc, all poses together: share of the motion in all three directions.
  Eigen::Matrix<double, 6, 1> tcp = Eigen::VectorXd::Zero(6);
  std::string second;  ///< the mesh that the model's was compared with
};

/// The air beside each sensor, which it takes on where it hangs loose (basis/sensor_air.h).
struct SensorAir {
  Eigen::VectorXi film;     ///< (sensors) film whose ambient it is; -1: none, or a sensor on no body
  Eigen::MatrixXd volumes;  ///< (volumes x r) K above the reference
};

struct ReducedModel {
  mesh::Machine machine;  ///< parsed from the text that the file keeps
  std::string size;       ///< mesh it comes from, with number of nodes
  Eigen::Index full_size = 0;
  ReducedSystem system;
  ReducedOutputs outputs;
  std::vector<ReductionErrors> errors;
  TrainedRange trained;
  std::optional<Parts> parts;           ///< see basis/parameter_parts.h; optional
  Patches patches;                      ///< empty: none were made
  std::optional<SensorAir> sensor_air;  ///< none: a model of an earlier version, or a foreign one
  std::optional<MeshError> mesh_error;  ///< none: no second mesh differs, or a model of an earlier version

  /// @return the TCP error at any pose of the workspace  @param state  (r)
  solver::TcpError tcp(const Eigen::VectorXd& state, const mesh::Pose& pose) const;
};

/// @return the interpolated output rows at a pose for solver::tcp_error, (19 x r): tool side 6, table side 6 and 7
Eigen::MatrixXd side_rows(const mesh::Machine& machine, const ReducedOutputs& outputs, const mesh::Pose& pose);

/// @return the rows of all solver::tcp_values at the poses, in um and um/m per state, (18 poses x r)
Eigen::MatrixXd value_rows(const ReducedModel& model, const std::vector<mesh::Pose>& poses);

struct StepperOptions {
  double refresh_tolerance = 1e-9;  ///< relative residual below which an older factor is reused
  void validate() const;            ///< @throws InputError
};

/// Steps with the time scheme of the full model (SDIRK2). The dense factor of one step size and coefficient set is
/// kept. Small changes of the coefficients are solved by iterative refinement with it, larger ones by a new factor. The
/// system must outlive the stepper.
class ReducedStepper final : public solver::ThermalStepper {
public:
  explicit ReducedStepper(const ReducedSystem& system, const StepperOptions& options = {});
  ~ReducedStepper() override;
  ReducedStepper(ReducedStepper&&) noexcept;

  Eigen::Index size() const override;
  const solver::Layout& layout() const override;
  Eigen::VectorXd uniform(double temperature_K) const override;
  void advance(Eigen::MatrixXd& state, const std::vector<solver::Coefficients>& c, double step_s) override;
  /// Advances one state (r), without allocation after the first call.
  void advance(Eigen::VectorXd& state, const solver::Coefficients& c, double step_s);
  Eigen::MatrixXd sensors(const Eigen::MatrixXd& state) const override;
  /// @return K0 + sum p K at the coefficients of the last step, (r x r), for observers
  const Eigen::MatrixXd& operator_matrix() const;
  long factorisations() const;

private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace thermotwin::reduction
