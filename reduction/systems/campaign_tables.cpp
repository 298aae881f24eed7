// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/campaign_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/error.h"
#include "core/file.h"
#include "core/statistics.h"
#include "mesh/machine_mesh.h"
#include "solver/campaign/simulation.h"
#include "solver/operation/layout.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr const char* errors_of_pose[] = {"dx_um", "dy_um", "dz_um", "ra_um_per_m", "rb_um_per_m", "rc_um_per_m"};
static_assert(std::size(errors_of_pose) == values_of_pose);

/// Times of a table with several rows each.
VectorXd times_of(const core::Table& table, Index rows_each) {
  const VectorXd all = table.column("time_s");
  VectorXd times(all.size() / rows_each);
  for (Index i = 0; i < times.size(); ++i) times(i) = all(i * rows_each);
  return times;
}

/// Ambients that act at all times, not only where a state lets them.
std::set<std::string> always_there(const mesh::Machine& machine) {
  std::set<std::string> names;
  for (const mesh::FilmSpec& film : machine.films) {
    if (film.state.empty()) names.insert(film.ambient);
    if (film.emissivity.value > 0.0 && film.state.empty())
      names.insert(film.surroundings.empty() ? film.ambient : film.surroundings);
  }
  for (const mesh::JointSpec& joint : machine.joints) names.insert(joint.ambient);
  for (const mesh::VolumeSpec& volume : machine.volumes)
    for (const mesh::VolumeExchange& exchange : volume.exchanges) names.insert(exchange.with);
  return names;
}

}  // namespace

CampaignTables read_campaign_tables(const std::filesystem::path& folder, const std::string& load) {
  CampaignTables tables{load, {}, {}, {}};
  const std::filesystem::path of_load = folder / load;
  if (std::filesystem::exists(of_load / made_by_file)) {
    const std::string maker = core::read_file(of_load / made_by_file);
    throw core::InputError(of_load.string(), "tables made by the " + maker.substr(0, maker.find('\n')),
                           "the full model's, as `thermotwin campaign CASE` leaves them");
  }
  for (auto [name, table] :
       {std::pair{"inputs.csv", &tables.inputs}, {"sensors.csv", &tables.sensors}, {"tcp.csv", &tables.tcp}}) {
    if (!std::filesystem::exists(of_load / name)) {
      throw core::InputError((of_load / name).string(), "no such file",
                             "the tables of every load of case.toml, as `thermotwin campaign CASE` leaves them");
    }
    *table = core::read_csv(of_load / name);
  }
  core::require_time_column(tables.inputs);
  core::require_time_column(tables.sensors);
  const VectorXd time = tables.inputs.column("time_s"), sensed = tables.sensors.column("time_s"),
                 tcp = times_of(tables.tcp, campaign_poses(tables));
  const auto same = [&](const VectorXd& other) {
    return other.size() == time.size() &&
           (other - time).cwiseAbs().maxCoeff() <= 1e-6 * (1.0 + time.cwiseAbs().maxCoeff());
  };
  if (!same(sensed) || !same(tcp))
    throw core::InputError(of_load.string(), "tables of other times than inputs.csv", "tables of one run");
  if (time.size() < 2) throw core::InputError((of_load / "inputs.csv").string(), "one time", "two or more");
  return tables;
}

Index campaign_poses(const CampaignTables& tables) {
  const VectorXd time = tables.tcp.column("time_s");
  Index poses = 0;
  while (poses < time.size() && time(poses) == time(0)) ++poses;
  bool whole = poses > 0 && time.size() % poses == 0;
  for (Index i = 0; whole && i < time.size(); ++i) whole = time(i) == time(i / poses * poses);
  if (!whole) {
    throw core::InputError(tables.tcp.source, "times with another number of rows than the first",
                           "a row for each pose at every time");
  }
  return poses;
}

