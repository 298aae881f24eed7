// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/study/chosen_sensors.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <utility>

#include "compensation/online/axis_reach.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/units.h"
#include "study/placement/model_errors.h"
#include "study/placement/placed_model.h"
#include "study/placement/responses.h"

namespace thermotwin::tools {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Translations at the poses, um per K of state.
MatrixXd translation_rows(const reduction::ReducedModel& model, const std::vector<mesh::Pose>& poses) {
  const MatrixXd all = reduction::value_rows(model, poses);
  MatrixXd rows(3 * std::ssize(poses), all.cols());
  for (Index p = 0; p < std::ssize(poses); ++p) rows.middleRows<3>(3 * p) = all.middleRows<3>(18 * p);
  return rows;
}

/// Offsets remove an error only in directions that a linear axis moves: rows of 3 a pose keep that part. A machine
/// without linear axes keeps all.
class Reach {
public:
  Reach(const mesh::Machine& machine, const std::vector<mesh::Pose>& poses) : moves_(has_linear_axis(machine)) {
    for (const mesh::Pose& pose : poses) reaches_.emplace_back(machine, pose);
  }

  bool moves() const { return moves_; }
  /// "z (dz)": what no axis moves; empty: nothing, or there is no axis.
  std::string unmoved() const { return moves_ && !reaches_.empty() ? reaches_.front().unmoved_directions() : ""; }
  template <class Rows>
  void keep(Eigen::MatrixBase<Rows>& rows) const {
    if (!moves_) return;
    for (std::size_t p = 0; p < reaches_.size(); ++p) {
      for (Index c = 0; c < rows.cols(); ++c) {
        const Eigen::Vector3d all = rows.template block<3, 1>(3 * p, c);
        rows.template block<3, 1>(3 * p, c) -= reaches_[p].unmoved(all);
      }
    }
  }

private:
  bool moves_ = false;
  std::vector<compensation::AxisReach> reaches_;
};

/// The places and then the case's own sensors, as a second mesh reads them.
std::vector<mesh::SensorSpec> read_sensors(const mesh::Machine& machine, const std::vector<study::Place>& places) {
  std::vector<mesh::SensorSpec> sensors = study::placed_sensors(machine, places);
  sensors.resize(places.size());  // without those of chillers, which are among the case's own
  for (mesh::SensorSpec& sensor : sensors) sensor.id = "place " + sensor.id;
  for (mesh::SensorSpec own : machine.sensors) {
    own.offset = own.drift = own.lag = own.air_share = 0.0;
    sensors.push_back(std::move(own));
  }
  return sensors;
}

study::PlaceRules rules_of(const StudySensorsOptions& options) {
  study::PlaceRules rules;
  rules.spacing = options.spacing_mm * core::units::mm;
  rules.bodies = options.bodies;
  rules.without = options.without;
  rules.on_contacts = options.on_contacts;
  rules.on_rotating = options.on_rotating;
  return rules;
}

/// In one sentence; empty: all.
std::string directions(const Reach& reach) {
  if (!reach.moves()) return "No linear axis moves the tool: the prediction's error counts in all directions.";
  if (reach.unmoved().empty()) return "";
  return "No linear axis moves " + reach.unmoved() + ": errors there stay and do not count.";
}

/// The filter corrects at stored rows only. @param used  time of the first correction, s
void warn_of_rows(const solver::LoadProgram& load, double every_s, double used) {
  if (std::abs(used - every_s) <= 0.01 * every_s) return;
  if (every_s > load.duration()) {
    core::warn(fmt::format("--every {:.4g}: '{}' lasts {:.4g} min, so the filter corrects once, at its end",
                           every_s / core::units::minute, load.name(), load.duration() / core::units::minute));
  } else {
    core::warn(fmt::format("--every {:.4g}: '{}' has a row every {:.4g} min, so the filter corrects every {:.4g} min",
                           every_s / core::units::minute, load.name(), load.output_interval() / core::units::minute,
                           used / core::units::minute));
  }
}

int wanted_count(const StudySensorsOptions& options, Index own) {
  return options.count > 0 ? options.count : static_cast<int>(own);
}

}  // namespace

