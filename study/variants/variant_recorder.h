// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Records the TCP error and the sensors of a block of variants while it runs. The error at a pose is linear in the
// temperatures; its six rows serve all variants in one product.

#include <Eigen/Core>

#include <vector>

#include "core/binary.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/simulation.h"
#include "study/variants/variant_unit.h"

namespace thermotwin::study {

/// @param rows  solver::stacked_rows at the poses  @return (6 poses x size) dx dy dz in um, ra rb rc in um/m per K
Eigen::MatrixXd error_rows(const mesh::Machine& machine, const std::vector<mesh::Pose>& poses,
                           const Eigen::MatrixXd& rows);

class VariantRecorder {
public:
  /// All must outlive the recorder. @param outputs  number of output times
  VariantRecorder(const mesh::Machine& machine, const std::vector<mesh::Pose>& poses, const Eigen::MatrixXd& rows,
                  std::size_t variants, std::size_t outputs);

  /// To be called for each variant in order at each output.
  void add(const solver::OutputState& output);
  std::vector<VariantTables> take();

  void save(core::BinaryWriter& out) const;
  void load(core::BinaryReader& in);

private:
  const mesh::Machine& machine_;
  const std::vector<mesh::Pose>& poses_;
  const Eigen::MatrixXd& rows_;
  Eigen::MatrixXd states_;  ///< (size x variants) of the present output
  std::vector<VariantTables> tables_;
  Eigen::Index filled_ = 0;
};

}  // namespace thermotwin::study
