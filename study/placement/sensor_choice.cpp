// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/placement/sensor_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "compensation/online/work_before.h"
#include "core/progress.h"
#include "core/range.h"
#include "core/thread_pool.h"

namespace thermotwin::study {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double correlation_s = 1800.0;  ///< of what the model gets wrong at a sensor, as in the observer
constexpr std::size_t joined_steps = 4;   ///< a screening counts their readings at the last of them
constexpr Index promising_share = 10;     ///< one place in so many is judged along all steps

}  // namespace

void ChoiceOptions::validate() const {
  core::require_within("sensors: noise_K", noise_K, {1e-6, 100.0});
  core::require_within("sensors: bias_K", bias_K, {0.0, 100.0});
  core::require_within("sensors: exchanges", exchanges, {0.0, 1000.0});
}

double Left::all_um() const { return std::hypot(parameters_um, mesh_um); }

SensorChoice::SensorChoice(const std::vector<LoadResponses>& loads, const std::vector<UncertainParameter>& parameters,
                           const MatrixXd& places, const MatrixXd& tcp, const ChoiceOptions& options,
                           const std::vector<ModelErrors>& errors)
    : options_(options),
      places_(options.choosable < 0 ? places.rows() : options.choosable),
      parameters_(std::ssize(parameters)) {
  options.validate();
  const double poses = tcp.rows() / 3.0;
  for (std::size_t l = 0; l < loads.size(); ++l) {
    const LoadResponses& load = loads[l];
    double before = 0.0;
    for (std::size_t t = 0; t < load.times.size(); ++t) {
      Time time;
      time.places = places * load.states[t];
      const MatrixXd moved = tcp * load.states[t];
      time.tcp = moved.transpose() * moved / poses;
      Step step;
      step.time = times_.size();
      step.first = t == 0;
      step.decay.resize(parameters_);
      step.prior = load.prior.size() > 0 ? load.prior.cwiseAbs2() : VectorXd(VectorXd::Ones(parameters_));
      const double interval = load.times[t] - before;
      for (Index p = 0; p < parameters_; ++p) step.decay[p] = std::exp(-interval / parameters[p].memory);
      step.noise = VectorXd::Constant(places.rows(), options.noise_K * options.noise_K);
      if (l < errors.size()) {
        const ModelErrors& of = errors[l];
        for (Index i = 0; i < places.rows(); ++i)
          step.noise[i] += std::pow(compensation::reading_std(0.0, of.changes_K[t][i]), 2);
        step.noise *= std::max(1.0, correlation_s / interval);
        const auto meshes = std::ssize(of.meshes);
        time.mesh_K.resize(places.rows(), meshes);
        time.cross.resize(parameters_, meshes);
        for (Index k = 0; k < meshes; ++k) {
          time.mesh_K.col(k) = of.meshes[k].places_K[t];
          time.cross.col(k) = moved.transpose() * of.meshes[k].tcp_um[t] / poses;
          time.mesh_um2 += of.meshes[k].tcp_um[t].squaredNorm() / poses / static_cast<double>(meshes);
        }
      }
      before = load.times[t];
      times_.push_back(std::move(time));
      if (t % joined_steps == 0) {
        fewer_steps_.push_back(step);
      } else {
        Step& joined = fewer_steps_.back();
        joined.time = step.time;
        joined.decay.array() *= step.decay.array();
        joined.noise = (joined.noise.cwiseInverse() + step.noise.cwiseInverse()).cwiseInverse();
      }
      steps_.push_back(std::move(step));
    }
  }
}

Left SensorChoice::left(const std::vector<int>& sensors, const Steps& steps) const {
  const Index k = std::ssize(sensors), size = parameters_ + k;
  MatrixXd p(size, size);
  const Index meshes = times_.empty() ? 0 : times_.front().mesh_K.cols();
  VectorXd row(size), gain(size);
  MatrixXd mistaken = MatrixXd::Zero(size, meshes);
  double variance_um2 = 0.0, mesh_um2 = 0.0;
  for (const Step& step : steps) {
    const Time& time = times_[step.time];
    if (step.first) {
      p.setZero();
      p.diagonal().head(parameters_) = step.prior;
      p.diagonal().tail(k).setConstant(options_.bias_K * options_.bias_K);
      mistaken.setZero();
    } else {
      p.topRows(parameters_).array().colwise() *= step.decay.array();
      p.leftCols(parameters_).array().rowwise() *= step.decay.array().transpose();
      p.diagonal().head(parameters_).array() += (1.0 - step.decay.array().square()) * step.prior.array();
      mistaken.topRows(parameters_).array().colwise() *= step.decay.array();
    }
    for (Index s = 0; s < k; ++s) {
      row.head(parameters_) = time.places.row(sensors[s]).transpose();
      row.tail(k).setZero();
      row[parameters_ + s] = 1.0;
      gain.noalias() = p * row;
      const double variance = row.dot(gain) + step.noise[sensors[s]];
      if (meshes > 0) mistaken += gain * ((time.mesh_K.row(sensors[s]) - row.transpose() * mistaken) / variance);
      p.noalias() -= gain * (gain.transpose() / variance);
    }
    variance_um2 += time.tcp.cwiseProduct(p.topLeftCorner(parameters_, parameters_)).sum();
    if (meshes == 0) continue;
    const auto found = mistaken.topRows(parameters_);
    mesh_um2 +=
        time.mesh_um2 + found.cwiseProduct(time.tcp * found - 2.0 * time.cross).sum() / static_cast<double>(meshes);
  }
  const double count = std::max<double>(1.0, steps.size());
  return {std::sqrt(std::max(variance_um2, 0.0) / count), std::sqrt(std::max(mesh_um2, 0.0) / count)};
}