CampaignInputs::CampaignInputs(const mesh::Machine& machine)
    : machine_(machine),
      layout_(solver::make_layout(
          machine, std::vector<solver::JointGrid>(machine.joints.size(), solver::JointGrid{-1, false, {0.0}}))),
      operating_(machine_, layout_),
      air_(machine.ambient_index("air")) {
  for (const mesh::SourceSpec& source : machine.sources) {
    names_.push_back(source.id + ".power_W");
    even_.push_back(false);
  }
  const std::set<std::string> always = always_there(machine);
  for (std::size_t i = 0; i < machine.ambients.size(); ++i) {
    if (!always.contains(machine.ambients[i].id)) continue;
    ambients_.push_back(i);
    names_.push_back(machine.ambients[i].id + ".T_K");
    even_.push_back(true);
  }
  std::set<std::string> seen;
  for (const mesh::FilmSpec& film : machine.films) {
    const int ambient = machine.ambient_index(film.ambient),
              state = film.state.empty() ? -1 : operating_.channels().index(film.state);
    if (state < 0 || ambient < 0 || ambient == air_) continue;
    const std::string name = fmt::format("{} x ({}.T_K{})", film.state, film.ambient,
                                         air_ >= 0 ? " - " + machine.ambients[air_].id + ".T_K" : "");
    if (!seen.insert(name).second) continue;
    switched_.push_back({state, ambient});
    names_.push_back(name);
    even_.push_back(false);
  }
  for (std::size_t i = 0; i < machine.ambients.size(); ++i) {
    if (!machine.ambients[i].has_gradient) continue;
    gradients_.push_back(i);
    gradient_channels_.push_back(operating_.channels().index(machine.ambients[i].id + ".gradient_K_m"));
    names_.push_back(machine.ambients[i].id + ".gradient_K_m");
    even_.push_back(false);
  }
}

MatrixXd CampaignInputs::of(const CampaignTables& tables) const {
  const solver::Channels& channels = operating_.channels();
  std::vector<VectorXd> columns;
  for (const std::string& name : channels.names()) columns.push_back(tables.inputs.column(name));
  MatrixXd all(tables.inputs.rows(), std::ssize(names_));
  VectorXd row(channels.size());
  for (Index i = 0; i < all.rows(); ++i) {
    for (Index k = 0; k < row.size(); ++k) row(k) = columns[k](i);
    Index at = machine_.sources.empty() ? 0 : std::ssize(machine_.sources);
    all.row(i).head(at) = operating_.source_powers(row).transpose();
    for (const int ambient : ambients_) all(i, at++) = operating_.ambient_K(ambient, row);
    for (const Switched& film : switched_) {
      all(i, at++) = row(film.state) *
                     (operating_.ambient_K(film.ambient, row) - (air_ >= 0 ? operating_.ambient_K(air_, row) : 0.0));
    }
    for (std::size_t k = 0; k < gradients_.size(); ++k) {
      const double given = row(gradient_channels_[k]);
      all(i, at++) = std::isnan(given) ? machine_.ambients[gradients_[k]].gradient.value : given;
    }
  }
  for (Index k = 0; k < all.cols(); ++k) {
    if (!all.col(k).allFinite()) {
      throw core::InputError(tables.inputs.source, "a missing value in the inputs of " + names_[k],
                             "numbers in every row");
    }
  }
  return all;
}

double CampaignInputs::initial_K(const CampaignTables& tables) const {
  std::vector<double> readings;
  for (const mesh::SensorSpec& sensor : machine_.sensors) {
    const double value = tables.sensors.column(sensor.id + "_C")(0);
    if (std::isfinite(value)) readings.push_back(value - machine_.reference_C - sensor.offset);
  }
  if (readings.empty()) {
    throw core::InputError(tables.sensors.source, "no reading in the first row",
                           "temperatures of sensors, which give the initial state");
  }
  return core::median(std::move(readings));
}

MatrixXd campaign_outputs(const CampaignTables& tables, double reference_C) {
  const Index poses = campaign_poses(tables), times = tables.sensors.rows(), sensors = tables.sensors.values.cols() - 1;
  MatrixXd outputs(times, values_of_pose * poses + sensors);
  for (Index v = 0; v < values_of_pose; ++v) {
    const VectorXd column = tables.tcp.column(errors_of_pose[v]);
    for (Index i = 0; i < column.size(); ++i) outputs(i / poses, (i % poses) * values_of_pose + v) = column(i);
  }
  outputs.rightCols(sensors) = tables.sensors.values.rightCols(sensors).array() - reference_C;
  if (!outputs.allFinite())
    throw core::InputError(tables.tcp.source + " or its sensors.csv", "a missing value", "numbers in every cell");
  return outputs;
}

std::vector<std::string> campaign_output_names(const mesh::Machine& machine, const CampaignTables& tables) {
  std::vector<std::string> names;
  const std::vector<std::string> axes = mesh::pose_columns(machine);
  for (Index pose = 0; pose < campaign_poses(tables); ++pose) {
    std::string place;
    for (const std::string& axis : axes)
      place += fmt::format("{}{}={:.6g}", place.empty() ? "" : ",", axis, tables.tcp.column(axis)(pose));
    for (const char* value : errors_of_pose) names.push_back(fmt::format("{} at {}", value, place));
  }
  for (Index s = 1; s < tables.sensors.values.cols(); ++s) {
    std::string name = tables.sensors.columns[s];
    if (name.ends_with("_C")) name.replace(name.size() - 2, 2, "_K");
    names.push_back(name);
  }
  return names;
}

}  // namespace thermotwin::reduction
