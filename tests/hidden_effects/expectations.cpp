// SPDX-License-Identifier: GPL-3.0-or-later
#include "expectations.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>
#include <random>

#include "diagnosis/causes/parameter.h"
#include "diagnosis/inference/evidence.h"
#include "diagnosis/record/diagnose_options.h"
#include "reduction/model/trained_range.h"

namespace thermotwin::hidden {

using diagnosis::Parameter;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double spot_W = 100.0;
constexpr Index most_patches = 120;  ///< of all: the others lie between these

double log_sum(const std::vector<double>& logs) {
  if (logs.empty()) return -1e300;
  const double top = *std::max_element(logs.begin(), logs.end());
  double sum = 0.0;
  for (const double value : logs) sum += std::exp(value - top);
  return top + std::log(sum);
}

/// Of heat of some power against none. @param square, product  of the response to 1 W, with itself and with the signal
double log_evidence_of_heat(double square, double product) {
  const double width = 1.0 + std::max(0.0, square) * spot_W * spot_W, mean = product * spot_W / width;
  return -0.5 * std::log(width) + 0.5 * mean * product * spot_W +
         std::log(std::max(1e-12, std::erfc(-mean * std::sqrt(0.5 * width))));
}

}  // namespace

double distance(const Parameter& a, const Parameter& b) { return (a.missing->centre - b.missing->centre).norm(); }

bool may_follow(const diagnosis::MissingSource& source, const std::string& input) {
  return source.follows == input || std::find(source.alike.begin(), source.alike.end(), input) != source.alike.end();
}

bool same_cause(const Parameter& a, const Parameter& b) {
  if (a.kind != b.kind) return false;
  if (!a.missing || !b.missing) return a.where == b.where;
  return (may_follow(*a.missing, b.missing->follows) || may_follow(*b.missing, a.missing->follows)) &&
         distance(a, b) <= same_place_m;
}

Parameter on_model(const Parameter& truth, const reduction::ReducedModel& model) {
  if (!truth.missing) return truth;
  Parameter result = truth;
  auto source = std::make_shared<diagnosis::MissingSource>(*truth.missing);
  double nearest = 1e300;
  for (const reduction::Patch& patch : model.patches.items) {
    const double distance = (patch.centre - source->centre).norm() + (patch.surface.body == source->body ? 0.0 : 1.0);
    if (distance < nearest) nearest = distance, source->surface = patch.surface;
  }
  result.missing = std::move(source);
  return result;
}

Seen::Seen(const reduction::ReducedModel& model, const compensation::Measurement& measurement,
           const std::vector<Followable>& inputs, const diagnosis::DiagnoseOptions& how)
    : model_(model),
      inputs_(inputs) {
  const solver::Channels channels(model.machine);
  observations_ =
      std::make_unique<diagnosis::Observations>(diagnosis::observe(measurement, model.machine, channels, {}));
  response_ = std::make_unique<diagnosis::Response>(model, *observations_);
  problem_ = diagnosis::make_problem(model.machine, measurement, *observations_, *response_, how);
  whitener_ = std::make_unique<diagnosis::Whitener>(problem_.fitted_covariance());
  columns_ = whitener_->whiten(problem_.fitted(problem_.columns));
  nuisances_ = columns_ * problem_.prior_std.asDiagonal();
  if (model.patches.items.empty()) inputs_.clear();
  if (inputs_.empty()) return;
  series_.resize(observations_->rows.rows(), std::ssize(inputs_));
  for (Index j = 0; j < series_.cols(); ++j) {
    const int channel = channels.index(inputs_[j].channel);
    for (Index s = 0; s < series_.rows(); ++s) {
      const double value = channel < 0 ? 1.0 : observations_->rows(s, channel);
      series_(s, j) = std::isfinite(value) ? std::abs(value) / inputs_[j].most : 0.0;
    }
  }
  // In no order: neighbours are numbered alike, and a stride may step over all of a place.
  patches_.resize(model.patches.inputs.cols());
  std::iota(patches_.begin(), patches_.end(), Index{0});
  std::shuffle(patches_.begin(), patches_.end(), std::mt19937_64(1));
  patches_.resize(std::min<std::size_t>(patches_.size(), most_patches));
  spots_ = whitener_->whiten(
      problem_.fitted(response_->to_heat(model.machine, model.patches.inputs(Eigen::all, patches_), series_)));
  MatrixXd precision = MatrixXd::Identity(nuisances_.cols(), nuisances_.cols());
  precision.noalias() += nuisances_.transpose() * nuisances_;
  taken_.compute(precision);
  spots_taken_ = taken_.matrixL().solve(nuisances_.transpose() * spots_);
}

VectorXd Seen::taken(const VectorXd& white) const { return taken_.matrixL().solve(nuisances_.transpose() * white); }

MatrixXd Seen::of_spots(const VectorXd& white) const {
  const VectorXd square = (spots_.colwise().squaredNorm() - spots_taken_.colwise().squaredNorm()).transpose();
  const VectorXd product = spots_.transpose() * white - spots_taken_.transpose() * taken(white);
  VectorXd log(square.size());
  for (Index i = 0; i < log.size(); ++i) log[i] = log_evidence_of_heat(square[i], product[i]);
  return Eigen::Map<const MatrixXd>(log.data(), std::ssize(patches_), std::ssize(inputs_));
}

VectorXd Seen::secant(const Truth& truth) const {
  const VectorXd there = response_->predict(diagnosis::with_parameter(model_.machine, truth.parameter, truth.value));
  return whitener_->whiten(problem_.fitted((there - problem_.predicted) / (truth.value - truth.parameter.nominal)));
}