double SensorChoice::after_loss_um(const std::vector<int>& sensors, const Steps& steps) const {
  double worst = 0.0;
  for (std::size_t lost = 0; lost < sensors.size(); ++lost) {
    std::vector<int> rest = sensors;
    rest.erase(rest.begin() + lost);
    worst = std::max(worst, left(rest, steps).all_um());
  }
  return worst;
}

double SensorChoice::criterion(const std::vector<int>& sensors, const Steps& steps) const {
  return options_.any_loss ? after_loss_um(sensors, steps) : left(sensors, steps).all_um();
}

template <class With, class Value>
std::pair<int, double> SensorChoice::best_place(const With& with, const Value& value) const {
  constexpr double none = std::numeric_limits<double>::infinity();
  std::vector<int> judged(places_);
  std::iota(judged.begin(), judged.end(), 0);
  std::erase_if(judged, [&](int place) { return with(place).empty(); });
  const auto along = [&](const Steps& steps) {
    std::vector<double> left(places_, none);
    core::parallel_for(0, judged.size(), [&](std::size_t i) { left[judged[i]] = value(with(judged[i]), steps); });
    return left;
  };
  if (places_ > options_.all_times_from) {
    const std::vector<double> about = along(fewer_steps_);
    const std::size_t kept = std::max<Index>(options_.all_times_from, places_ / promising_share);
    std::stable_sort(judged.begin(), judged.end(), [&](int a, int b) { return about[a] < about[b]; });
    judged.resize(std::min(judged.size(), kept));
  }
  const std::vector<double> left = along(steps_);
  const auto least = std::min_element(left.begin(), left.end());
  return least == left.end() ? std::pair{0, none} : std::pair{static_cast<int>(least - left.begin()), *least};
}

std::vector<int> SensorChoice::greedy(int count, const std::vector<int>& taken) const {
  std::vector<int> sensors = taken;
  core::Progress progress("choosing sensors", std::max<Index>(1, count - std::ssize(taken)));
  while (std::ssize(sensors) < count) {
    const auto with = [&](int place) {
      if (std::find(sensors.begin(), sensors.end(), place) != sensors.end()) return std::vector<int>{};
      std::vector<int> more = sensors;
      more.push_back(place);
      return more;
    };
    const auto [best, least] =
        best_place(with, [&](const std::vector<int>& more, const Steps& steps) { return left(more, steps).all_um(); });
    if (!std::isfinite(least)) break;  // every place has a sensor
    sensors.push_back(best);
    progress.advance();
  }
  return sensors;
}

std::vector<int> SensorChoice::chosen(const std::vector<int>& greedy) const {
  const std::vector<int> first = exchanged(greedy);
  std::vector<int> more = this->greedy(std::min<Index>(std::ssize(greedy) + 3, places_), greedy);
  while (more.size() > greedy.size()) {
    std::size_t least = 0;
    double left = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < more.size(); ++i) {
      std::vector<int> rest = more;
      rest.erase(rest.begin() + i);
      if (const double without = criterion(rest, steps_); without < left) left = without, least = i;
    }
    more.erase(more.begin() + least);
  }
  const std::vector<int> second = exchanged(std::move(more));
  return criterion(second, steps_) < criterion(first, steps_) ? second : first;
}

std::vector<int> SensorChoice::exchanged(std::vector<int> sensors, int fixed) const {
  double now = criterion(sensors, steps_);
  for (int pass = 0; pass < options_.exchanges; ++pass) {
    bool changed = false;
    core::Progress progress("exchanging sensors", std::max<std::size_t>(1, sensors.size()));
    for (std::size_t s = fixed; s < sensors.size(); ++s) {
      const auto with = [&](int place) {
        if (std::find(sensors.begin(), sensors.end(), place) != sensors.end()) return std::vector<int>{};
        std::vector<int> other = sensors;
        other[s] = place;
        return other;
      };
      const auto [best, least] =
          best_place(with, [&](const std::vector<int>& other, const Steps& steps) { return criterion(other, steps); });
      if (least < (1.0 - 1e-6) * now) {
        sensors[s] = best;
        now = least;
        changed = true;
      }
      progress.advance();
    }
    if (!changed) break;
  }
  return sensors;
}

}  // namespace thermotwin::study
