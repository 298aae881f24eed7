// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Predicted channels of a machine variant along a measurement, by the reduced model
//   E dx/dt + A(t) x = f(t),   A = K0 + sum p K,   f = sum q s,
// and how they change with parameters of the machine, by the tangent equation
//   E dx'/dt + A x' = f' - A' x
// in the same stages of the same SDIRK2 scheme, so a sensitivity is the exact derivative of what is
// predicted. All tangents share the factors of A with the prediction: sixty of them cost little more
// than one run. p, q, p', q' are those of solver::OperatingModel for the machine and its variants,
// each with its own chillers in the loop. What changes readings only (readings.h) needs no run; heat
// capacities and output rows change by reduction::Parts, where the model has them. Several records of one machine run
// one by one; what each begins with and when its inputs changed has columns of its own.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/causes/parameter_sizes.h"
#include "diagnosis/record/observations.h"
#include "diagnosis/response/propagation.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::diagnosis {

/// The base machine with some parameters at values.
MachineInTime with_parameters(const MachineInTime& base, const std::vector<Parameter>& parameters,
                              const Eigen::VectorXd& values);

class Response {
public:
  /// Both must outlive it.
  Response(const reduction::ReducedModel& model, const Observations& observations);
  /// Whether parameters that need parts can act.
  bool has_parts() const { return model_.parts.has_value(); }
  const std::optional<reduction::MeshError>& mesh_error() const { return model_.mesh_error; }
  /// (observed channels x r) of the model's own machine
  Eigen::MatrixXd nominal_rows() const;

  struct Linear {
    Eigen::VectorXd predicted;    ///< (observations) channel after channel
    Eigen::MatrixXd sensitivity;  ///< (observations x parameters), per unit of each
    /// (observations x starts) per K of the uniform start and of slow modes of the machine, then per whole share of
    /// what may have run before, see start_modes.h, if asked for
    Eigen::MatrixXd start;
    Eigen::VectorXd start_std;  ///< (starts) prior standard deviations
    Eigen::MatrixXd held;       ///< (observations x may_hold) where those inputs hold all of their while, if asked for
    Eigen::MatrixXd disturbed;  ///< (observations x disturbances) per K of their peaks
    /// (observations x parameters) what each parameter's heat changes when it enters spread, see spread_heat(),
    /// instead of where the machine says, per unit; zero for what adds no heat. Empty if not asked for.
    Eigen::MatrixXd spread;
  };

  /// @param base        machine that the parameters change
  /// @param parameters, values  where it is linearised: each parameter at its value
  /// @param with_record  what the record leaves open too: the start, and when its inputs changed
  Linear linearise(const MachineInTime& base, const std::vector<Parameter>& parameters, const Eigen::VectorXd& values,
                   bool with_record, const std::vector<Disturbance>& disturbances = {}, bool with_spread = false) const;
  /// Heat in the reduced coordinates to the same heat after a while of conduction within its body,
  /// E (E + t K0)^-1: where a bearing's or a motor's heat enters is known to some centimetres. (r x r)
  Eigen::MatrixXd spread_heat() const;
  /// start_modes() of its record
  Eigen::MatrixXd start_modes(const mesh::Machine& machine) const;
  Eigen::VectorXd predict(const MachineInTime& machine) const;
  /// What each load in W makes of the observations that follows each series (steps x series), the loads
  /// of the first series first: (observations x (loads x series)). @param loads (r x loads)
  Eigen::MatrixXd to_heat(const MachineInTime& machine, const Eigen::MatrixXd& loads,
                          const Eigen::MatrixXd& series) const;
  /// The run of a machine, (points x observed channels and volumes), and what a machine whose readings differ makes
  /// of it, (observations): many faulty sensors and clocks for one run. Several records lie below each other.
  Eigen::MatrixXd states(const MachineInTime& machine) const;
  Eigen::VectorXd read(const mesh::Machine& machine, const Eigen::MatrixXd& states) const;

  /// Predicted readings (degC) or displacements (um, um/m) at the ends of the steps of a single record.
  Eigen::MatrixXd at_points(const MachineInTime& machine) const;

  /// Values of all sensors (degC) and of dx dy dz (um) at the given poses along the measurement's
  /// inputs: what another measurement would have seen. (points x (sensors + 3 poses))
  Eigen::MatrixXd elsewhere(const MachineInTime& machine, const std::vector<mesh::Pose>& poses) const;

  /// dx dy dz of the TCP error, um, at poses along one of the records. (points x 3 poses)
  Eigen::MatrixXd deviations(const MachineInTime& machine, int record, const std::vector<mesh::Pose>& poses) const;

private:
  /// Output rows of a machine whose expansions or stiffnesses may differ from the model's own.
  struct Rows {
    Eigen::MatrixXd base;
    std::vector<Eigen::MatrixXd> bodies, scales, screws, stiffness;
  };
  Eigen::MatrixXd rows_of(const Rows& all, const PartChanges& changes) const;
  /// Outputs along the points: of the machine, then the tangents in units of each variant's step.
  std::vector<Eigen::MatrixXd> run(const MachineInTime& machine, std::vector<Variant>& variants,
                                   const Rows& rows) const;
  Eigen::MatrixXd capacity_of(const mesh::Machine& machine) const;
  /// What is recorded of the observed channels. @param states (points x channels and volumes), K or um
  Eigen::MatrixXd records(const mesh::Machine& machine, const Eigen::MatrixXd& states) const;
  Rows observed_rows() const;
  Eigen::VectorXd stack(const Eigen::MatrixXd& at_points) const;

  const reduction::ReducedModel& model_;
  const Observations& observations_;
  /// linearise() of each record, below each other.
  Linear linearise_each(const MachineInTime& base, const std::vector<Parameter>& parameters,
                        const Eigen::VectorXd& values, bool with_record, const std::vector<Disturbance>& disturbances,
                        bool with_spread) const;
  void set_air();
  /// Temperature of the air beside a sensor, degC. @param states  as in records()
  Eigen::VectorXd air_beside(int sensor, const Eigen::MatrixXd& states) const;

  std::vector<Response> each_;   ///< of several records; empty: there is one, and what follows is of it
  Rows rows_;                    ///< (observed channels and volumes x r)
  Eigen::MatrixXd air_;          ///< (points x ambients of those sensors) degC
  std::vector<int> of_ambient_;  ///< (sensors) column of air_, or -1: a volume
  std::vector<int> of_volume_;   ///< (sensors) volume, or -1
};

}  // namespace thermotwin::diagnosis
