// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/load_fields.h"

#include <algorithm>
#include <utility>

#include "solver/linear/field_modes.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::MatrixXd;

std::vector<Index> thinned(Index count, Index most) {
  std::vector<Index> kept;
  const Index wanted = std::min(count, most);
  for (Index k = 0; k < wanted; ++k) kept.push_back(wanted < 2 ? 0 : k * (count - 1) / (wanted - 1));
  return kept;
}

LoadFields compressed(const MatrixXd& states, Index most_modes) {
  FieldModes modes(most_modes);
  for (Index k = 0; k < states.cols(); ++k) modes.add(states.col(k));
  FieldModes::Result result = modes.take();
  return {std::move(result.modes), std::move(result.coefficients)};
}

CommonFields in_common(const std::vector<const LoadFields*>& loads, Index size, Index most_modes) {
  FieldModes modes(most_modes);
  for (const LoadFields* load : loads)
    for (Index k = 0; k < load->coefficients.cols(); ++k) modes.add(load->modes * load->coefficients.col(k));
  FieldModes::Result result = modes.take();
  CommonFields common{std::move(result.modes), {}};
  if (common.modes.cols() == 0) common.modes.resize(size, 0);
  Index first = 0;
  for (const LoadFields* load : loads) {
    const Index times = load->coefficients.cols();
    common.coefficients.push_back(result.coefficients.middleCols(first, times));
    first += times;
  }
  return common;
}

}  // namespace thermotwin::solver
