// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The evidence of a heat source on every patch of a model's skin, see missing_source_search.h: loads as few
// combinations of patches that outputs can tell from nothing, and what nuisances take of their responses.

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "diagnosis/response/problem.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::diagnosis {

inline constexpr double prior_source_W = 100.0;  ///< what an unknown source may have

/// Few loads that carry what outputs see of all: loads times weights is the patches' heat.
struct Combinations {
  Eigen::MatrixXd loads;    ///< (r x m)
  Eigen::MatrixXd weights;  ///< (m x patches)
};

/// @param patches  (r x patches)  @param rows  (outputs x r)  @param scale  (outputs) their expected errors
/// @param p  coefficients of the usual state
Combinations combinations(const reduction::ReducedModel& model, const Eigen::MatrixXd& patches,
                          const Eigen::MatrixXd& rows, const Eigen::VectorXd& scale, const Eigen::VectorXd& p);

inline constexpr double spread_shares[] = {0.0, 0.5, 1.0};  ///< of a source's heat that enters beside its patch

/// @param both  (m x 2 patches) each patch as it is, then spread
/// @return each patch as it is first, half and half, spread. (m x patches x shares)
Eigen::MatrixXd between(const Eigen::MatrixXd& both);

/// @return log of the mean over the shares, one row a patch
Eigen::MatrixXd over_shares(const Eigen::MatrixXd& evidence);

/// The search's data: responses of all combinations to all inputs, white, and what nuisances take of them.
struct SearchData {
  Eigen::MatrixXd white;      ///< (fitted x (combinations x inputs))
  Eigen::VectorXd residual;   ///< (fitted)
  Eigen::MatrixXd nuisances;  ///< (fitted x nuisances) in units of their prior
  Eigen::LLT<Eigen::MatrixXd> factor;

  SearchData(const Problem& problem, const Eigen::MatrixXd& responses);
  /// What nuisances take of columns of some rows: inner products are less by those of it. (nuisances x columns)
  Eigen::MatrixXd taken(const Eigen::Ref<const Eigen::MatrixXd>& columns) const {
    return factor.matrixL().solve(nuisances.transpose() * columns);
  }
};

/// Log evidence of every patch against none. @param own  (fitted x combinations) white responses to one input
Eigen::VectorXd evidence_of(const SearchData& seen, const Eigen::MatrixXd& own, const Eigen::MatrixXd& weights);

/// Log evidence of every patch (rows) and input (columns) against none; very low where it cannot be seen.
/// @param weights  (combinations x patches)
Eigen::MatrixXd all_evidence(const SearchData& seen, const Eigen::MatrixXd& weights, Eigen::Index inputs);

}  // namespace thermotwin::diagnosis
