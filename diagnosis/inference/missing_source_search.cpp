// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/missing_source_search.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>
#include <optional>

#include "compensation/measurement/channel.h"
#include "core/thread_pool.h"
#include "core/units.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/missing_source.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/inference/daily_window_search.h"
#include "diagnosis/inference/model_search.h"
#include "diagnosis/inference/patch_evidence.h"
#include "solver/operation/channels.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double nominal_W = 0.02;     ///< what none has: nothing
constexpr double stands_still = 1e-3;  ///< an input that varies by less of its largest value
constexpr std::size_t most_inputs = 10, kept_inputs = 3;
constexpr double changes_alike = 0.05;  ///< of their largest values: inputs that a record cannot tell apart
constexpr Index place_directions_kept = 3;
/// Of a response: a posterior over patches may be narrow, but extent and shape of a source stay unknown. As large as
/// what its size may wander by in time.
constexpr double least_place_share = 0.12;
constexpr double tiny = 1e-20;
/// A patch says that the source is within its box, and one heated spot differs from a patch by as much as the patches
/// beside it do: of the squared radius. Of the boxes alone four in five held the source (patches of 7 cm); set on 15
/// sources among nine sensors, patches of 24 cm.
constexpr double patch_resolution = 5.0;

struct Followed {
  std::string channel;
  double at = 1, most = 1;
  VectorXd series;                 ///< (steps) relative to `at`
  std::vector<std::string> alike;  ///< other channels of nearly the same series
  std::optional<DailyWindow> daily{};
  double log_share = 0;  ///< of its prior
};

/// Largest value that the input can have; that seen where nothing says.
double largest(const mesh::Machine& machine, const compensation::Channel& input, double seen) {
  if (input.quantity == compensation::Quantity::turning) return std::max(seen, machine.spindle_max_rpm);
  for (const mesh::Axis& axis : machine.axes) {
    if (input.quantity == compensation::Quantity::feed && input.axis == axis.id)
      return std::max(seen, axis.rapid * core::units::minute /
                                (axis.kind == mesh::AxisKind::linear ? core::units::mm : core::units::deg));
  }
  return seen;
}

/// Inputs that several records have count once.
std::vector<compensation::MeasuredChannel> recorded_channels(Records records) {
  std::vector<compensation::MeasuredChannel> channels;
  for (const compensation::Measurement& record : records) {
    for (const compensation::MeasuredChannel& channel : record.channels) {
      const bool known =
          &record != &records.front() && std::any_of(channels.begin(), channels.end(),
                                                     [&](const auto& other) { return other.input == channel.input; });
      if (!known) channels.push_back(channel);
    }
  }
  return channels;
}

/// Measured speeds, powers and states that change, and the machine being on: what runs while it is. Those that change
/// alike are one: each of them alone would have to share its probability with the others.
std::vector<Followed> followed_inputs(const mesh::Machine& machine, const solver::Channels& channels, Records records,
                                      const Observations& obs) {
  const int machine_on = channels.index("machine.on");
  VectorXd on(obs.rows.rows());
  for (Index s = 0; s < on.size(); ++s) on[s] = magnitude(obs, machine_on, s);
  std::vector<Followed> found{{"machine.on", 1, 1, on, {}}};
  for (const compensation::MeasuredChannel& measured : recorded_channels(records)) {
    using compensation::ChannelKind;
    const int channel = measured.input.empty() ? -1 : channels.index(measured.input);
    if (channel < 0 || measured.input == "machine.on" || measured.input == mesh::time_of_day) continue;
    if (measured.kind != ChannelKind::speed && measured.kind != ChannelKind::power &&
        measured.kind != ChannelKind::state && measured.kind != ChannelKind::flow)
      continue;
    VectorXd series(obs.rows.rows());
    for (Index s = 0; s < series.size(); ++s) series[s] = magnitude(obs, channel, s);
    const double high = series.maxCoeff();
    if (!(high > 0.0) || high - series.minCoeff() <= stands_still * high) continue;
    series /= high;
    const auto twin = std::find_if(found.begin(), found.end(), [&](const Followed& other) {
      return (other.series - series).cwiseAbs().maxCoeff() <= changes_alike;
    });
    if (twin != found.end())
      twin->alike.push_back(measured.input);
    else if (found.size() < most_inputs)
      found.push_back(
          {measured.input, high, largest(machine, compensation::channel_named(measured.input), high), series, {}});
  }
  return found;
}

