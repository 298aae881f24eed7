// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "compensation/evaluation/replay.h"
#include "compensation/online/axis_reach.h"
#include "core/error.h"
#include "core/file.h"
#include "core/range.h"
#include "core/text.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/case.h"

namespace thermotwin::compensation {
namespace {

/// The three displacement columns of one pose.
struct PoseColumns {
  std::string text;
  mesh::Pose pose;
  std::array<Eigen::Index, 3> columns{-1, -1, -1};
  Eigen::Vector3d noise_um = Eigen::Vector3d::Zero();
};

std::vector<PoseColumns> pose_columns(const Measurement& measurement, const mesh::Machine& machine) {
  std::vector<PoseColumns> poses;
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.kind != ChannelKind::displacement) continue;
    const std::string axes = "xyz";
    const std::size_t axis =
        channel.quantity.size() == 2 && channel.quantity[0] == 'd' ? axes.find(channel.quantity[1]) : std::string::npos;
    if (axis == std::string::npos) continue;
    auto found =
        std::find_if(poses.begin(), poses.end(), [&](const PoseColumns& p) { return p.text == channel.pose_text; });
    if (found == poses.end()) {
      poses.push_back({channel.pose_text, mesh::parse_pose(machine, channel.pose_text, channel.id), {-1, -1, -1}, {}});
      found = std::prev(poses.end());
    }
    found->columns[axis] = channel.column;
    found->noise_um[axis] = channel.uncertainty;
  }
  std::erase_if(poses, [](const PoseColumns& p) {
    return std::any_of(p.columns.begin(), p.columns.end(), [](Eigen::Index c) { return c < 0; });
  });
  return poses;
}

}  // namespace

namespace detail {

std::vector<Eigen::Matrix3Xd> measured_translations(const Measurement& measurement, const mesh::Machine& machine,
                                                    std::vector<mesh::Pose>& poses) {
  std::vector<Eigen::Matrix3Xd> values;
  for (const PoseColumns& columns : pose_columns(measurement, machine)) {
    poses.push_back(columns.pose);
    Eigen::Matrix3Xd at(3, measurement.data.rows());
    for (int k = 0; k < 3; ++k) at.row(k) = measurement.data.values.col(columns.columns[k]).transpose();
    values.push_back(std::move(at));
  }
  return values;
}

}  // namespace detail

std::vector<ValidationRow> judge_compensation(const Measurement& measurement, const mesh::Machine& machine,
                                              const reduction::ReducedModel& model, const std::string& load, int draw,
                                              std::vector<ValidationTrace>* traces) {
  const std::vector<PoseColumns> columns = pose_columns(measurement, machine);
  std::vector<mesh::Pose> poses;
  const std::vector<Eigen::Matrix3Xd> measured = detail::measured_translations(measurement, machine, poses);
  const auto blind = run_compensator(measurement, model, poses, {false, false, 0, true});
  const auto told = run_compensator(measurement, model, poses, {false, true, 0, true});
  std::vector<Eigen::Matrix3Xd> deviations;
  const auto seeing = run_compensator(measurement, model, poses, {true, false, 0, true}, nullptr, nullptr,
                                      traces != nullptr ? &deviations : nullptr);
  const Eigen::VectorXd time = measurement.time();
  std::vector<ValidationRow> rows;
  for (std::size_t p = 0; p < poses.size(); ++p) {
    ValidationRow row;
    row.load = load;
    row.draw = draw;
    row.pose = columns[p].text;
    const AxisReach reach(model.machine, poses[p]);
    double count = 0;
    for (Eigen::Index i = 0; i < measurement.data.rows(); ++i) {
      const Eigen::Vector3d truth = measured[p].col(i);
      if (time[i] < time[0] + offset_settle_s || !truth.allFinite()) continue;
      const auto left = [&](const auto& errors) {
        return (truth - errors[p][i].error.template head<3>() / core::units::um).eval();
      };
      const Eigen::Vector3d with = left(seeing);
      ++count;
      row.rms_before_um += truth.squaredNorm();
      row.rms_model_um += left(blind).squaredNorm();
      row.rms_told_um += left(told).squaredNorm();
      row.rms_sensors_um += with.squaredNorm();
      row.rms_unmoved_um += reach.unmoved(truth).squaredNorm();
      row.largest_before_um = std::max(row.largest_before_um, truth.norm());
      row.largest_sensors_um = std::max(row.largest_sensors_um, with.norm());
    }
    if (count == 0) continue;
    for (double* sum :
         {&row.rms_before_um, &row.rms_model_um, &row.rms_told_um, &row.rms_sensors_um, &row.rms_unmoved_um})
      *sum = std::sqrt(*sum / count);
    rows.push_back(row);
    if (traces == nullptr) continue;
    ValidationTrace trace{load,        draw,        row.pose,      time / core::units::hour, measured[p],
                          measured[p], measured[p], deviations[p], columns[p].noise_um};
    for (Eigen::Index i = 0; i < time.size(); ++i) {
      trace.left_um.col(i) -= seeing[p][i].error.head<3>() / core::units::um;
      trace.unmoved_um.col(i) = reach.unmoved(measured[p].col(i));
    }
    traces->push_back(std::move(trace));
  }
  return rows;
}

