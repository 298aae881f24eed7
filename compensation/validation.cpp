// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "compensation/compensator.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/text.h"

namespace thermotwin::compensation {
namespace {

/// The three displacement columns of one pose.
struct PoseColumns {
  std::string text;
  mesh::Pose pose;
  std::array<Eigen::Index, 3> columns{-1, -1, -1};
};

std::vector<PoseColumns> pose_columns(const Measurement& measurement, const mesh::Machine& machine) {
  std::vector<PoseColumns> poses;
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.kind != ChannelKind::displacement) continue;
    const std::string axes = "xyz";
    const std::size_t axis = channel.quantity.size() == 2 && channel.quantity[0] == 'd'
                                 ? axes.find(channel.quantity[1])
                                 : std::string::npos;
    if (axis == std::string::npos) continue;
    auto found = std::find_if(poses.begin(), poses.end(),
                              [&](const PoseColumns& p) { return p.text == channel.pose_text; });
    if (found == poses.end()) {
      poses.push_back({channel.pose_text, mesh::parse_pose(machine, channel.pose_text, channel.id), {-1, -1, -1}});
      found = std::prev(poses.end());
    }
    found->columns[axis] = channel.column;
  }
  std::erase_if(poses, [](const PoseColumns& p) {
    return std::any_of(p.columns.begin(), p.columns.end(), [](Eigen::Index c) { return c < 0; });
  });
  return poses;
}

/// Predicted TCP translations (um) per time and pose, in the rows of the measurement.
std::vector<Eigen::Matrix3Xd> predict(const Measurement& measurement, const mesh::Machine& machine,
                                      const reduction::ReducedModel& model, bool use_sensors,
                                      const std::vector<PoseColumns>& poses) {
  CompensatorOptions options;
  options.use_sensors = use_sensors;
  options.start_from_sensors = use_sensors;
  Compensator compensator(model, options);
  const Eigen::MatrixXd rows = channel_rows(measurement, compensator.channels());
  std::vector<Eigen::Index> sensor_column(machine.sensors.size(), -1);
  for (const MeasuredChannel& channel : measurement.channels)
    if (const int sensor = machine.sensor_index(channel.sensor); sensor >= 0)
      sensor_column[static_cast<std::size_t>(sensor)] = channel.column;

  std::vector<Eigen::Matrix3Xd> predicted(poses.size(), Eigen::Matrix3Xd(3, measurement.data.rows()));
  Eigen::VectorXd sensors = Eigen::VectorXd::Constant(
      static_cast<Eigen::Index>(machine.sensors.size()), solver::not_given);
  for (Eigen::Index i = 0; i < measurement.data.rows(); ++i) {
    for (std::size_t s = 0; s < sensor_column.size(); ++s)
      if (sensor_column[s] >= 0)
        sensors(static_cast<Eigen::Index>(s)) = measurement.data.values(i, sensor_column[s]);
    compensator.step(measurement.data.values(i, 0), rows.row(i).transpose(),
                     use_sensors ? sensors : Eigen::VectorXd());
    for (std::size_t p = 0; p < poses.size(); ++p)
      predicted[p].col(i) = 1e6 * compensator.tcp(poses[p].pose).error.head<3>();
  }
  return predicted;
}

}  // namespace

std::vector<ValidationRow> judge_compensation(const Measurement& measurement,
                                              const mesh::Machine& machine,
                                              const reduction::ReducedModel& model,
                                              const std::string& load, int draw) {
  const std::vector<PoseColumns> poses = pose_columns(measurement, machine);
  const auto without = predict(measurement, machine, model, false, poses);
  const auto with = predict(measurement, machine, model, true, poses);
  std::vector<ValidationRow> rows;
  for (std::size_t p = 0; p < poses.size(); ++p) {
    ValidationRow row;
    row.load = load;
    row.draw = draw;
    row.pose = poses[p].text;
    double before = 0, model_only = 0, sensors = 0;
    Eigen::Index count = 0;
    for (Eigen::Index i = 0; i < measurement.data.rows(); ++i) {
      Eigen::Vector3d measured;
      for (int k = 0; k < 3; ++k) measured(k) = measurement.data.values(i, poses[p].columns[static_cast<std::size_t>(k)]);
      if (!measured.allFinite()) continue;
      ++count;
      const double left = (measured - with[p].col(i)).norm();
      before += measured.squaredNorm();
      model_only += (measured - without[p].col(i)).squaredNorm();
      sensors += left * left;
      row.largest_before_um = std::max(row.largest_before_um, measured.norm());
      row.largest_sensors_um = std::max(row.largest_sensors_um, left);
    }
    if (count == 0) continue;
    row.rms_before_um = std::sqrt(before / static_cast<double>(count));
    row.rms_model_um = std::sqrt(model_only / static_cast<double>(count));
    row.rms_sensors_um = std::sqrt(sensors / static_cast<double>(count));
    rows.push_back(row);
  }
  return rows;
}

