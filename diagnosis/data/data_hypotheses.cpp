// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/data/data_hypotheses.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/first_order_lag.h"
#include "core/units.h"
#include "diagnosis/inference/evidence.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using core::units::hour;

constexpr double day = 24.0 * hour;
constexpr double daily_days = 3.0;  ///< length of a record that tells a daily swing from a drift
constexpr int drift_starts = 48;    ///< of a drift, evenly over the segments that are fitted
constexpr double gain_width = 2.0;  ///< prior of a slow element's gain: this times target's spread over input's spread
constexpr double slower[] = {2.0, 4.0};  ///< time constants of slow elements, times the longest of the model
constexpr double unknown_sizes[] = {0.03, 0.1, 0.3,
                                    1.0};  ///< of what wanders for no known reason, of the target's size
constexpr double unknown_times[] = {3600, 10800, 43200, 172800};  ///< s

/// Further columns with their priors; value: what names the variant (start of a drift, time constant), s.
struct Variant {
  MatrixXd columns;
  VectorXd prior_std;
  double value = 0;
};

/// The rows that are fitted, with the model's columns.
class Fitted {
public:
  Fitted(const DataRecord& record, const LagModel& model, const MatrixXd& columns, const VectorXd& value,
         std::vector<Index> rows)
      : model_(model),
        columns_(columns),
        value_(value),
        rows_(std::move(rows)),
        left_over_(model.left_over(record, rows_)),
        white_({left_over_}) {}

  struct Result {
    double log_evidence = 0;
    VectorXd predicted, mean, std;  ///< (n); of the added gains
  };
  Result with(const Variant& variant) const {
    const Index own = columns_.cols(), added = variant.columns.cols();
    MatrixXd all(columns_.rows(), own + added);
    all << columns_, variant.columns;
    VectorXd prior(own + added);
    prior << model_.prior_std, variant.prior_std;
    const LinearEvidence evidence(white_.whiten(MatrixXd(all(rows_, Eigen::all))), white_.whiten(value_(rows_)), prior);
    return {evidence.log_evidence() - 0.5 * white_.log_determinant(), all * evidence.mean(),
            evidence.mean().tail(added), evidence.covariance().diagonal().tail(added).cwiseMax(0.0).cwiseSqrt()};
  }
  /// With something that wanders for no known reason.
  double log_evidence_of(const OrnsteinUhlenbeck& unknown) const {
    ChannelCovariance wide = left_over_;
    wide.wander.push_back(unknown);
    const Whitener white({wide});
    const LinearEvidence evidence(white.whiten(MatrixXd(columns_(rows_, Eigen::all))), white.whiten(value_(rows_)),
                                  model_.prior_std);
    return evidence.log_evidence() - 0.5 * white.log_determinant();
  }

private:
  const LagModel& model_;
  const MatrixXd& columns_;
  const VectorXd& value_;
  std::vector<Index> rows_;
  ChannelCovariance left_over_;
  Whitener white_;
};

std::vector<Variant> drifts(const DataRecord& record, const RecordSegments& segments, double size) {
  std::vector<Variant> all;
  const double start = record.time[0] - 0.5 * record.interval, fitted = segments.last_start - start;
  // A drift that begins in the last intervals has no rows to show in.
  constexpr double rows_to_show = 3.0;
  const double latest = fitted - rows_to_show * record.interval;
  const int starts = std::clamp(static_cast<int>(latest / record.interval), 1, drift_starts);
  for (int i = 0; i < starts; ++i) {
    const double begins = latest * i / starts;
    all.push_back({((record.time.array() - start - begins).cwiseMax(0.0) / hour).matrix(),
                   VectorXd::Constant(1, size / 24.0), begins});
  }
  return all;
}

Variant daily_swing(const DataRecord& record, double size) {
  MatrixXd columns(record.time.size(), 4);
  const Eigen::ArrayXd angle = 2.0 * std::numbers::pi / day * record.time.array();
  columns << angle.sin().matrix(), angle.cos().matrix(), (2.0 * angle).sin().matrix(), (2.0 * angle).cos().matrix();
  return {columns, size * Eigen::Vector4d(0.5, 0.5, 0.25, 0.25), 0.0};
}

