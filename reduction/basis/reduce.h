// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Basis and projection of the reduced model. Candidates of the basis are snapshots of the campaign and rational block
// Krylov vectors (K(p) + s E)^-1 [inputs] with their adjoints for the TCP outputs and sensors (responses.h). Shifts s
// cover the time constants. Operating points p have speeds from 0 to the largest, fluids on and off, and axes at five
// places of their travel. Columns have their typical amplitude in K. A proper orthogonal decomposition in the inner
// product of the capacity compresses them. The order is the smallest tried that keeps the tolerance on the training
// loads.

#include <string>
#include <vector>

#include "reduction/basis/observer_noise.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::reduction {

/// Candidates of the basis.
enum class BasisMethod {
  combined,  ///< Krylov vectors, adjoints, changes of coefficients and snapshots
  krylov,    ///< the same without snapshots; no campaign needed
  pod,       ///< snapshots of the campaign alone
  balanced,  ///< dominant subspaces of both Gramians of the machine at rest
  modal      ///< slowest modes of the machine at rest
};
inline constexpr const char* basis_methods[] = {"combined", "krylov", "pod", "balanced", "modal"};
inline const char* name_of(BasisMethod method) { return basis_methods[static_cast<int>(method)]; }
/// @throws UsageError with the known names
BasisMethod basis_method(const std::string& name);

struct ReduceOptions {
  BasisMethod method = BasisMethod::combined;
  double tolerance_um = 0.05;  ///< largest error of the translations, training loads, all poses
  Eigen::Index max_order = 240;
  Eigen::Index order = 0;          ///< > 0: this order instead of the tolerance
  bool order_by_observer = false;  ///< instead: smallest order tried whose error is below ObserverNoise
  bool parts = true;               ///< add parts and patches, which a diagnosis uses
  int patches = 2000;              ///< largest number of patches of the skin, all bodies
  void validate() const;           ///< @throws InputError
};

struct ReduceSummary {
  Eigen::Index candidates = 0, deflated = 0, order = 0;
  double rows_seconds = 0, basis_seconds = 0, projection_seconds = 0, orders_seconds = 0, parts_seconds = 0;
  std::vector<std::pair<Eigen::Index, double>> order_error_um;  ///< (order, largest training error) of orders tried
  std::vector<ObserverNoise> observer;  ///< of the same orders; empty: no snapshots, or a machine that keeps all heat
  bool sensors = true;                  ///< whether the machine has sensors
  double missed_um = 0;                 ///< the tolerance, where none of several orders reaches it; else 0
  double prior_share = 0;               ///< see prior_share() in observer_noise.h
  Eigen::MatrixXd basis;                ///< (size x order) of the model
  double seconds() const { return rows_seconds + basis_seconds + projection_seconds + orders_seconds + parts_seconds; }
  /// The order tried from which on the error stays below the observer's noise; 0: none.
  Eigen::Index order_of_observer() const;
  std::string brief() const;
};

/// @param training   results of the training loads with snapshots (may be empty: Krylov only)
/// @param reference  if given: the model of reference_order(), for error_estimate.h
/// @param basis      if given: receives the model's basis and up to twice as many columns more, (size x 3 times the
///   largest order tried), for bound/model.h
ReducedModel reduce(const solver::FullModel& full, const std::vector<solver::LoadProgram>& loads,
                    const std::vector<solver::LoadResult>& training, const ReduceOptions& options,
                    ReduceSummary* summary = nullptr, ReducedModel* reference = nullptr,
                    Eigen::MatrixXd* basis = nullptr);

/// Order of the reference of an estimate: half as much again.
inline Eigen::Index reference_order(Eigen::Index order) { return order + (order + 1) / 2; }

}  // namespace thermotwin::reduction