Validation validate_online(const solver::Case& machine_case, const reduction::ReducedModel& model,
                           const ValidationOptions& options) {
  if (machine_case.check_points.empty())
    throw core::InputError(machine_case.folder.string() + "/case.toml check_points", "no poses",
                           "at least one pose off the grid, to judge the compensation at");
  std::vector<solver::LoadProgram> loads;
  for (const std::string& name : options.loads) loads.push_back(machine_case.load(name));

  Validation validation;
  for (int draw = 0; draw < options.draws; ++draw) {
    VirtualOptions machine_options = options.machine;
    machine_options.seed = options.first_seed + static_cast<std::uint64_t>(draw);
    const mesh::Machine machine = perturbed(machine_case.machine, machine_options.seed);
    const solver::FullModel full = solver::build_full_model(
        machine, {machine_options.size_factor, machine_options.mesh_cache});
    validation.measured_nodes = full.mesh.nodes();
    for (const solver::LoadProgram& load : loads) {
      core::log_line(fmt::format("validation: machine {} of {}, {}", draw + 1, options.draws, load.name()));
      const Measurement measurement =
          measure_virtually(full, load, machine_case.check_points, machine_options);
      for (ValidationRow& row :
           judge_compensation(measurement, machine_case.machine, model, load.name(), draw))
        validation.rows.push_back(std::move(row));
    }
  }
  return validation;
}

namespace {

struct Reductions {
  double before = 0, model = 0, sensors = 0;  ///< mean squares over the check points
  double percent(bool with_sensors) const {
    return 100.0 * (1.0 - std::sqrt((with_sensors ? sensors : model) / before));
  }
};

std::map<int, Reductions> by_draw(const std::vector<ValidationRow>& rows, const std::string& load) {
  std::map<int, Reductions> draws;
  for (const ValidationRow& row : rows) {
    if (row.load != load) continue;
    Reductions& sum = draws[row.draw];
    sum.before += row.rms_before_um * row.rms_before_um;
    sum.model += row.rms_model_um * row.rms_model_um;
    sum.sensors += row.rms_sensors_um * row.rms_sensors_um;
  }
  return draws;
}

}  // namespace

double Validation::median_reduction(const std::string& load, bool sensors) const {
  std::vector<double> values;
  for (const auto& [draw, sums] : by_draw(rows, load)) values.push_back(sums.percent(sensors));
  if (values.empty()) return solver::not_given;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

std::string Validation::brief() const {
  std::vector<std::string> loads;
  for (const ValidationRow& row : rows)
    if (std::find(loads.begin(), loads.end(), row.load) == loads.end()) loads.push_back(row.load);
  std::vector<std::vector<std::string>> table{
      {"program", "machine", "RMS before um", "no sensors um", "with sensors um", "no sensors %", "with sensors %"}};
  for (const std::string& load : loads) {
    for (const auto& [draw, sums] : by_draw(rows, load)) {
      const double count = static_cast<double>(std::count_if(
          rows.begin(), rows.end(), [&, d = draw](const ValidationRow& r) { return r.load == load && r.draw == d; }));
      table.push_back({load, std::to_string(draw + 1), fmt::format("{:.2f}", std::sqrt(sums.before / count)),
                       fmt::format("{:.2f}", std::sqrt(sums.model / count)),
                       fmt::format("{:.2f}", std::sqrt(sums.sensors / count)),
                       fmt::format("{:.1f}", sums.percent(false)), fmt::format("{:.1f}", sums.percent(true))});
    }
    table.push_back({load, "median", "", "", "", fmt::format("{:.1f}", median_reduction(load, false)),
                     fmt::format("{:.1f}", median_reduction(load, true))});
  }
  return core::format_table(table);
}

}  // namespace thermotwin::compensation
