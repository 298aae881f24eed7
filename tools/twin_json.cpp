// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/twin_json.h"

#include <nlohmann/json.hpp>

#include <cmath>

#include "core/text.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "solver/export/scene_file.h"
#include "tools/guard_words.h"
#include "tools/reduced_scene.h"

namespace thermotwin::tools {
namespace {

constexpr double details_every_s = 1.0;

/// So that a line stays short.
double rounded(double value, double parts) { return std::round(value * parts) / parts; }

}  // namespace

TwinJson::TwinJson(const reduction::ReducedModel& model, const compensation::OnlineTwin& twin,
                   const std::filesystem::path& model_file)
    : model_(model),
      twin_(twin),
      poses_(mesh::workspace_poses(model.machine)) {
  for (const std::string& axis : twin.axes()) axes_.push_back(core::lower(axis));
  const auto scene = solver::read_scene(model_file.parent_path() / "scene.bin", model.machine, scene_stamp(model));
  if (scene && scene->turn.rows() == model.system.order()) turn_ = scene->turn;
  if (std::isnan(twin.time())) return;
  last_pose_ = twin.pose();  // of the state that it goes on from
  last_time_ = twin.time();
}

std::string TwinJson::line(const compensation::Offsets& offsets, std::string_view status, bool state_unwritten) {
  nlohmann::json json = {{"time_s", offsets.time}, {"status", status}, {"guard", text_of(twin_.guard())}};
  if (state_unwritten) json["state"] = "unwritten";
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    json["offset_um"][axes_[i]] = offsets.offset_um[i];
    json["std_um"][axes_[i]] = offsets.std_um[i];
  }
  const mesh::Pose now = twin_.pose();
  const bool first = last_pose_.size() == 0;
  json["motion_um"] = first ? 0.0 : twin_.limits().motion_um(last_pose_, now, offsets.time - last_time_);
  json["wanted_um"] = twin_.wanted_um();
  // Before the first row that could be read, the time is nobody's.
  if (std::isnan(twin_.time())) return json.dump();
  last_pose_ = now;
  last_time_ = offsets.time;
  if (offsets.time < next_details_) return json.dump();
  next_details_ = offsets.time + details_every_s;
  const Eigen::VectorXd predicted = twin_.predicted_sensors_C(), readings = twin_.readings_C();
  const std::vector<std::string> faults = twin_.sensor_faults();
  json["axes"] = axes_;
  json["limits"] = {{"largest_um", twin_.limits().largest_um}, {"rate_um_s", twin_.limits().rate_um_s}};
  json["sensors"] = nlohmann::json::array();
  for (std::size_t s = 0; s < faults.size(); ++s) {
    json["sensors"].push_back({{"id", model_.machine.sensors[s].id},
                               {"reading_C", rounded(readings[s], 1e3)},
                               {"predicted_C", rounded(predicted[s], 1e3)},
                               {"fault", faults[s]}});
  }
  for (const mesh::Pose& pose : poses_) {
    const solver::TcpError error = twin_.tcp(pose);
    for (int i = 0; i < 3; ++i) json["errors_um"].push_back(rounded(error.error[i] / core::units::um, 1e3));
  }
  if (turn_.size() > 0) {
    const Eigen::VectorXd modes = turn_.transpose() * twin_.state();
    for (const double value : modes) json["modes"].push_back(value);
  }
  return json.dump();
}

}  // namespace thermotwin::tools
