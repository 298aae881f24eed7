// SPDX-License-Identifier: GPL-3.0-or-later
// `reduce CASE`: the reduced model with its order, error and speed; all methods side by side.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

#include "core/error.h"
#include "core/file.h"
#include "core/line_chart.h"
#include "core/progress.h"
#include "core/text.h"
#include "core/thread_pool.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/projection.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "tools/chain.h"
#include "tools/identify_case.h"
#include "tools/reduced_scene.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;

constexpr Eigen::Index least_compared = 240;
constexpr Eigen::Index compared_orders[] = {20, 40, 60, 80, 120, 160, 240, 320, 400};

struct MethodErrors {
  std::string name;
  double basis_seconds = 0;
  std::vector<std::pair<Eigen::Index, double>> worst_um;  ///< order, over all held-out loads
};

/// Errors on the held-out loads of every method, order by order. The campaign is there, and so is one of the
/// models: that of `method`.
std::vector<MethodErrors> compare_methods(const solver::FullModel& full, const solver::Case& machine_case,
                                          const ReducedCase& made, reduction::BasisMethod method, const fs::path& out) {
  solver::CampaignOptions options;
  options.out = options.checkpoints = out / "campaign";
  options.resume = options.keep_snapshots = true;
  const auto training = load_programs(machine_case, machine_case.train),
             heldout = load_programs(machine_case, machine_case.holdout);
  auto trained = solver::run_campaign(full, training, options);
  for (solver::LoadResult& result : trained) result.tcp = {};  // snapshots are wanted, errors on these loads are not
  options.keep_snapshots = false;
  const auto held = solver::run_campaign(full, heldout, options);
  const auto poses = mesh::workspace_poses(machine_case.machine);
  const Eigen::Index largest = std::max<Eigen::Index>(made.summary.order, least_compared);
  std::vector<MethodErrors> all;
  for (std::size_t m = 0; m < std::size(reduction::basis_methods); ++m) {
    MethodErrors of{reduction::basis_methods[m], 0, {}};
    reduction::ReduceOptions wanted;
    wanted.method = static_cast<reduction::BasisMethod>(m);
    wanted.order = largest;
    wanted.parts = false;
    reduction::ReduceSummary summary;
    const bool made_before = wanted.method == method && made.reference.system.order() >= largest;
    const reduction::ReducedModel model = made_before ? reduction::truncated(made.reference, largest)
                                                      : reduction::reduce(full, training, trained, wanted, &summary);
    of.basis_seconds = made_before ? made.summary.basis_seconds : summary.basis_seconds;
    std::vector<Eigen::Index> orders;
    for (const Eigen::Index order : compared_orders)
      if (order < model.system.order()) orders.push_back(order);
    orders.push_back(model.system.order());
    core::Progress progress("held-out loads, method " + of.name, orders.size() * heldout.size());
    for (const Eigen::Index order : orders) {
      const reduction::ReducedModel small = reduction::truncated(model, order);
      std::vector<double> worst(heldout.size());
      core::parallel_for(0, heldout.size(), [&](std::size_t i) {
        worst[i] = reduction::compare(held[i], reduction::simulate_reduced(small, machine_case.machine, heldout[i],
                                                                           poses, {.tell = false}))
                       .max_um;
        progress.advance();
      });
      of.worst_um.emplace_back(order, *std::max_element(worst.begin(), worst.end()));
    }
    all.push_back(std::move(of));
  }
  const IdentifiedCase identified = identify_case(machine_case, options.out, 0);
  MethodErrors of{"identified", identified.seconds, {}};
  std::vector<Eigen::Index> orders;
  for (const Eigen::Index order : compared_orders)
    if (order < identified.model.largest_order()) orders.push_back(order);
  orders.push_back(identified.model.largest_order());
  for (const Eigen::Index order : orders) {
    double worst = 0;
    for (const reduction::ReductionErrors& e : identified.errors(order)) worst = std::max(worst, e.max_um);
    of.worst_um.emplace_back(order, worst);
  }
  all.push_back(std::move(of));
  return all;
}

std::string comparison_table(const std::vector<MethodErrors>& methods) {
  std::vector<std::vector<std::string>> table{{"order: worst error on held-out loads, um"}};
  std::vector<Eigen::Index> orders;
  for (const MethodErrors& method : methods) {
    table[0].push_back(method.name);
    for (const auto& [order, error] : method.worst_um) orders.push_back(order);
  }
  std::sort(orders.begin(), orders.end());
  orders.erase(std::unique(orders.begin(), orders.end()), orders.end());
  for (const Eigen::Index order : orders) {
    std::vector<std::string> row{std::to_string(order)};
    for (const MethodErrors& method : methods) {
      const auto at = std::find_if(method.worst_um.begin(), method.worst_um.end(),
                                   [order](const auto& entry) { return entry.first == order; });
      row.push_back(at == method.worst_um.end() ? "-" : fmt::format("{:.3f}", at->second));
    }
    table.push_back(std::move(row));
  }
  std::vector<std::string> row{"basis, s"};
  for (const MethodErrors& method : methods) row.push_back(fmt::format("{:.0f}", method.basis_seconds));
  table.push_back(std::move(row));
  return core::format_table(table);
}

