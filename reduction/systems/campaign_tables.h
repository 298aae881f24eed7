// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The tables that `thermotwin campaign` writes for a load (inputs.csv, sensors.csv, tcp.csv), as inputs and outputs of
// a linear system. Inputs are the heat of the sources by the laws of machine.toml and the ambient temperatures. Outputs
// are the TCP error at the campaign's poses and the sensor temperatures.

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
/// File in a load's folder that names the reduced model that made the tables. The full model writes `done` instead.
constexpr const char* made_by_file = "made_by.txt";

/// @param folder  of the campaign; the load's tables are in its folder of that name
/// @throws InputError: a missing table, times that disagree, tables that a reduced model made
CampaignTables read_campaign_tables(const std::filesystem::path& folder, const std::string& load);

/// Inputs computed from a row of channels, each with its unit in its name:
///   SOURCE.power_W; AMBIENT.T_K above the reference, for an ambient that always acts; for a film that a state switches
///   to another ambient, "STATE x (AMBIENT.T_K - air.T_K)"; AMBIENT.gradient_K_m.
/// Other effects of the coefficients p(t), such as films that follow speeds or coolants that stop, are not inputs.
class CampaignInputs {
public:
  explicit CampaignInputs(const mesh::Machine& machine);

  const std::vector<std::string>& names() const { return names_; }
  /// Per input: whether it is an ambient temperature, which equals the machine's when all is at rest and uniform.
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

/// Outputs of the load, (times x (6 poses + sensors)): dx_um .. rc_um_per_m of each pose in order, sensors in
/// K above the reference.
Eigen::MatrixXd campaign_outputs(const CampaignTables& tables, double reference_C);
std::vector<std::string> campaign_output_names(const mesh::Machine& machine, const CampaignTables& tables);
/// Number of poses: rows of the first time. @throws InputError for another number of rows than times x poses
Eigen::Index campaign_poses(const CampaignTables& tables);

}  // namespace thermotwin::reduction