Eigen::Matrix3Xd ValidationTrace::band_um() const {
  const Eigen::Array3Xd whole = (std_um.array().square().colwise() + noise_um.array().square()).sqrt();
  return 2.0 * (std_um.array() > 0.0).select(whole, 0.0);
}

std::pair<Eigen::Index, Eigen::Index> ValidationTrace::coverage() const {
  const Eigen::Array3Xd rest = (left_um - unmoved_um).array().abs(), band = band_um().array();
  const auto stated = (band > 0.0 && rest.isFinite()).eval();
  return {stated.count(), (stated && rest <= band).count()};
}

void ValidationOptions::validate() const {
  core::require_option(draws >= 1, "validation draws", draws, "1 or more");
  machine.validate();
}

void require_check_points(const solver::Case& machine_case) {
  if (!machine_case.check_points.empty()) return;
  throw core::InputError(machine_case.folder.string() + "/case.toml check_points", "no poses",
                         "at least one pose off the grid at which the compensation is judged");
}

std::vector<MeasuredLoad> validation_loads(const solver::Case& machine_case, const ValidationOptions& options) {
  std::vector<MeasuredLoad> loads;
  for (const std::string& name : options.loads)
    loads.push_back({machine_case.load(name), core::read_file(machine_case.folder / "loads" / (name + ".toml"))});
  return loads;
}

Eigen::Index measure_each(
    const solver::Case& machine_case, const std::vector<MeasuredLoad>& loads, const ValidationOptions& options,
    const std::function<void(int draw, const MeasuredLoad& load, const Measurement& measurement)>& take) {
  options.validate();
  require_check_points(machine_case);
  MeasuredMachines machines(machine_case, options.machine, options.keep, options.reference);
  for (int draw = 0; draw < options.draws; ++draw)
    for (const MeasuredLoad& load : loads) take(draw, load, machines.measure(options.first_seed + draw, load));
  return machines.nodes();
}

Validation validate_online(const solver::Case& machine_case, const reduction::ReducedModel& model,
                           const ValidationOptions& options) {
  Validation validation;
  const auto judge = [&](int draw, const MeasuredLoad& load, const Measurement& measurement) {
    std::vector<ValidationTrace>* traces = draw < options.traced_draws ? &validation.traces : nullptr;
    for (ValidationRow& row :
         judge_compensation(measurement, machine_case.machine, model, load.program.name(), draw, traces))
      validation.rows.push_back(std::move(row));
  };
  validation.measured_nodes = measure_each(machine_case, validation_loads(machine_case, options), options, judge);
  validation.unmoved_directions =
      AxisReach(machine_case.machine, machine_case.check_points.front()).unmoved_directions();
  return validation;
}