/// What a user would run instead of reducing: a transient of so many steps of a held-out load at one pose.
struct TransientTime {
  std::string load;
  double seconds = 0;   ///< for all steps, with factors and the pose's rows
  std::size_t run = 0;  ///< steps that were run; the rest is taken in proportion
};
constexpr std::size_t transient_steps = 800;

TransientTime time_transient(const solver::FullModel& full, const solver::Case& machine_case) {
  const std::string& name = machine_case.holdout.empty() ? machine_case.train.front() : machine_case.holdout.front();
  solver::LoadProgram load = machine_case.load(name);
  const std::vector<double> ends = load.step_ends();
  TransientTime result{name, 0, std::min(transient_steps, ends.size())};
  load.choose_outputs({ends[result.run - 1]}, "the timed transient");
  solver::CampaignOptions options;
  const auto poses = mesh::workspace_poses(machine_case.machine);
  options.poses = {poses[poses.size() / 2]};
  const Stopwatch watch;
  solver::run_campaign(full, {load}, options);
  result.seconds = watch.seconds() * transient_steps / result.run;
  return result;
}

std::string building_text(const ReducedCase& made, const TransientTime& transient) {
  const reduction::ReduceSummary& s = made.summary;
  std::string text = fmt::format(
      "built in    {:.1f} s: output rows {:.1f}, basis {:.1f}, projection {:.1f}, orders {:.1f}, parts {:.1f}; "
      "campaign {:.1f} s\n",
      s.seconds(), s.rows_seconds, s.basis_seconds, s.projection_seconds, s.orders_seconds, s.parts_seconds,
      made.campaign_seconds);
  text += fmt::format(
      "transient   {} steps at one pose on this mesh ({}{}): {:.1f} s; building the reduced model takes {:.1f} times "
      "as long",
      transient_steps, transient.load, transient.run < transient_steps ? fmt::format(", from {}", transient.run) : "",
      transient.seconds, s.seconds() / transient.seconds);
  return text;
}

core::LineChart chart_of(const ReducedCase& made) {
  core::LineChart chart;
  chart.title = fmt::format("Order and error, {}", made.model.machine.name);
  chart.x_title = "order of the reduced model";
  chart.y_title = "largest TCP error against the full model, \u00b5m";
  chart.log_y = true;
  return chart;
}

void write_comparison_picture(const fs::path& file, const ReducedCase& made, const std::vector<MethodErrors>& methods) {
  core::LineChart chart = chart_of(made);
  chart.title += ", held-out loads";
  for (const MethodErrors& method : methods) {
    core::LineChart::Line line{method.name, {}};
    for (const auto& [order, error] : method.worst_um) line.points.emplace_back(order, error);
    chart.lines.push_back(std::move(line));
  }
  core::write_file(file, chart.svg());
}

/// @throws UsageError, InputError before anything is computed
std::vector<mesh::Pose> bounded_poses(const ReduceOptions& options, const mesh::Machine& machine) {
  std::vector<mesh::Pose> poses;
  for (const std::string& pose : options.bound_poses) poses.push_back(mesh::parse_pose(machine, pose, "--bound-pose"));
  if (options.bound && poses.empty()) {
    const std::vector<mesh::Pose> grid = mesh::workspace_poses(machine);
    poses.push_back(grid[grid.size() / 2]);
  }
  if (!poses.empty()) reduction::require_affine(machine);
  return poses;
}

nlohmann::json errors_json(const ReducedCase& made) {
  nlohmann::json json = nlohmann::json::object();
  for (std::size_t i = 0; i < made.summary.order_error_um.size(); ++i) {
    const auto& [order, error] = made.summary.order_error_um[i];
    json["orders"].push_back({{"order", order}, {"error_um", error}});
    if (i < made.summary.observer.size()) json["orders"].back()["observer_um"] = made.summary.observer[i].predicted_um;
  }
  json["order_of_observer"] = made.summary.order_of_observer();
  for (const auto& e : made.off_grid) {
    json["off_grid"].push_back(
        {{"load", e.load}, {"peak_um", e.peak_um()}, {"max_um", e.max_um()}, {"own_rows_max_um", e.own_rows_um()}});
  }
  for (const auto& e : made.sensors) {
    json["sensors"].push_back({{"load", e.load},
                               {"sensor", e.sensor},
                               {"range_K", e.range_K},
                               {"max_K", e.max_K},
                               {"rms_K", e.rms_K},
                               {"at_s", e.at_s}});
  }
  for (const auto& e : made.model.errors) {
    json["heldout"].push_back({{"load", e.load},
                               {"peak_um", e.peak_um},
                               {"max_um", e.max_um},
                               {"rms_um", e.rms_um},
                               {"estimate_max_um", e.estimate_max_um},
                               {"effectivity", e.effectivity}});
  }
  if (made.model.mesh_error) {
    const reduction::MeshError& e = *made.model.mesh_error;
    json["mesh_error"] = {{"second", e.second},
                          {"tcp", std::vector<double>(e.tcp.begin(), e.tcp.end())},
                          {"sensors", std::vector<double>(e.sensors.begin(), e.sensors.end())}};
  }
  for (const BoundedLoad& b : made.bounded) {
    json["bounds"].push_back({{"load", b.load},
                              {"pose", b.pose},
                              {"peak_um", b.peak_um},
                              {"error_um", b.error_um},
                              {"bound_um", b.bound_um},
                              {"remainder_um", b.remainder_um},
                              {"least_ratio", b.least_ratio},
                              {"median_ratio", b.median_ratio},
                              {"seconds", b.seconds}});
  }
  return json;
}

