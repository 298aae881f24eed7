// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a channel may be off by since the mesh is no finer: as a share of its own change, from the model file, from an
// option, or assumed.

#include <optional>
#include <string>

#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/record/observations.h"
#include "mesh/machine/machine.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::diagnosis {

class MeshAllowance {
public:
  /// An option comes before the estimate, the estimate before what is assumed. @param machine  must outlive it
  MeshAllowance(const mesh::Machine& machine, const std::optional<reduction::MeshError>& estimate,
                const DiagnoseOptions& options);

  double of(const ObservedChannel& channel) const;
  double of_sensor(const std::string& sensor) const;
  /// @param quantity  dx dy dz ra rb rc; of another one (X0C ...) the largest of its unit counts
  double of_displacement(const std::string& quantity) const;
  /// The largest share of all sensors and directions.
  double largest() const;
  /// Whether a direction's share is one of the motion in all three directions, as the estimate's is. What is assumed or
  /// stated is a share of the direction's own change.
  bool is_of_whole_motion() const { return estimate_ && !given_displacement_; }
  /// One sentence for the notes of a diagnosis.
  std::string sentence() const;

  /// A mesh study covers neither the time steps nor the reduction nor what two programs do differently on one mesh.
  static constexpr double least_temperature = 0.004, least_displacement = 0.007;

private:
  const mesh::Machine& machine_;
  std::optional<reduction::MeshError> estimate_;
  double displacement_, temperature_;  ///< where there is no estimate
  bool given_displacement_, given_temperature_;
};

}  // namespace thermotwin::diagnosis
