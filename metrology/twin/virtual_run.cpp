// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/twin/virtual_run.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "compensation/evaluation/reduced_models.h"
#include "core/error.h"
#include "core/range.h"
#include "core/thread_pool.h"
#include "metrology/twin/stations.h"
#include "solver/campaign/campaign.h"
#include "solver/elastic/outputs.h"

namespace thermotwin::metrology {

using compensation::ObservedQuantity;
using Eigen::Index;
using Eigen::MatrixXd;
using mesh::Machine;
using mesh::Pose;

namespace {

constexpr Index rows_per_pose = 19;  ///< tool 6, table axis 6, table own 7
constexpr double sweep_every = 2.0;  ///< s, between outputs during a sweep

/// Outputs of all stations at all output times.
struct History {
  std::vector<double> times;
  std::vector<MatrixXd> outputs;  ///< (times) (19 x stations)

  /// Linear between two outputs.
  Eigen::VectorXd at(double time, const std::vector<std::pair<std::size_t, double>>& weights) const {
    const auto above = std::lower_bound(times.begin(), times.end(), time);
    const auto after = std::min<std::size_t>(above - times.begin(), times.size() - 1),
               before = after > 0 ? after - 1 : 0;
    const double span = times[after] - times[before];
    const double share = span > 0 ? std::clamp((time - times[before]) / span, 0.0, 1.0) : 1.0;
    Eigen::VectorXd value = Eigen::VectorXd::Zero(rows_per_pose);
    for (const auto& [station, weight] : weights) {
      value += weight * ((1.0 - share) * outputs[before].col(station) + share * outputs[after].col(station));
    }
    return value;
  }
};

solver::TcpError error_of(const Machine& machine, const Pose& pose, const Eigen::VectorXd& outputs) {
  return solver::tcp_error(machine, pose, outputs.head<6>(), outputs.segment<6>(6), outputs.tail<7>());
}

MatrixXd stack_rows(const solver::FullModel& full, const std::vector<Pose>& poses) {
  MatrixXd rows(rows_per_pose * std::ssize(poses), full.thermal.size);
  core::parallel_for(0, poses.size(), [&](std::size_t i) {
    const solver::OutputRows of_pose = full.elastic.output_rows(poses[i]);
    const Index first = rows_per_pose * i;
    rows.middleRows<6>(first) = of_pose.tool;
    rows.middleRows<6>(first + 6) = of_pose.table_axis;
    rows.middleRows<7>(first + 12) = of_pose.table_own;
  });
  return rows;
}

/// A location error at one pose, and the stations of the poses that it needs.
struct Observed {
  ObservedQuantity quantity;
  std::vector<std::size_t> stations;
};
using Functional = std::vector<Observed>;  ///< at the poses of a cycle: an axis' place is that of its mean line
constexpr std::size_t most_poses = 16;     ///< of a cycle, that count

std::vector<Functional> functionals_of(const Machine& machine, const std::vector<std::string>& names,
                                       Stations& stations) {
  const std::vector<Pose> of_points = stations.poses;
  const std::size_t step = (of_points.size() + most_poses - 1) / most_poses;
  std::vector<Functional> functionals;
  for (const std::string& name : names) {
    compensation::MeasuredChannel channel;
    channel.id = channel.quantity = name;
    channel.kind = compensation::ChannelKind::displacement;
    functionals.emplace_back();
    for (std::size_t i = 0; i < of_points.size(); i += step) {
      ObservedQuantity quantity(machine, channel, of_points[i]);
      std::vector<std::size_t> at;
      for (const Pose& pose : quantity.poses()) at.push_back(stations.add(machine, pose));
      functionals.back().push_back({std::move(quantity), std::move(at)});
    }
  }
  return functionals;
}

/// First and last time of each cycle.
std::map<int, std::pair<double, double>> cycles_of(const std::vector<PlannedPoint>& points) {
  std::map<int, std::pair<double, double>> cycles;
  for (const PlannedPoint& point : points) {
    auto [at, is_new] = cycles.try_emplace(point.cycle, point.time, point.time);
    at->second.second = std::max(at->second.second, point.time);
  }
  return cycles;
}

std::vector<double> output_times(const solver::LoadProgram& load, const std::vector<PlannedPoint>& points,
                                 const std::map<int, std::pair<double, double>>& cycles, bool sweep,
                                 double rows_every) {
  std::vector<double> all{0.0, load.duration()};
  for (double time = rows_every; time < load.duration(); time += rows_every) all.push_back(time);
  for (const auto& [cycle, span] : cycles) {
    all.push_back(0.5 * (span.first + span.second));
    if (!sweep) continue;
    for (double time = span.first; time < span.second; time += sweep_every) all.push_back(time);
    all.push_back(span.second);
  }
  if (!sweep)
    for (const PlannedPoint& point : points) all.push_back(point.time);
  std::sort(all.begin(), all.end());
  std::vector<double> kept;
  for (const double time : all)
    if (kept.empty() || time - kept.back() > 1e-3) kept.push_back(time);
  return kept;
}

constexpr std::size_t most_surface_nodes = 150;

/// Nodes of the table's surface (tcp.table_surface) in the plane of the table point; all of it where none lies there.
std::vector<Index> table_nodes(const mesh::MachineMesh& mesh) {
  const Machine& machine = mesh.machine;
  const int table = machine.body_index(machine.tcp.table_body),
            surface = machine.surface_index(machine.tcp.table_surface);
  const mesh::TetMesh& body = mesh.bodies[table];
  const Eigen::Vector3d normal = solver::growth_axis(machine).second;
  constexpr double in_plane = 1e-3;  // m
  std::vector<Index> all, flat;
  for (const int face : mesh.surfaces[surface]) {
    for (const int node : body.faces.col(face)) {
      all.push_back(node);
      if (std::abs(normal.dot(body.points.col(node) - machine.tcp.table_point)) < in_plane) flat.push_back(node);
    }
  }
  std::vector<Index>& found = flat.empty() ? all : flat;
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<Index> kept;
  const std::size_t step = (found.size() + most_surface_nodes - 1) / most_surface_nodes;
  for (std::size_t i = 0; i < found.size(); i += step) kept.push_back(found[i]);
  return kept;
}

/// Frame of the table's surface: columns x, y, normal, home frame of the table.
Eigen::Matrix3d surface_frame(const Machine& machine) {
  const Eigen::Vector3d normal = solver::growth_axis(machine).second;
  Eigen::Vector3d x = Eigen::Vector3d::UnitX() - normal * normal.x();
  if (x.norm() < 0.1) x = Eigen::Vector3d::UnitY() - normal * normal.y();
  Eigen::Matrix3d frame;
  frame << x.normalized(), normal.cross(x.normalized()), normal;
  return frame;
}

}  // namespace

void VirtualRunOptions::validate() const {
  core::require_within("virtual run rows_every", rows_every, core::positive);
  core::require_within("virtual run refine", refine, core::positive);
  time.validate();
}

VirtualRun run_virtually(const solver::FullModel& full, const solver::LoadProgram& load,
                         const std::vector<PlannedPoint>& points, const VirtualRunOptions& options) {
  options.validate();
  if (points.empty()) throw core::InputError("points.csv", "no points", "at least one point");
  const Machine& machine = full.mesh.machine;
  for (const PlannedPoint& point : points) {
    if (point.time >= 0.0 && point.time <= load.duration() + 1e-6) continue;
    throw core::InputError("points.csv time_s", std::to_string(point.time),
                           "0 to " + std::to_string(load.duration()) + " s, the length of the load program");
  }
  Stations stations = stations_of(machine, points);
  const bool sweep = points.size() > 1 && stations.of_point.front().size() > 1;
  const std::vector<Functional> functionals = functionals_of(machine, options.quantities, stations);
  const auto cycles = cycles_of(points);
  solver::LoadProgram program = load;
  program.choose_outputs(output_times(load, points, cycles, sweep, options.rows_every), "points.csv");
  const MatrixXd rows = stack_rows(full, stations.poses);
  History history;
  solver::CampaignOptions campaign;
  campaign.poses = {points.front().pose};
  campaign.refine = options.refine;
  campaign.time = options.time;
  campaign.on_output = [&](const solver::LoadProgram&, const solver::OutputState& output) {
    const Eigen::VectorXd values = rows * output.state;
    history.times.push_back(output.time);
    history.outputs.emplace_back(values.reshaped(rows_per_pose, std::ssize(stations.poses)));
  };
  VirtualRun run;
  const std::vector<Index> on_surface = options.surface ? table_nodes(full.mesh) : std::vector<Index>();
  const int table = machine.body_index(machine.tcp.table_body);
  const Eigen::Matrix3d frame = surface_frame(machine);
  if (options.surface) {
    const Eigen::Matrix3Xd& at = full.mesh.bodies[table].points;
    run.surface_at.resize(std::ssize(on_surface), 2);
    run.surface.setZero(std::ssize(cycles), std::ssize(on_surface));
    for (Index i = 0; i < std::ssize(on_surface); ++i)
      run.surface_at.row(i) = ((at.col(on_surface[i]) - machine.tcp.table_point).transpose() * frame).head<2>();
    campaign.on_output = [&, before = campaign.on_output](const solver::LoadProgram& of,
                                                          const solver::OutputState& output) {
      before(of, output);
      Index row = 0;
      for (const auto& [cycle, span] : cycles) {
        if (std::abs(output.time - 0.5 * (span.first + span.second)) <= 1e-3) {
          const Eigen::Matrix3Xd moved = full.elastic.displacement(output.state, points.front().pose);
          for (Index i = 0; i < std::ssize(on_surface); ++i)
            run.surface(row, i) = frame.col(2).dot(moved.col(full.mesh.first_node[table] + on_surface[i]));
        }
        ++row;
      }
    };
  }
  run.load = solver::run_campaign(full, {program}, campaign).front();
  run.quantities = options.quantities;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [first, last] = cycles.at(points[i].cycle);
    const auto at = [&](double time) {
      return error_of(machine, points[i].pose, history.at(time, stations.of_point[i]));
    };
    const solver::TcpError middle = at(0.5 * (first + last));
    run.error.push_back(at(points[i].time).error);
    run.frozen.push_back(middle.error);
    run.table.emplace_back(-middle.table);
  }
  run.functionals.resize(std::ssize(cycles), std::ssize(functionals));
  for (const auto& [cycle, span] : cycles) {
    const double middle = 0.5 * (span.first + span.second);
    for (std::size_t q = 0; q < functionals.size(); ++q) {
      double sum = 0.0;
      for (const Observed& one : functionals[q]) {
        std::vector<solver::TcpError> errors;
        for (std::size_t k = 0; k < one.stations.size(); ++k)
          errors.push_back(error_of(machine, one.quantity.poses()[k], history.at(middle, {{one.stations[k], 1.0}})));
        sum += one.quantity(errors);
      }
      run.functionals(std::ssize(run.middle), q) = sum / functionals[q].size();
    }
    run.middle.push_back(middle);
  }
  return run;
}

}  // namespace thermotwin::metrology