/// Leading directions of what a source's response may be off by, one standard deviation each, where its place is only
/// known to a posterior. (combinations x few)
MatrixXd place_directions(const SearchData& seen, const MatrixXd& weights, Index input, const VectorXd& posterior,
                          const VectorXd& chosen) {
  const Index m = weights.rows();
  const auto own = seen.white.middleCols(input * m, m);
  const MatrixXd apart = (weights.colwise() - chosen) * posterior.cwiseSqrt().asDiagonal(),
                 spread = apart * apart.transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> metric(MatrixXd(own.transpose() * own));
  const MatrixXd root = metric.eigenvectors() * metric.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(root.transpose() * spread * root));
  MatrixXd directions(m, std::min(m, place_directions_kept));
  const double least = least_place_share * (own * chosen).norm();
  for (Index i = 0; i < directions.cols(); ++i) {
    const double square = eigen.eigenvalues()[m - 1 - i],
                 wide = std::max(1.0, least / std::sqrt(std::max(square, tiny)));
    directions.col(i) =
        square > tiny ? VectorXd(wide * (spread * (root * eigen.eigenvectors().col(m - 1 - i))) / std::sqrt(square))
                      : VectorXd::Zero(m);
  }
  return directions;
}

/// Where the posterior has the source: mean within the most probable body, and the radius about it
/// that holds 95 % of all.
void place(const VectorXd& posterior, const std::vector<reduction::Patch>& patches, MissingSource& source) {
  std::vector<std::pair<std::string, double>> bodies;
  for (Index k = 0; k < posterior.size(); ++k) {
    const std::string& body = patches[k].surface.body;
    if (bodies.empty() || bodies.back().first != body) bodies.emplace_back(body, 0.0);
    bodies.back().second += posterior[k];
  }
  source.body = std::max_element(bodies.begin(), bodies.end(), [](const auto& a, const auto& b) {
                  return a.second < b.second;
                })->first;
  double sum = 0.0, extent = 0.0;
  source.centre.setZero();
  for (Index k = 0; k < posterior.size(); ++k) {
    const reduction::Patch& patch = patches[k];
    if (patch.surface.body != source.body) continue;
    source.centre += posterior[k] * patch.centre;
    const mesh::Rule& box = patch.surface.any_of.front();
    extent += posterior[k] * 0.25 * (*box.box_max - *box.box_min).squaredNorm();
    sum += posterior[k];
  }
  source.centre /= sum;
  std::vector<std::pair<double, double>> distances;
  for (Index k = 0; k < posterior.size(); ++k)
    distances.emplace_back((patches[k].centre - source.centre).norm(), posterior[k]);
  std::sort(distances.begin(), distances.end());
  double inside = 0.0, radius = 0.0;
  for (const auto& [distance, probability] : distances) {
    inside += probability;
    radius = distance;
    if (inside >= 0.95) break;
  }
  source.region95 = std::sqrt(radius * radius + patch_resolution * extent / sum);
}

/// A source on a patch is somewhere on it: its weight over the patches around, by distance in units of its own radius.
/// @param posterior  (patches x shares, shares outermost)
VectorXd blurred(const VectorXd& posterior, const std::vector<reduction::Patch>& patches) {
  const auto count = std::ssize(patches);
  MatrixXd kernel(count, count);
  for (Index k = 0; k < count; ++k) {
    const reduction::Patch& from = patches[k];
    for (Index i = 0; i < count; ++i) {
      const reduction::Patch& to = patches[i];
      kernel(i, k) = to.surface.body == from.surface.body
                         ? std::exp(-0.5 * (to.centre - from.centre).squaredNorm() * std::numbers::pi / from.area)
                         : 0.0;
    }
    kernel.col(k) /= kernel.col(k).sum();
  }
  VectorXd result(posterior.size());
  for (Index first = 0; first < posterior.size(); first += count)
    result.segment(first, count) = kernel * posterior.segment(first, count);
  return result;
}

/// Longest that the machine is in one state: its coefficients there.
VectorXd usual_coefficients(const mesh::Machine& machine, const reduction::ReducedModel& model,
                            const Observations& obs) {
  const solver::OperatingModel operating(machine, model.system.layout);
  const VectorXd inlets = VectorXd::Zero(std::ssize(machine.coolants));
  VectorXd mean = VectorXd::Zero(std::ssize(model.system.terms));
  const Index stride = std::max<Index>(1, obs.rows.rows() / 50);
  Index count = 0;
  for (Index s = 0; s < obs.rows.rows(); s += stride, ++count)
    mean += operating.coefficients(obs.rows.row(s).transpose(), inlets).p;
  return mean / count;
}