nlohmann::json building_json(const ReducedCase& made, const TransientTime& transient) {
  const reduction::ReduceSummary& stages = made.summary;
  return {{"rows_s", stages.rows_seconds},
          {"basis_s", stages.basis_seconds},
          {"projection_s", stages.projection_seconds},
          {"orders_s", stages.orders_seconds},
          {"parts_s", stages.parts_seconds},
          {"all_s", stages.seconds()},
          {"transient_s", transient.seconds},
          {"ratio", stages.seconds() / transient.seconds},
          {"campaign_s", made.campaign_seconds}};
}

nlohmann::json comparison_json(const std::vector<MethodErrors>& methods) {
  nlohmann::json json = nlohmann::json::array();
  for (const MethodErrors& method : methods) {
    for (const auto& [order, error] : method.worst_um) {
      json.push_back(
          {{"method", method.name}, {"order", order}, {"worst_um", error}, {"basis_s", method.basis_seconds}});
    }
  }
  return json;
}

}  // namespace

void write_order_picture(const fs::path& file, const ReducedCase& made, double tolerance_um) {
  core::LineChart chart = chart_of(made);
  core::LineChart::Line line{"training loads", {}};
  for (const auto& [order, error] : made.summary.order_error_um) line.points.emplace_back(order, error);
  chart.lines.push_back(std::move(line));
  for (const auto& e : made.model.errors)
    chart.lines.push_back({e.load, {{static_cast<double>(made.summary.order), e.max_um}}});
  chart.target = tolerance_um;
  chart.target_name = "tolerance";
  core::write_file(file, chart.svg());
}

void reduce(const ReduceOptions& options) {
  if (options.order_by_observer && (options.identify || !options.matrices.empty()))
    throw core::UsageError("--order observer needs a CASE that is reduced with its full model");
  if (!options.matrices.empty()) return reduce_matrices(options);
  if (options.identify) return reduce_from_campaign(options);
  if (options.case_path.empty())
    throw core::UsageError("reduce: a CASE or --matrices DIR is needed\nsee: thermotwin reduce --help");
  const Stopwatch time;
  const solver::Case machine_case = open_case(options.case_path, options.size, options.mesh_order);
  for (const auto& names : {machine_case.train, machine_case.holdout}) load_programs(machine_case, names);
  reduction::ReduceOptions wanted;
  wanted.order = options.order;
  wanted.order_by_observer = options.order_by_observer;
  if (!options.method.empty()) wanted.method = reduction::basis_method(options.method);
  const std::vector<mesh::Pose> bounded = bounded_poses(options, machine_case.machine);
  const solver::FullModel full = build(machine_case, options.out, options.solver);
  const ReducedCase made = make_reduced_model(full, machine_case, wanted, options.resume, options.out, bounded);
  write_reduced_scene(options.out / "scene.bin", full, made, machine_case);
  const TransientTime transient = time_transient(full, machine_case);

  nlohmann::json json = errors_json(made);
  json["order"] = made.summary.order;
  json["nodes"] = full.mesh.nodes();
  json["reference_order"] = made.reference.system.order();
  json["method"] = name_of(wanted.method);
  json["basis_s"] = made.summary.basis_seconds;
  json["building"] = building_json(made, transient);
  std::string text = made.summary.brief() + "\n\n" + error_table(made) + "\n" + building_text(made, transient) + "\n";
  if (made.bound) text += bound_table(made) + "\n";
  const auto picture = options.out / "order.svg";
  if (options.compare) {
    const std::vector<MethodErrors> methods = compare_methods(full, machine_case, made, wanted.method, options.out);
    text += comparison_table(methods) + "\n";
    json["comparison"] = comparison_json(methods);
    write_comparison_picture(picture, made, methods);
  } else {
    write_order_picture(picture, made, machine_case.tolerance_um);
  }
  json["seconds"] = time.seconds();
  print_summary(options,
                text + fmt::format("{} and {} in {:.0f} s\n", (options.out / "model.rom.h5").string(), picture.string(),
                                   time.seconds()),
                json.dump());
}

}  // namespace thermotwin::tools
