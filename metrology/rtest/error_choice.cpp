// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/error_choice.h"

#include <algorithm>
#include <cmath>

#include "core/dense_algebra.h"
#include "core/text.h"
#include "metrology/rtest/error_terms.h"

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double distinct = 1e-3;   ///< share of a column's norm that has to be its own
constexpr double has_share = 0.05;  ///< of a column's norm: an error that a left-out one acts as
constexpr double no_effect = 1e-12;

/// Names of the chosen errors that have a share in the column.
std::vector<std::string> like(const VectorXd& column, const std::vector<VectorXd>& effects,
                              const std::vector<std::string>& chosen) {
  MatrixXd rows(column.size(), std::ssize(effects));
  for (Index i = 0; i < rows.cols(); ++i) rows.col(i) = effects[i] / effects[i].norm();
  const Eigen::ColPivHouseholderQR<MatrixXd> decomposition(rows);
  const VectorXd shares = decomposition.solve(column) / column.norm();
  std::vector<std::string> names;
  for (Index i = 0; i < shares.size(); ++i)
    if (std::abs(shares[i]) > has_share) names.push_back(chosen[i]);
  return names;
}

}  // namespace

ErrorChoice distinguished(const RTestRecord& record, const std::vector<std::string>& candidates) {
  compensation::OffsetOptions options;
  options.table_radius = record.table_radius;
  const compensation::LocationOffsets map(record.chain, options);
  const std::vector<ErrorTerm> terms = error_terms(candidates, map, record.chain, record.source);
  const std::vector<RTestPoint>& points = record.cycles.front().points;
  std::vector<VectorXd> basis, effects;  // orthonormal; as they are
  ErrorChoice choice;
  for (const ErrorTerm& term : terms) {
    VectorXd effect(3 * std::ssize(points));
    for (Index i = 0; i < std::ssize(points); ++i)
      effect.segment<3>(3 * i) = shift_of(term, map, points[i].positions, points[i].nominal);
    const double norm = effect.norm();
    if (!(norm > no_effect)) continue;
    VectorXd own = effect;
    for (int pass = 0; pass < 2; ++pass)
      for (const VectorXd& known : basis) own -= known * known.dot(own);
    if (own.norm() > std::max(distinct * norm, no_effect)) {
      if (2 * std::ssize(basis) >= effect.size()) {
        choice.left_out.push_back(term.name + ": too few points");
        continue;
      }
      basis.emplace_back(own / own.norm());
      effects.push_back(std::move(effect));
      choice.chosen.push_back(term.name);
    } else {
      choice.left_out.push_back(term.name + " from " + core::join(like(effect, effects, choice.chosen), " and "));
    }
  }
  return choice;
}

ErrorChoice default_errors(const RTestRecord& record) {
  const std::vector<std::string> moved = record.moved_axes();
  ErrorChoice choice;
  choice.chosen = usual_errors(record.chain, moved);
  std::vector<std::string> of_tool;
  for (const std::string& id : moved)
    if (!record.chain.find(id)->table_side) of_tool.push_back(id);
  if (of_tool.empty() || of_tool.size() == moved.size()) return choice;
  std::vector<std::string> candidates = choice.chosen;
  for (const std::string& id : of_tool) {
    for (const char letter : std::string("XYZABC")) {
      const std::string name = std::string(1, letter) + "0" + id;
      if (std::find(candidates.begin(), candidates.end(), name) == candidates.end()) candidates.push_back(name);
    }
  }
  return distinguished(record, candidates);
}

}  // namespace thermotwin::metrology
