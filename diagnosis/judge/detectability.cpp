// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/detectability.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/ranking.h"

namespace thermotwin::diagnosis {

std::vector<Detectable> detectability(const Problem& problem, const SearchResult& found) {
  const double seen = std::sqrt(2.0 * strong);
  std::map<Kind, Detectable> kinds;
  const auto of_kind = [&](const Parameter& p) -> Detectable& {
    Detectable& row = kinds[p.kind];
    row.kind = p.kind;
    row.unit = p.unit;
    row.ratio = p.ratio;
    return row;
  };
  for (const Hypothesis& h : found.hypotheses) {
    if (h.members.size() != 1 || h.std.size() != 1) continue;
    const Parameter& p = problem.parameters[h.members.front()];
    Detectable& row = of_kind(p);
    // What is within its stated uncertainty is no cause, however well it is seen.
    const double size = seen * std::hypot(h.std[0], p.nominal_std);
    if (row.best.empty() || size < row.least) row.least = size, row.best = p.where;
    if (row.worst.empty() || size > row.most) row.most = size, row.worst = p.where;
  }
  for (const int i : found.invisible) ++of_kind(problem.parameters[i]).invisible;
  std::vector<Detectable> rows;
  for (auto& [kind, row] : kinds) rows.push_back(std::move(row));
  return rows;
}

}  // namespace thermotwin::diagnosis
