// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/model_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "compensation/online/offset_limits.h"
#include "compensation/online/output_map.h"
#include "core/error.h"
#include "core/units.h"
#include "reduction/basis/projection.h"

namespace thermotwin::compensation {
namespace {

/// Largest RMS over the workspace of the difference of both models' offsets, um.
double difference_um(const reduction::ReducedModel& whole, const reduction::ReducedModel& small) {
  const OutputMap of_whole(whole), of_small(small);
  const std::vector<Eigen::VectorXd> states = worked_states(whole), small_states = worked_states(small);
  double worst = 0.0;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const Eigen::MatrixXd apart = of_whole.workspace_offsets(states[k]) - of_small.workspace_offsets(small_states[k]);
    if (apart.size() > 0 && apart.allFinite())
      worst = std::max(worst, std::sqrt(apart.colwise().squaredNorm().mean()) / core::units::um);
  }
  return worst;
}

}  // namespace

reduction::ReducedModel model_of_order(reduction::ReducedModel model, Eigen::Index order) {
  const Eigen::Index own = model.system.order();
  if (order == 0 || order == own) return model;
  if (order < 1 || order > own) {
    throw core::InputError("--order", fmt::format("{}", order),
                           fmt::format("1 to {}, the order of the model; a larger one needs `reduce --order`", own));
  }
  reduction::ReducedModel small = reduction::truncated(model, order);
  double stated_um = 0.0;
  for (const reduction::ReductionErrors& error : model.errors) stated_um = std::max(stated_um, error.rms_um);
  reduction::ReductionErrors of_order;
  of_order.load = fmt::format("order {} of {}", order, own);
  of_order.rms_um = std::hypot(stated_um, difference_um(model, small));
  small.errors.push_back(std::move(of_order));
  return small;
}

}  // namespace thermotwin::compensation