std::vector<study::Place> sensor_places(const StudySensorsOptions& options, const mesh::MachineMesh& mesh) {
  std::vector<study::Place> places = study::sensor_places(mesh, rules_of(options));
  const int count = wanted_count(options, std::ssize(mesh.machine.sensors));
  if (count < 1 || count > std::ssize(places)) {
    throw core::InputError("--count", std::to_string(count),
                           fmt::format("1 to {}: the places that the rules leave", places.size()));
  }
  return places;
}

ChosenSensors chosen_sensors(const StudySensorsOptions& options, const solver::Case& machine_case,
                             const solver::FullModel& full, const reduction::ReducedModel& model, const MatrixXd& basis,
                             const std::vector<solver::LoadProgram>& loads) {
  ChosenSensors choice;
  choice.places = sensor_places(options, full.mesh);
  const Index places = std::ssize(choice.places), own = std::ssize(model.machine.sensors);
  MatrixXd rows(places + own, model.system.order());
  for (Index i = 0; i < places; ++i) rows.row(i) = basis.row(choice.places[i].node).head(rows.cols());
  rows.bottomRows(own) = model.system.sensors.topRows(own);
  for (Index i = 0; i < own; ++i) choice.own.push_back(static_cast<int>(places + i));

  const std::vector<study::UncertainParameter> parameters = study::uncertain_parameters(model);
  std::vector<study::LoadResponses> along;
  const double every_s = options.every_min * core::units::minute;
  for (const solver::LoadProgram& load : loads) {
    along.push_back(study::responses(model, parameters, load, every_s));
    warn_of_rows(load, every_s, along.back().times.front());
  }
  study::ChoiceOptions how;
  how.noise_K = options.noise_K;
  how.bias_K = options.bias_K;
  how.exchanges = options.exchanges;
  how.any_loss = options.any_loss;
  how.choosable = places;
  const std::vector<mesh::Pose> poses = mesh::workspace_poses(model.machine);
  const Reach reach(model.machine, poses);
  choice.directions = directions(reach);
  MatrixXd tcp = translation_rows(model, poses);
  std::vector<study::ModelErrors> errors =
      study::model_errors(machine_case, full.mesh, model, read_sensors(model.machine, choice.places), rows, tcp, loads,
                          along, options.out / "cache", choice.second_mesh);
  reach.keep(tcp);
  for (study::ModelErrors& error : errors)
    for (study::MeshDifference& mesh : error.meshes)
      for (Eigen::VectorXd& at : mesh.tcp_um) reach.keep(at);
  const study::SensorChoice judge(along, parameters, rows, tcp, how, errors);
  const int count = wanted_count(options, own);
  const std::vector<int> greedy = judge.greedy(count);
  for (int k = 1; k <= count; ++k) {
    const std::vector<int> first(greedy.begin(), greedy.begin() + k);
    choice.curve.push_back({k, judge.left_um(first), judge.left_after_loss_um(first)});
  }
  choice.chosen = judge.chosen(greedy);
  choice.without_left = judge.left({});
  choice.own_left = judge.left(choice.own);
  choice.chosen_left = judge.left(choice.chosen);
  choice.without_um = choice.without_left.all_um();
  choice.own_um = choice.own_left.all_um();
  choice.own_after_loss_um = own > 0 ? judge.left_after_loss_um(choice.own) : choice.without_um;
  choice.chosen_um = choice.chosen_left.all_um();
  choice.chosen_after_loss_um = judge.left_after_loss_um(choice.chosen);
  choice.curve.back() = {count, choice.chosen_um, choice.chosen_after_loss_um};
  for (std::size_t lost = 0; lost < choice.chosen.size(); ++lost) {
    std::vector<int> rest = choice.chosen;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(lost));
    choice.without_one_um.push_back(judge.left_um(rest));
  }
  return choice;
}

}  // namespace thermotwin::tools
