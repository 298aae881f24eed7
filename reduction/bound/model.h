// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What is needed to bound a reduced model's error at the TCP for some poses, made from the full model once.
// A trial space U holds the heat that each body stores, responses to the six outputs of the poses and the
// model's own basis; its leading columns, those of the outputs, are the dual space W. In both, Galerkin's
// solution leaves residuals in the full space,
//   primal  f - K(p) U x - E U x',   dual  c - ...,
// which are affine in p (terms.h); their norms are seen through probes (residual_probes.h), so nothing of
// the full model's size stays. error_bound.h runs it along a trajectory.

#include <Eigen/Core>

#include <vector>

#include "mesh/machine/kinematics.h"
#include "reduction/bound/residual_probes.h"
#include "reduction/bound/terms.h"
#include "reduction/model/reduced_model.h"
#include "reduction/model/trained_range.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "solver/operation/layout.h"

namespace thermotwin::reduction {

struct BoundOptions {
  Eigen::Index dual = 720;                   ///< columns of W for one pose beside the bodies', at most
  Eigen::Index most_dual = 900;              ///< for all poses together
  std::vector<double> steps_s{60.0, 120.0};  ///< lengths of steps that most runs take
  ProbeOptions probes;
  void validate() const;  ///< @throws InputError
};

struct BoundModel {
  std::string machine_hash;
  Eigen::Index full_size = 0;
  double failure = 0;  ///< share of draws for which one norm is seen too small; 0: exact
  solver::Layout layout;
  BoundTerms terms;               ///< on U (order m, its columns E-orthonormal)
  Eigen::MatrixXd inputs;         ///< (m x inputs)
  Eigen::VectorXd one_kelvin;     ///< (m) state of 1 K everywhere
  Eigen::VectorXd least;          ///< (terms) coefficients of the norm
  Eigen::MatrixXd primal_inputs;  ///< (probes x inputs): what inputs leave
  std::vector<mesh::Pose> poses;
  std::vector<Eigen::MatrixXd> rows;  ///< of each pose (6 x m), m and rad
  std::vector<Eigen::MatrixXd> rest;  ///< of each pose (probes x 6): the output's part beside E W
};

/// @throws InputError: a film radiates by fourth powers, a material has a table over temperature
void require_affine(const mesh::Machine& machine);

/// @param basis  of the model whose error is to be bounded, and more columns, which make the bound smaller (size x r)
/// @param range  coefficients that runs will have; below its lower end bounds grow
/// @param space  receives U (size x m), its leading columns are W
/// @throws InputError as require_affine
BoundModel make_bound_model(const solver::FullModel& full, const Eigen::MatrixXd& basis, const TrainedRange& range,
                            const std::vector<mesh::Pose>& poses, const BoundOptions& options = {},
                            Eigen::MatrixXd* space = nullptr);

/// Rows of the six TCP errors at a pose on the full mesh, (size x 6), m and rad.
Eigen::MatrixXd error_rows(const solver::FullModel& full, const mesh::Pose& pose);

}  // namespace thermotwin::reduction