/// Elements of all inputs that are slower than the first part could show.
std::vector<Variant> slow_elements(const DataRecord& record, const LagModel& model, const std::vector<Index>& first,
                                   double size) {
  std::vector<Variant> all;
  const Index inputs = record.inputs.cols();
  for (const double factor : slower) {
    Variant slow{MatrixXd(record.time.size(), inputs), VectorXd(inputs),
                 factor * std::max(model.time_constants.back(), record.interval)};
    for (Index i = 0; i < inputs; ++i) {
      slow.columns.col(i) =
          core::lagged_lines(record.time, record.inputs.col(i).array() - record.inputs(0, i), slow.value);
      slow.prior_std[i] = gain_width * size / std::max(spread_of(record.inputs(first, i)), 1e-9);
    }
    all.push_back(std::move(slow));
  }
  return all;
}

/// Mean and standard deviation of a mixture.
struct Mixture {
  double weight = 0, sum = 0, square = 0;
  void add(double w, double mean, double std) {
    weight += w;
    sum += w * mean;
    square += w * (mean * mean + std * std);
  }
  double mean() const { return sum / weight; }
  double std() const { return std::sqrt(std::max(square / weight - mean() * mean(), 0.0)); }
};

/// All variants, weighed by their evidence.
Extension averaged(const Fitted& fitted, const std::vector<Variant>& variants, Kind kind, const std::string& name,
                   const std::string& unit) {
  Extension extension{kind, name, unit, 0, 0, 0, 0, 0, {}};
  std::vector<Fitted::Result> results;
  std::vector<double> logs;
  for (const Variant& variant : variants) {
    results.push_back(fitted.with(variant));
    logs.push_back(results.back().log_evidence);
  }
  extension.log_evidence = log_mean_exp(logs);
  Mixture value, begins;
  extension.predicted = VectorXd::Zero(results.front().predicted.size());
  const double total = extension.log_evidence + std::log(logs.size());
  for (std::size_t i = 0; i < variants.size(); ++i) {
    const double weight = std::exp(logs[i] - total);
    extension.predicted += weight * results[i].predicted;
    begins.add(weight, variants[i].value, 0.0);
    if (kind == Kind::time_constant) {
      value.add(weight, variants[i].value, variants[i].value / std::sqrt(12.0));
    }  // as wide as the steps between variants
    else if (results[i].mean.size() == 1)
      value.add(weight, results[i].mean[0], results[i].std[0]);
    else
      value.add(weight, results[i].mean.head(2).norm(), results[i].std.head(2).maxCoeff());
  }
  extension.value = value.mean();
  extension.std = value.std();
  extension.begins = begins.mean();
  return extension;
}

/// Of the residual after the first part, see the header.
double discrepancy_p_value(const DataRecord& record, const WeighedChannel& weighed, const MatrixXd& columns,
                           const std::vector<Index>& later) {
  const MatrixXd used = columns(later, Eigen::all);
  const Eigen::LLT<MatrixXd> factor(weighed.model.left_over(record, later).matrix() +
                                    used * weighed.model.covariance * used.transpose());
  const VectorXd white = factor.matrixL().solve(weighed.before(later));
  const double n = later.size(), fitted = weighed.model.fitted;
  const double variance = std::max(1.0, weighed.model.chi_square / fitted);
  const double all = f_tail(white.squaredNorm() / n / variance, n, fitted);
  MatrixXd slow(later.size(), 2);
  slow << VectorXd::Ones(slow.rows()), (record.time(later).array() - record.time[later.front()]).matrix() / hour;
  const MatrixXd directions = factor.matrixL().solve(slow);
  const VectorXd fit = directions.colPivHouseholderQr().solve(white);
  const double along = f_tail((directions * fit).squaredNorm() / 2.0 / variance, 2.0, fitted);
  return std::min(1.0, 2.0 * std::min(all, along));
}

}  // namespace

