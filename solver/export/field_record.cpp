// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/field_record.h"

#include <algorithm>

namespace thermotwin::solver {

using Eigen::Index;

std::vector<Index> thinned(Index count, Index most) {
  std::vector<Index> kept;
  const Index wanted = std::min(count, most);
  for (Index k = 0; k < wanted; ++k) kept.push_back(wanted < 2 ? 0 : k * (count - 1) / (wanted - 1));
  return kept;
}

void FieldRecord::add(const std::string& load, Index output, Index of, const Eigen::Ref<const Eigen::VectorXd>& state) {
  const std::vector<Index> kept = thinned(of, most_times);
  if (std::binary_search(kept.begin(), kept.end(), output)) numbers_[load][output] = modes_.add(state);
}

void FieldRecord::close() { result_ = modes_.take(); }

Eigen::MatrixXd FieldRecord::coefficients(const std::string& load, Index of) const {
  const auto found = numbers_.find(load);
  const std::vector<Index> kept = thinned(of, most_times);
  Eigen::MatrixXd values(result_.modes.cols(), std::ssize(kept));
  for (std::size_t k = 0; k < kept.size(); ++k) {
    if (found == numbers_.end() || !found->second.contains(kept[k])) return {values.rows(), 0};
    values.col(k) = result_.coefficients.col(found->second.at(kept[k]));
  }
  return values;
}

}  // namespace thermotwin::solver
