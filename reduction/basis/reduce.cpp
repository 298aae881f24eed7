// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/reduce.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/error.h"
#include "core/range.h"
#include "core/thread_pool.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/balanced_basis.h"
#include "reduction/basis/basis.h"
#include "reduction/basis/modal_basis.h"
#include "reduction/basis/parameter_parts.h"
#include "reduction/basis/patches.h"
#include "reduction/basis/projection.h"
#include "reduction/basis/responses.h"
#include "reduction/basis/sensor_air.h"
#include "reduction/model/reduced_simulation.h"
#include "reduction/model/trained_range.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "solver/operation/layout.h"

namespace thermotwin::reduction {
namespace {

constexpr Eigen::Index tried_orders[] = {20, 40, 60, 80, 100, 120, 160, 200, 240, 300, 400};
constexpr Eigen::Index most_snapshots = 120;  ///< of one load
/// Sizes of the groups relative to all responses. Of 15 sets tried on vmc5, coarse, these had the
/// least error on the training loads at order 240 (0.12 um; all weights 1 or 0.3: 0.3 um).
constexpr double adjoint_weight = 3.0, change_weight = 0.3, snapshot_weight = 5.0;

class Watch {
public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Snapshots without their uniform part, every so many if there are too many; each load's compressed. @param given
/// gets their number
Eigen::MatrixXd chosen_snapshots(const solver::ThermalSystem& thermal, const solver::SparseMatrix& energy,
                                 const std::vector<solver::LoadResult>& training, Eigen::Index& given) {
  std::vector<Eigen::MatrixXd> blocks;
  Eigen::Index count = 0;
  for (const solver::LoadResult& result : training) {
    const Eigen::Index all = result.snapshots.cols();
    if (all == 0) continue;
    if (result.snapshots.rows() != thermal.size) {
      throw core::InputError("snapshots of load '" + result.load + "'", fmt::format("{} rows", result.snapshots.rows()),
                             fmt::format("{}, the size of the full model", thermal.size));
    }
    const Eigen::Index stride = (all + most_snapshots - 1) / most_snapshots, kept = (all + stride - 1) / stride;
    Eigen::MatrixXd block(thermal.size, kept);
    for (Eigen::Index i = 0; i < kept; ++i) block.col(i) = result.snapshots.col(i * stride);
    remove_mean(thermal, block);
    block /= std::sqrt(kept);  // each load counts the same, however long
    given += kept;
    blocks.push_back(compressed(energy, block, least_direction));
    count += blocks.back().cols();
  }
  Eigen::MatrixXd snapshots(thermal.size, count);
  Eigen::Index at = 0;
  for (const Eigen::MatrixXd& block : blocks) {
    snapshots.middleCols(at, block.cols()) = block;
    at += block.cols();
  }
  return snapshots;
}

/// All groups side by side, each brought to its size relative to the responses.
Eigen::MatrixXd scaled_columns(const solver::ThermalSystem& thermal, const Candidates& groups,
                               const Eigen::MatrixXd& snapshots) {
  const double size = groups.responses.cols() > 0 ? mean_square(thermal.capacity, groups.responses) : 1.0;
  const std::pair<const Eigen::MatrixXd*, double> blocks[] = {{&groups.responses, 1.0},
                                                              {&groups.adjoints, adjoint_weight},
                                                              {&groups.changes, change_weight},
                                                              {&snapshots, snapshot_weight}};
  Eigen::Index count = 0, at = 0;
  for (const auto& [block, weight] : blocks) count += block->cols();
  Eigen::MatrixXd all(thermal.size, count);
  for (const auto& [block, weight] : blocks) {
    const double own = mean_square(thermal.capacity, *block);
    all.middleCols(at, block->cols()) = (own > 0.0 ? weight * std::sqrt(size / own) : 1.0) * *block;
    at += block->cols();
  }
  return all;
}

/// Directions of the method, the uniform field first. @param standing  p of the machine at rest
Basis basis_of(const solver::ThermalSystem& thermal, const solver::OperatingModel& operating,
               const std::vector<solver::OutputRows>& rows, const std::vector<solver::LoadResult>& training,
               const Eigen::VectorXd& standing, BasisMethod method, Eigen::Index most, ReduceSummary& notes) {
  const solver::SparseMatrix conduction = symmetric_conduction(thermal, standing);
  if (method == BasisMethod::modal || method == BasisMethod::balanced) {
    Basis basis = method == BasisMethod::modal ? modal_basis(thermal, standing, most)
                                               : balanced_basis(thermal, operating, rows, most);
    notes.candidates = basis.rank;
    return basis;
  }
  const bool krylov = method != BasisMethod::pod, snapshots = method != BasisMethod::krylov;
  Candidates groups;
  for (Eigen::MatrixXd* group : {&groups.responses, &groups.adjoints, &groups.changes}) group->resize(thermal.size, 0);
  if (krylov) groups = make_candidates(thermal, operating, rows, default_candidates());
  Eigen::Index given = groups.made;
  const Eigen::MatrixXd chosen = snapshots ? chosen_snapshots(thermal, energy_of(thermal, conduction), training, given)
                                           : Eigen::MatrixXd(thermal.size, 0);
  const Eigen::MatrixXd candidates = scaled_columns(thermal, groups, chosen);
  if (candidates.cols() == 0) {
    throw core::InputError("basis of the reduced model", "no snapshots",
                           "a campaign that keeps them, or --method krylov");
  }
  notes.candidates = given;
  Basis basis = make_basis(thermal, conduction, candidates, most);
  notes.deflated = notes.candidates - basis.rank;
  return basis;
}

/// What the campaign made of the machine since each load's start, on the basis: (order x some of its outputs).
Eigen::MatrixXd states_of(const solver::ThermalSystem& thermal, const Eigen::MatrixXd& basis,
                          const std::vector<solver::LoadResult>& training) {
  constexpr Eigen::Index most_states = 60;  // of one load
  const Eigen::MatrixXd weighted = thermal.capacity * basis;
  Eigen::MatrixXd states(basis.cols(), 0);
  for (const solver::LoadResult& result : training) {
    const Eigen::Index all = result.snapshots.cols();
    if (all == 0) continue;
    const Eigen::Index stride = (all + most_states - 1) / most_states, kept = (all + stride - 1) / stride;
    Eigen::MatrixXd chosen(thermal.size, kept);
    for (Eigen::Index i = 0; i < kept; ++i) chosen.col(i) = result.snapshots.col(i * stride) - result.snapshots.col(0);
    states.conservativeResize(Eigen::NoChange, states.cols() + kept);
    states.rightCols(kept).noalias() = weighted.transpose() * chosen;
  }
  return states;
}

using LoadPairs = std::vector<std::pair<const solver::LoadProgram*, const solver::LoadResult*>>;

/// Loads that have a result. @throws InputError for a result without its load
LoadPairs matched(const std::vector<solver::LoadProgram>& loads, const std::vector<solver::LoadResult>& training) {
  LoadPairs pairs;
  for (const solver::LoadResult& result : training) {
    const auto load =
        std::find_if(loads.begin(), loads.end(), [&](const solver::LoadProgram& l) { return l.name() == result.load; });
    if (load == loads.end())
      throw core::InputError("training result '" + result.load + "'", "no such load", "results of the loads given");
    if (result.tcp.rows() > 0) pairs.emplace_back(&*load, &result);
  }
  return pairs;
}

/// The largest error of the loads, um. @param trained  is widened to what the coefficients were in them
double training_error_um(const ReducedModel& model, const LoadPairs& pairs, TrainedRange& trained) {
  std::vector<double> error(pairs.size());
  std::vector<TrainedRange> seen(pairs.size());
  core::parallel_for(0, pairs.size(), [&](std::size_t i) {
    const auto [load, result] = pairs[i];
    const solver::LoadResult reduced = simulate_reduced(
        model, model.machine, *load, poses_of(model.machine, result->tcp), {.tell = false, .seen = &seen[i]});
    error[i] = compare(*result, reduced).max_um;
  });
  for (const TrainedRange& range : seen) {
    trained.include(range.low);
    trained.include(range.high);
  }
  return *std::max_element(error.begin(), error.end());
}

std::vector<Eigen::Index> orders_to_try(Eigen::Index largest, bool only_largest) {
  std::vector<Eigen::Index> orders;
  for (const Eigen::Index order : tried_orders) {
    if (order < largest && !only_largest) orders.push_back(order);
  }
  orders.push_back(largest);
  return orders;
}

/// The smallest order tried that is good enough on the training loads.
/// @param model   of the largest order or more; gets the range of the coefficients in the loads
/// @param states  of the campaign, (order x any number); none: nothing is said of the observer
/// @param standing  p of the machine at rest
ReducedModel of_smallest_order(ReducedModel& model, const std::vector<Eigen::Index>& orders, const LoadPairs& pairs,
                               const Eigen::MatrixXd& states, const Eigen::VectorXd& standing,
                               const ReduceOptions& options, ReduceSummary& notes) {
  ReducedModel chosen;
  for (const Eigen::Index order : orders) {
    chosen = truncated(model, order);
    if (pairs.empty()) break;
    const double worst = training_error_um(chosen, pairs, model.trained);
    chosen.trained = model.trained;
    notes.order_error_um.emplace_back(order, worst);
    if (states.cols() > 0 && notes.sensors)
      notes.observer.push_back(observer_noise(chosen, states.topRows(order), standing));
    if (worst <= (options.order_by_observer ? notes.observer.back().predicted_um : options.tolerance_um)) break;
  }
  const bool missed = orders.size() > 1 && !options.order_by_observer && !notes.order_error_um.empty() &&
                      notes.order_error_um.back().second > options.tolerance_um;
  if (missed) notes.missed_um = options.tolerance_um;
  return chosen;
}

void add_parts(const solver::FullModel& full, const Eigen::MatrixXd& basis, int patches, ReducedModel& model) {
  model.parts = make_parts(full, basis);
  model.patches.items = surface_patches(full.mesh, patches);
  model.patches.inputs = (patch_loads(full, model.patches.items).transpose() * basis).transpose();
}

}  // namespace

BasisMethod basis_method(const std::string& name) {
  for (std::size_t i = 0; i < std::size(basis_methods); ++i)
    if (name == basis_methods[i]) return static_cast<BasisMethod>(i);
  throw core::UsageError(fmt::format("unknown method '{}'; one of: {}", name, fmt::join(basis_methods, ", ")));
}

void ReduceOptions::validate() const {
  core::require_option(tolerance_um > 0.0, "reduction tolerance_um", tolerance_um, "a number above 0");
  core::require_option(max_order >= 1, "reduction max_order", max_order, "1 or more");
  core::require_option(order >= 0, "reduction order", order, "0 (by the tolerance) or more");
  core::require_option(patches >= 0, "reduction patches", patches, "0 or more");
}

ReducedModel reduce(const solver::FullModel& full, const std::vector<solver::LoadProgram>& loads,
                    const std::vector<solver::LoadResult>& training, const ReduceOptions& options,
                    ReduceSummary* summary, ReducedModel* reference, Eigen::MatrixXd* columns) {
  options.validate();
  const LoadPairs pairs = matched(loads, training);
  const solver::ThermalSystem& thermal = full.thermal;
  const solver::OperatingModel operating(full.mesh.machine, thermal.layout);
  ReduceSummary notes;
  const Watch rows_watch;
  const FullOutputs rows(full);
  notes.rows_seconds = rows_watch.seconds();

  const Watch basis_watch;
  const std::vector<OperatingPoint> points = operating_points(operating);
  const Eigen::Index wanted = options.order > 0 ? options.order : options.max_order;
  const Eigen::Index of_reference = reference ? reference_order(wanted) : wanted;
  const Basis basis = basis_of(thermal, operating, rows.kept(), training, points.front().c.p, options.method,
                               columns ? std::max(of_reference, 3 * wanted) : of_reference, notes);
  notes.basis_seconds = basis_watch.seconds();

  const Watch projection_watch;
  // Columns beyond those of the reference are for the bound alone.
  const Eigen::MatrixXd vectors = basis.vectors.leftCols(std::min(basis.vectors.cols(), of_reference));
  ReducedModel model;
  model.machine = full.mesh.machine;
  model.size = fmt::format("{} nodes", full.mesh.nodes());
  model.full_size = thermal.size;
  model.system = project_system(thermal, vectors);
  model.outputs = rows.project(vectors);
  model.sensor_air = sensor_air(full, vectors);
  notes.projection_seconds = projection_watch.seconds();
  for (const OperatingPoint& point : points) model.trained.include(point.c.p);

  const Watch orders_watch;
  const Eigen::Index largest = std::min(wanted, model.system.order());
  Eigen::MatrixXd states(0, 0);
  if (!pairs.empty()) states = states_of(thermal, basis.vectors.leftCols(largest), training);
  notes.sensors = !full.mesh.machine.sensors.empty();
  if (options.order_by_observer && !notes.sensors) {
    throw core::InputError("order by the observer", "a machine without sensors",
                           "one or more [[sensor]] in machine.toml");
  }
  if (options.order_by_observer && states.cols() == 0)
    throw core::InputError("order by the observer", "no snapshots of the training loads", "a campaign that keeps them");
  notes.prior_share = prior_share(full.mesh.machine);
  ReducedModel chosen = of_smallest_order(model, orders_to_try(largest, options.order > 0 || pairs.empty()), pairs,
                                          states, points.front().c.p, options, notes);
  notes.orders_seconds = orders_watch.seconds();
  notes.order = chosen.system.order();
  Eigen::MatrixXd own;
  if (options.parts || summary) own = basis.vectors.leftCols(notes.order);
  if (options.parts) {
    const Watch parts_watch;
    add_parts(full, own, options.patches, chosen);
    notes.parts_seconds = parts_watch.seconds();
  }
  if (reference) *reference = truncated(model, std::min(reference_order(notes.order), model.system.order()));
  if (columns) *columns = basis.vectors;
  if (summary) {
    notes.basis = std::move(own);
    *summary = std::move(notes);
  }
  return chosen;
}

Eigen::Index ReduceSummary::order_of_observer() const {
  if (observer.size() != order_error_um.size()) return 0;
  Eigen::Index from = 0;
  for (std::size_t i = order_error_um.size(); i-- > 0 && order_error_um[i].second <= observer[i].predicted_um;)
    from = order_error_um[i].first;
  return from;
}

std::string ReduceSummary::brief() const {
  constexpr double diverged_um = 1e5;  // a chiller guided by a sensor may swing ever more where few states represent it
  std::string text = fmt::format("order {} from {} candidates ({} dependent)", order, candidates, deflated);
  const bool observed = observer.size() == order_error_um.size();
  for (std::size_t i = 0; i < order_error_um.size(); ++i) {
    const auto [tried, error_um] = order_error_um[i];
    text += error_um < diverged_um ? fmt::format("\n  order {:>3}: {:.4f} um on the training loads", tried, error_um)
                                   : fmt::format("\n  order {:>3}: diverges on the training loads", tried);
    if (observed) text += fmt::format("; observer noise {:.2f} um", observer[i].predicted_um);
  }
  if (missed_um > 0.0) {
    const auto least = std::min_element(order_error_um.begin(), order_error_um.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
    text += fmt::format(
        "\nno order reaches tolerance_um = {:g} on the training loads; the least error is {:.2f} um, at order {}. "
        "--order takes a larger order, a finer mesh may lower the error too",
        missed_um, least->second, least->first);
  }
  if (!sensors) return text + "\nno sensors: the observer noise is unknown";
  if (!observed || observer.empty()) return text;
  if (const Eigen::Index from = order_of_observer(); from > 0)
    text += fmt::format("\nfrom order {} on the observer noise exceeds the reduction error", from);
  else
    text += "\nthe reduction error exceeds the observer noise at every order tried";
  return text + fmt::format(
                    "\nobserver noise: standard deviation of the TCP error with the sensors; {:.2f} um without them"
                    "\nprior of the observer: the states of the campaign times {:.1f} %, which is the uncertainty of "
                    "sources and films in machine.toml",
                    observer.back().open_um, 100 * prior_share);
}

}  // namespace thermotwin::reduction
