// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A row's answer as a line of JSON, for programs. docs/reference/result_files.md lists the keys.

#include <Eigen/Core>

#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "compensation/control/online_twin.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::tools {

class TwinJson {
public:
  /// @param model, twin  must outlive it  @param model_file  scene.bin beside it has the modes of the skin, if any
  TwinJson(const reduction::ReducedModel& model, const compensation::OnlineTwin& twin,
           const std::filesystem::path& model_file);

  /// @param status  with the names of what failed  @param state_unwritten  the state could not be saved
  std::string line(const compensation::Offsets& offsets, std::string_view status, bool state_unwritten = false);

private:
  const reduction::ReducedModel& model_;
  const compensation::OnlineTwin& twin_;
  std::vector<std::string> axes_;  ///< of the offsets, as columns name them
  std::vector<mesh::Pose> poses_;  ///< of the workspace
  Eigen::MatrixXd turn_;           ///< (order x modes); empty: no scene
  mesh::Pose last_pose_;           ///< of the row before; empty: none
  double last_time_ = 0;
  double next_details_ = -std::numeric_limits<double>::infinity();
};

}  // namespace thermotwin::tools
