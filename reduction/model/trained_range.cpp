// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/model/trained_range.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reduction/model/reduced_model.h"
#include "solver/operation/layout.h"

namespace thermotwin::reduction {
namespace {

constexpr double beyond_share = 0.1;  ///< of a range's width
constexpr double least_width = 0.1;   ///< of the largest value: what stood all the time

const std::string& item_id(const mesh::Machine& machine, const solver::Term& term) {
  const std::size_t item = term.item;
  switch (term.kind) {
    case solver::TermKind::film: return machine.films[item].id;
    case solver::TermKind::contact: return machine.joints[item].id;
    case solver::TermKind::coolant_wall:
    case solver::TermKind::coolant_flow: return machine.coolants[item].id;
    default: return machine.volumes[item].id;
  }
}

const char* kind_name(solver::TermKind kind) {
  switch (kind) {
    case solver::TermKind::film: return "film";
    case solver::TermKind::contact: return "joint";
    case solver::TermKind::coolant_wall: return "wall of coolant";
    case solver::TermKind::coolant_flow: return "flow of coolant";
    default: return "exchange of volume";
  }
}

/// A joint is known at all places of its axis where it is known at some: its grid was made for that.
TrainedRange any_place(const solver::Layout& layout, TrainedRange range) {
  for (std::size_t j = 0; j < layout.terms.size(); ++j) {
    const solver::Term& term = layout.terms[j];
    if (term.kind != solver::TermKind::contact || term.part == 0) continue;
    const Eigen::Index here = j, first = here - term.part;
    range.low(first) = std::min(range.low(first), range.low(here));
    range.high(first) = std::max(range.high(first), range.high(here));
  }
  for (std::size_t j = 0; j < layout.terms.size(); ++j) {
    const solver::Term& term = layout.terms[j];
    if (term.kind != solver::TermKind::contact) continue;
    const Eigen::Index here = j, first = here - term.part;
    range.low(here) = range.low(first);
    range.high(here) = range.high(first);
  }
  return range;
}

}  // namespace

void TrainedRange::include(const Eigen::VectorXd& p) {
  if (low.size() == 0) low = high = p;
  low = low.cwiseMin(p);
  high = high.cwiseMax(p);
}

std::string outside_trained(const ReducedModel& model, const TrainedRange& seen) {
  if (model.trained.low.size() != seen.low.size()) return {};
  const TrainedRange trained = any_place(model.system.layout, model.trained);
  double worst = beyond_share;
  std::string text;
  for (Eigen::Index j = 0; j < seen.low.size(); ++j) {
    const double low = trained.low(j), high = trained.high(j);
    const double width = std::max({high - low, least_width * std::abs(high), 1e-12});
    const double below = (low - seen.low(j)) / width, above = (seen.high(j) - high) / width;
    if (!(std::max(below, above) > worst)) continue;
    worst = std::max(below, above);
    const solver::Term& term = model.system.layout.terms[j];
    text = fmt::format("{} '{}' at {:.4g}, trained from {:.4g} to {:.4g}", kind_name(term.kind),
                       item_id(model.machine, term), below > above ? seen.low(j) : seen.high(j), low, high);
  }
  return text;
}

}  // namespace thermotwin::reduction