namespace {

/// "-" for what there is not: a share of nothing, where no axis moves the tool.
std::string cell(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

struct Sums {
  double before = 0, model = 0, told = 0, sensors = 0, unmoved = 0;  ///< squares over the check points
  int poses = 0;
  double square(With with) const { return with == With::model ? model : with == With::told ? told : sensors; }
  double left(With with) const { return std::sqrt(square(with)); }
  double percent(With with) const { return 100.0 * (1.0 - left(with) / std::sqrt(before)); }
  double moved_percent(With with) const { return 100.0 * (1.0 - std::sqrt(moved(with) / (before - unmoved))); }
  double moved(With with) const { return std::max(0.0, square(with) - unmoved); }
  double cut() const { return 100.0 * (1.0 - std::sqrt(moved(With::sensors) / moved(With::told))); }
};

std::map<int, Sums> by_draw(const std::vector<ValidationRow>& rows, const std::string& load) {
  std::map<int, Sums> draws;
  for (const ValidationRow& row : rows) {
    if (row.load != load) continue;
    Sums& sum = draws[row.draw];
    sum.before += row.rms_before_um * row.rms_before_um;
    sum.model += row.rms_model_um * row.rms_model_um;
    sum.told += row.rms_told_um * row.rms_told_um;
    sum.sensors += row.rms_sensors_um * row.rms_sensors_um;
    sum.unmoved += row.rms_unmoved_um * row.rms_unmoved_um;
    ++sum.poses;
  }
  return draws;
}

}  // namespace

std::vector<double> Validation::reductions(const std::string& load, With with) const {
  std::vector<double> values;
  for (const auto& [draw, sums] : by_draw(rows, load)) values.push_back(sums.percent(with));
  return values;
}

std::vector<double> Validation::moved_reductions(const std::string& load, With with) const {
  std::vector<double> values;
  for (const auto& [draw, sums] : by_draw(rows, load)) values.push_back(sums.moved_percent(with));
  return values;
}

double Validation::rms(const std::string& load, double ValidationRow::*value) const {
  double sum = 0.0;
  int count = 0;
  for (const ValidationRow& row : rows)
    if (row.load == load) sum += row.*value * row.*value, ++count;
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

std::string Validation::unmoved_sentence(const std::string& load, const std::string& unit) const {
  if (unmoved_directions.empty()) return "";
  const double stays = rms(load, &ValidationRow::rms_unmoved_um), before = rms(load, &ValidationRow::rms_before_um),
               sensors = rms(load, &ValidationRow::rms_sensors_um);
  const auto rest = [&](double whole) { return std::sqrt(std::max(0.0, whole * whole - stays * stays)); };
  std::string text =
      fmt::format("No axis moves the tool along {}: {:.1f} {} RMS stay there.", unmoved_directions, stays, unit);
  const double removed = quantile(moved_reductions(load, With::sensors), 0.5);
  if (std::isfinite(removed)) {
    text += fmt::format(" In the directions that axes move, {:.1f} {} become {:.1f} {}, {:.1f} % removed.",
                        rest(before), unit, rest(sensors), unit, removed);
  }
  return text;
}

std::vector<double> Validation::cuts(const std::string& load) const {
  std::vector<double> values;
  for (const auto& [draw, sums] : by_draw(rows, load)) values.push_back(sums.cut());
  return values;
}

Rows Validation::summary() const {
  Rows table{{"program", "machines", "surroundings known %: median", "10th percentile", "sensors %: median",
              "10th percentile", "cut by sensors %"}};
  if (!unmoved_directions.empty())
    table.front().insert(table.front().end(), {"sensors % where axes move: median", "10th percentile"});
  std::vector<std::string> loads;
  for (const ValidationRow& row : rows)
    if (std::find(loads.begin(), loads.end(), row.load) == loads.end()) loads.push_back(row.load);
  for (const std::string& load : loads) {
    const std::vector<double> told = reductions(load, With::told), with = reductions(load, With::sensors);
    table.push_back({load, std::to_string(with.size())});
    for (const double value : {quantile(told, 0.5), quantile(told, 0.1), quantile(with, 0.5), quantile(with, 0.1),
                               quantile(cuts(load), 0.5)})
      table.back().push_back(cell(value, 1));
    if (unmoved_directions.empty()) continue;
    for (const double share : {0.5, 0.1})
      table.back().push_back(cell(quantile(moved_reductions(load, With::sensors), share), 1));
  }
  return table;
}

Validation Validation::first(int draws) const {
  Validation part = *this;
  std::erase_if(part.rows, [&](const ValidationRow& row) { return row.draw >= draws; });
  std::erase_if(part.traces, [&](const ValidationTrace& trace) { return trace.draw >= draws; });
  return part;
}

double Validation::median_reduction(const std::string& load, bool sensors) const {
  return quantile(reductions(load, sensors ? With::sensors : With::model), 0.5);
}

Rows Validation::table() const {
  std::vector<std::string> loads;
  for (const ValidationRow& row : rows)
    if (std::find(loads.begin(), loads.end(), row.load) == loads.end()) loads.push_back(row.load);
  Rows table{{"program", "machine", "RMS before um", "no sensors", "surroundings known", "sensors", "no sensors %",
              "surroundings known %", "sensors %", "cut by sensors %"}};
  const bool stays = !unmoved_directions.empty();
  if (stays) table.front().insert(table.front().end(), {"no axis moves um", "sensors % where axes move"});
  for (const std::string& load : loads) {
    for (const auto& [draw, sums] : by_draw(rows, load)) {
      const double share = std::sqrt(sums.poses);
      table.push_back({load, std::to_string(draw + 1), cell(std::sqrt(sums.before) / share, 2),
                       cell(sums.left(With::model) / share, 2), cell(sums.left(With::told) / share, 2),
                       cell(sums.left(With::sensors) / share, 2), cell(sums.percent(With::model), 1),
                       cell(sums.percent(With::told), 1), cell(sums.percent(With::sensors), 1), cell(sums.cut(), 1)});
      if (!stays) continue;
      table.back().push_back(cell(std::sqrt(sums.unmoved) / share, 2));
      table.back().push_back(cell(sums.moved_percent(With::sensors), 1));
    }
    for (const auto& [name, share] : {std::pair{"median", 0.5}, {"10th percentile", 0.1}}) {
      table.push_back({load, name, "", "", "", "", cell(quantile(reductions(load, With::model), share), 1),
                       cell(quantile(reductions(load, With::told), share), 1),
                       cell(quantile(reductions(load, With::sensors), share), 1),
                       cell(quantile(cuts(load), share), 1)});
      if (stays)
        table.back().insert(table.back().end(), {"", cell(quantile(moved_reductions(load, With::sensors), share), 1)});
    }
  }
  return table;
}

std::string Validation::brief() const {
  std::string stays;
  std::vector<std::string> said;
  for (const ValidationRow& row : rows) {
    if (unmoved_directions.empty() || std::find(said.begin(), said.end(), row.load) != said.end()) continue;
    said.push_back(row.load);
    stays += fmt::format("{}: {}\n", row.load, unmoved_sentence(row.load));
  }
  return core::format_table(table()) + stays +
         "surroundings known: without sensors, but with all ambients at the hall temperature\ncut by sensors: share of "
         "that residual which the sensors remove" +
         (unmoved_directions.empty() ? "" : ", in the directions that axes move") + "\n";
}

}  // namespace thermotwin::compensation
