// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Effects on the full model with a footprint of their own, which is not that of the diagnosis: heat spread by
// five minutes of conduction, films uneven over their surface, sources that no machine.toml has.

#include <Eigen/Core>

#include <vector>

#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "specimen.h"

namespace thermotwin::hidden {

/// (size) Between 0.8 and 1.2 over the machine, a wave along its longest diagonal.
Eigen::VectorXd unevenness(const solver::FullModel& full, double phase);

class OwnFootprint {
public:
  /// @param rows    of the load: what differs between right and wrong in some of them gets a footprint of its own
  /// @param uneven  (size) of films
  OwnFootprint(const solver::FullModel& full, const solver::OperatingModel& right, const solver::OperatingModel& wrong,
               const std::vector<Eigen::VectorXd>& rows, const std::vector<const Truth*>& spots,
               const Eigen::VectorXd& uneven);

  /// The machine's matrices with the effect's own inputs and terms behind its own.
  const solver::ThermalSystem& system() const { return thermal_; }
  void add_capacity(const solver::SparseMatrix& more);
  /// Of system(): as right, and what the wrong machine changes at its own place.
  /// @param size    of the effect at this time, 1 in the mean
  /// @param spot_W  (spots)
  solver::Coefficients coefficients(const solver::Coefficients& right, const solver::Coefficients& wrong, double size,
                                    const Eigen::VectorXd& spot_W) const;

private:
  solver::ThermalSystem thermal_;
  Eigen::Index terms_, inputs_, spots_;                     ///< the machine's own, sources that it has not
  std::vector<Eigen::Index> input_of_source_;               ///< (inputs) its spread twin or itself
  std::vector<Eigen::Index> term_of_film_, input_of_film_;  ///< (terms) its uneven twin or itself, the twin's input
};

}  // namespace thermotwin::hidden
