// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What `thermotwin campaign` leaves of a load (inputs.csv, sensors.csv, tcp.csv), as inputs and
// outputs of a linear system: heat of the sources by the laws of machine.toml and temperatures of the
// surroundings come in, the TCP error at the campaign's poses and the sensors go out.

#include <Eigen/Core>

#include <filesystem>
#include <string>
#include <vector>

#include "core/table.h"
#include "solver/operation/layout.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::reduction {

/// Columns of a pose in tcp.csv that are outputs: dx, dy, dz, ra, rb, rc.
inline constexpr Eigen::Index values_of_pose = 6;

struct CampaignTables {
  std::string load;
  core::Table inputs, sensors, tcp;
};
/// In a load's folder: the tables are a reduced model's, and this says which. The full model's have `done` instead.
constexpr const char* made_by_file = "made_by.txt";

/// @param folder  of the campaign; the load's tables are in its folder of that name
/// @throws InputError: a missing table, times that disagree, tables that a reduced model made
CampaignTables read_campaign_tables(const std::filesystem::path& folder, const std::string& load);

/// Inputs that a row of channels means, each with its unit in its name:
///   `<source>.power_W`; `<ambient>.T_K` above the reference; for a film that a state switches to another
///   ambient, `<state> x (<ambient>.T_K - air.T_K)`; `<ambient>.gradient_K_m`.
/// What p(t) does to the equation beside that (films that speeds change, coolants that stop) is no input.
class CampaignInputs {
public:
  explicit CampaignInputs(const mesh::Machine& machine);

  const std::vector<std::string>& names() const { return names_; }
  /// Whether the input is a temperature that is the machine's own where all is at rest and even.
  const std::vector<bool>& even() const { return even_; }
  /// (times x inputs), row i: means over the interval that ends with time i
  Eigen::MatrixXd of(const CampaignTables& tables) const;
  /// Uniform temperature at the start, K above the reference: the median of the sensors' first readings.
  double initial_K(const CampaignTables& tables) const;

private:
  struct Switched {
    int state, ambient;
  };
  mesh::Machine machine_;
  solver::Layout layout_;
  solver::OperatingModel operating_;
  std::vector<int> ambients_, gradients_, gradient_channels_;
  std::vector<Switched> switched_;
  int air_ = -1;
  std::vector<std::string> names_;
  std::vector<bool> even_;
};

/// Outputs of the load, (times x 6 poses + sensors): dx_um .. rc_um_per_m of each pose in order, sensors in
/// K above the reference.
Eigen::MatrixXd campaign_outputs(const CampaignTables& tables, double reference_C);
std::vector<std::string> campaign_output_names(const mesh::Machine& machine, const CampaignTables& tables);
/// Number of poses: rows of the first time. @throws InputError for another number of rows than times x poses
Eigen::Index campaign_poses(const CampaignTables& tables);

}  // namespace thermotwin::reduction