double Seen::apart(Index patch, const Truth& truth) const {
  return (model_.patches.items[patch].centre - truth.parameter.missing->centre).norm();
}

double Seen::at_its_place(const Truth& truth, const VectorXd& white) const {
  const auto count = std::ssize(model_.patches.items);
  std::vector<Index> here;
  Index nearest = 0;
  for (Index k = 0; k < count; ++k) {
    if (apart(k, truth) <= same_place_m) here.push_back(k);
    if (apart(k, truth) < apart(nearest, truth)) nearest = k;
  }
  if (here.empty()) here.push_back(nearest);
  const auto input = std::find_if(inputs_.begin(), inputs_.end(),
                                  [&](const Followable& f) { return f.channel == truth.parameter.missing->follows; });
  if (input == inputs_.end()) return -1e300;
  const MatrixXd one_W = whitener_->whiten(problem_.fitted(response_->to_heat(
      model_.machine, model_.patches.inputs(Eigen::all, here), series_.col(input - inputs_.begin()))));
  std::vector<double> logs;
  for (Index k = 0; k < one_W.cols(); ++k) {
    const VectorXd column = one_W.col(k), column_taken = taken(column);
    logs.push_back(log_evidence_of_heat(column.squaredNorm() - column_taken.squaredNorm(),
                                        column.dot(white) - column_taken.dot(taken(white))));
  }
  return log_sum(logs) - std::log(1.0 * count * inputs_.size());
}

Factors Seen::factors(const Truth& truth) const {
  Factors result;
  const auto& parameters = problem_.parameters;
  int own_column = -1;
  MatrixXd columns = columns_;
  VectorXd signal;
  if (truth.parameter.missing) {
    if (inputs_.empty()) return result;
    const Parameter p = on_model(truth.parameter, model_);
    VectorXd none = VectorXd::Zero(1);
    const MatrixXd column = response_->linearise(model_.machine, {p}, none, false).sensitivity;
    signal = whitener_->whiten(problem_.fitted(column)) * truth.value;
  } else {
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (same_cause(parameters[i], truth.parameter)) own_column = i;
    if (own_column < 0 || truth.value == truth.parameter.nominal) return result;
    columns.col(own_column) = secant(truth);
    signal = columns.col(own_column) * (truth.value - truth.parameter.nominal);
  }
  const diagnosis::LinearEvidence evidence(columns, signal, problem_.prior_std);
  double own = 0.0, rival = 0.0;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double width[] = {parameters[i].cause_std};
    const int which[] = {static_cast<int>(i)};
    const double log = evidence.widen(which, width).log_ratio;
    if (which[0] == own_column)
      own = log;
    else if (log > rival)
      rival = log, result.rival = name_of(parameters[i].kind) + " " + parameters[i].where;
  }
  if (!inputs_.empty()) {
    const MatrixXd spots = of_spots(signal);
    const double all = std::log(spots.size());
    std::vector<double> elsewhere;
    for (Index j = 0; j < spots.cols(); ++j) {
      for (Index k = 0; k < spots.rows(); ++k) {
        if (!truth.parameter.missing || inputs_[j].channel != truth.parameter.missing->follows ||
            apart(patches_[k], truth) > same_place_m)
          elsewhere.push_back(spots(k, j));
      }
    }
    if (truth.parameter.missing) own = std::max(at_its_place(truth, signal), -50.0);
    if (const double log = log_sum(elsewhere) - all; log > rival)
      rival = log, result.rival = "source_missing elsewhere";
  }
  result.against_none = 2.0 * own;
  result.against_rival = 2.0 * (own - rival);
  return result;
}

Factors Seen::factors_beside(const Truth& truth, const Truth& other) const {
  const auto& parameters = problem_.parameters;
  const auto column_of = [&](const Truth& of) {
    if (of.parameter.missing) return -1;
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (same_cause(parameters[i], of.parameter)) return static_cast<int>(i);
    return -1;
  };
  Factors result;
  const int own = column_of(truth), beside = column_of(other);
  if (own < 0 || beside < 0 || own == beside || truth.value == truth.parameter.nominal ||
      other.value == other.parameter.nominal)
    return result;
  MatrixXd columns = columns_;
  columns.col(own) = secant(truth);
  columns.col(beside) = secant(other);
  const VectorXd signal = columns.col(own) * (truth.value - truth.parameter.nominal) +
                          columns.col(beside) * (other.value - other.parameter.nominal);
  const diagnosis::LinearEvidence evidence(columns, signal, problem_.prior_std);
  const auto std_of = [&](int i) { return parameters[i].cause_std; };
  const auto pair = [&](int i) {
    const int which[] = {beside, i};
    const double width[] = {std_of(beside), std_of(i)};
    return evidence.widen(which, width).log_ratio;
  };
  const int alone[] = {beside};
  const double width[] = {std_of(beside)};
  const double without = evidence.widen(alone, width).log_ratio, with = pair(own);
  double rival = without;
  for (int i = 0; i < std::ssize(parameters); ++i) {
    if (i == own || i == beside) continue;
    if (const double log = pair(i); log > rival)
      rival = log, result.rival = name_of(parameters[i].kind) + " " + parameters[i].where;
  }
  result.against_none = 2.0 * (with - without);
  result.against_rival = 2.0 * (with - rival);
  return result;
}

Factors Expectations::of(const Truth& truth, const std::string& load) {
  std::unique_ptr<Seen>& seen = seen_[load];
  if (!seen) {
    Draw clean;
    clean.load = load;
    clean.seed = 1;
    seen = std::make_unique<Seen>(model_, specimen_.measure(clean), specimen_.followable(load), how_);
  }
  return seen->factors(truth);
}

}  // namespace thermotwin::hidden