RecordSegments divide(const DataRecord& record) {
  const double start = record.time[0] - 0.5 * record.interval,
               length = record.time[record.time.size() - 1] - record.time[0];
  RecordSegments segments;
  const double part = length >= 2.25 * day ? day : length / 3.0;
  segments.first_end = start + part;
  segments.last_start = start + 2.0 * part;
  for (Index i = 0; i < record.time.size(); ++i) {
    (record.time[i] < segments.first_end    ? segments.first
     : record.time[i] < segments.last_start ? segments.middle
                                            : segments.last)
        .push_back(i);
  }
  return segments;
}

std::vector<Index> joined(const std::vector<Index>& a, const std::vector<Index>& b) {
  std::vector<Index> all = a;
  all.insert(all.end(), b.begin(), b.end());
  return all;
}

std::vector<Index> finite_rows(const VectorXd& values, const std::vector<Index>& rows) {
  std::vector<Index> good;
  for (const Index row : rows)
    if (std::isfinite(values[row])) good.push_back(row);
  return good;
}

WeighedChannel weigh_channel(const DataRecord& record, Index target, const RecordSegments& segments) {
  WeighedChannel weighed;
  const VectorXd value = record.targets.col(target);
  const std::vector<Index> first = finite_rows(value, segments.first), middle = finite_rows(value, segments.middle),
                           later = joined(middle, finite_rows(value, segments.last));
  weighed.model = fit_lag_model(record, target, first);
  const LagModel& model = weighed.model;
  const MatrixXd columns = model.columns(record);
  weighed.before = value - columns * model.gains;
  weighed.expected_std = ((columns * model.covariance).cwiseProduct(columns).rowwise().sum().array() +
                          model.wander_std * model.wander_std + model.noise_std.array().square())
                             .sqrt();
  // A model that fits its own part worse than stated foretells worse, too.
  weighed.expected_std *= std::sqrt(std::max(1.0, model.chi_square / model.fitted));
  weighed.expected = root_mean_square(weighed.expected_std(later));
  weighed.seen = root_mean_square(weighed.before(later));
  weighed.p_value = discrepancy_p_value(record, weighed, columns, later);

  const Fitted fitted(record, model, columns, value, joined(first, middle));
  const double size = std::max({root_mean_square(weighed.before(middle)), spread_of(value(first)), 1e-6});
  const std::string& unit = record.channels[target].unit;
  weighed.extensions.push_back(
      averaged(fitted, drifts(record, segments, size), Kind::probe_drift, "drift", unit + "/h"));
  if (record.time.size() * record.interval >= daily_days * day) {
    weighed.extensions.push_back(
        averaged(fitted, {daily_swing(record, size)}, Kind::unmeasured_temperature, "daily_amplitude", unit));
  }
  weighed.extensions.push_back(
      averaged(fitted, slow_elements(record, model, first, size), Kind::time_constant, "slowest", "s"));

  const double log_none = fitted.with({MatrixXd(record.time.size(), 0), VectorXd(0), 0.0}).log_evidence;
  std::vector<double> unknown;
  for (const double share : unknown_sizes)
    for (const double time : unknown_times) unknown.push_back(fitted.log_evidence_of({share * size, time}));
  const double log_unknown = log_mean_exp(unknown);
  weighed.unknown_log_evidence = log_unknown - log_none;
  std::vector<double> logs = {std::log(prior_none) + log_none, std::log(prior_unknown) + log_unknown};
  for (Extension& extension : weighed.extensions) {
    logs.push_back(std::log(prior_cause / weighed.extensions.size()) + extension.log_evidence);
    extension.log_evidence -= log_none;
  }
  const double total = log_mean_exp(logs) + std::log(logs.size());
  weighed.none = std::exp(logs[0] - total);
  weighed.unknown = std::exp(logs[1] - total);
  for (std::size_t i = 0; i < weighed.extensions.size(); ++i)
    weighed.extensions[i].probability = std::exp(logs[i + 2] - total);
  return weighed;
}

}  // namespace thermotwin::diagnosis