/// Where the record states the time of day, the part of the day that a source fits best is an input beside the others.
void add_daily(const Problem& problem, const Response& response, const MachineInTime& base,
               const solver::Channels& channels, const Combinations& heat, std::vector<Followed>& inputs) {
  const int hour = channels.index(mesh::time_of_day);
  if (hour < 0 || !problem.observations.rows.col(hour).array().isFinite().any()) return;
  const std::optional<DailySource> daily =
      find_daily_source(problem, response, base, problem.observations.rows.col(hour), heat);
  if (!daily) return;
  Followed input{mesh::time_of_day, 1, 1, daily->series, {}};
  input.daily = daily->window;
  input.log_share = daily->log_share;
  inputs.push_back(std::move(input));
}

}  // namespace

void add_missing_sources(Problem& problem, const Response& response, const reduction::ReducedModel& model,
                         Records records) {
  const auto& patches = model.patches.items;
  if (patches.empty()) return;
  const mesh::Machine& machine = model.machine;
  const Observations& obs = problem.observations;
  const solver::Channels channels(machine);
  std::vector<Followed> inputs = followed_inputs(machine, channels, records, obs);
  VectorXd scale(std::ssize(obs.channels));
  for (std::size_t k = 0; k < obs.channels.size(); ++k)
    scale[k] = problem.expected_std.segment(problem.first_row(k), obs.channels[k].size()).mean();
  MatrixXd both(model.patches.inputs.rows(), 2 * model.patches.inputs.cols());
  both << model.patches.inputs, response.spread_heat() * model.patches.inputs;
  const Combinations heat =
      combinations(model, both, response.nominal_rows(), scale, usual_coefficients(machine, model, obs));
  const MachineInTime base = problem.machine_around(machine, {});
  const MatrixXd weights = between(heat.weights);
  add_daily(problem, response, base, channels, {heat.loads, weights}, inputs);
  MatrixXd series(obs.rows.rows(), std::ssize(inputs));
  std::size_t all_inputs = 0;
  for (Index j = 0; j < series.cols(); ++j) {
    series.col(j) = inputs[j].series;
    all_inputs += 1 + inputs[j].alike.size();
  }
  const MatrixXd responses = response.to_heat(base, heat.loads, series);
  const SearchData seen(problem, responses);
  const MatrixXd every = SearchOptions{}.evidence_share * all_evidence(seen, weights, series.cols()),
                 evidence = over_shares(every);

  std::vector<Index> order(inputs.size());
  std::iota(order.begin(), order.end(), Index{0});
  const RowVectorXd best = evidence.colwise().maxCoeff();
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return best[a] > best[b]; });
  order.resize(std::min(order.size(), kept_inputs));
  std::vector<Parameter> found;
  std::vector<MatrixXd> freedom;
  const Index m = weights.rows(), shares = std::ssize(spread_shares);
  for (const Index j : order) {
    const VectorXd places = evidence.col(j);
    Index k = 0;
    const double top = places.maxCoeff(&k), total = top + std::log((places.array() - top).exp().sum());
    const Followed& input = inputs[j];
    auto source = std::make_shared<MissingSource>();
    source->surface = patches[k].surface;
    source->follows = input.channel;
    source->at = input.at;
    source->most = input.most;
    source->alike = input.alike;
    source->daily = input.daily;
    place((places.array() - total).exp(), patches, *source);
    Parameter p = make_parameter(Kind::source_missing,
                                 fmt::format("{} at {:.0f} {:.0f} {:.0f} mm", source->body, 1e3 * source->centre.x(),
                                             1e3 * source->centre.y(), 1e3 * source->centre.z()));
    p.nominal_std = nominal_W;
    p.cause_std = prior_source_W;
    p.prior_share =
        std::exp(input.log_share + total - top) * (1.0 + input.alike.size()) / (all_inputs * evidence.rows());
    p.missing = std::move(source);
    found.push_back(std::move(p));
    const VectorXd posterior = (every.col(j).array() - total).exp() / shares;
    freedom.push_back(responses.middleCols(j * m, m) *
                      place_directions(seen, weights, j, blurred(posterior, patches), weights.col(k)));
    if (input.daily) {
      const MatrixXd courses = course_freedom(*input.daily, obs.rows.col(channels.index(mesh::time_of_day)));
      MatrixXd& all = freedom.back();
      const Index before = all.cols();
      all.conservativeResize(Eigen::NoChange, before + courses.cols());
      all.rightCols(courses.cols()) = response.to_heat(base, heat.loads * weights.col(k), courses);
    }
  }
  const MatrixXd columns = response.linearise(base, found, VectorXd::Zero(std::ssize(found)), false).sensitivity;
  for (std::size_t i = 0; i < found.size(); ++i) {
    problem.place_freedom[problem.parameters.size()] = std::move(freedom[i]);
    add_parameter(problem, found[i], columns.col(i));
  }
}

}  // namespace thermotwin::diagnosis
