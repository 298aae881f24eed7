// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/placement/sensor_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
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
      time.decay.resize(parameters_);
      const double interval = load.times[t] - before;
      for (Index p = 0; p < parameters_; ++p) time.decay[p] = std::exp(-interval / parameters[p].memory);
      time.noise = VectorXd::Constant(places.rows(), options.noise_K * options.noise_K);
      if (l < errors.size()) {
        const ModelErrors& of = errors[l];
        for (Index i = 0; i < places.rows(); ++i)
          time.noise[i] += std::pow(compensation::reading_std(0.0, of.changes_K[t][i]), 2);
        time.noise *= std::max(1.0, correlation_s / interval);
        if (!of.places_K.empty()) {
          time.mesh_K = of.places_K[t];
          time.mesh_um2 = of.tcp_um[t].squaredNorm() / poses;
        }
      }
      time.first = t == 0;
      before = load.times[t];
      times_.push_back(std::move(time));
    }
  }
}

Left SensorChoice::left(const std::vector<int>& sensors) const {
  const Index k = std::ssize(sensors), size = parameters_ + k;
  MatrixXd p(size, size);
  VectorXd row(size), gain(size), mistaken = VectorXd::Zero(size);
  double variance_um2 = 0.0, mesh_um2 = 0.0;
  for (const Time& time : times_) {
    if (time.first) {
      p.setIdentity();
      p.bottomRightCorner(k, k) *= options_.bias_K * options_.bias_K;
      mistaken.setZero();
    } else {
      p.topRows(parameters_).array().colwise() *= time.decay.array();
      p.leftCols(parameters_).array().rowwise() *= time.decay.array().transpose();
      p.diagonal().head(parameters_).array() += 1.0 - time.decay.array().square();
      mistaken.head(parameters_).array() *= time.decay.array();
    }
    for (Index s = 0; s < k; ++s) {
      row.head(parameters_) = time.places.row(sensors[s]).transpose();
      row.tail(k).setZero();
      row[parameters_ + s] = 1.0;
      gain.noalias() = p * row;
      const double variance = row.dot(gain) + time.noise[sensors[s]];
      if (time.mesh_K.size() > 0) mistaken += gain * ((time.mesh_K[sensors[s]] - row.dot(mistaken)) / variance);
      p.noalias() -= gain * (gain.transpose() / variance);
    }
    variance_um2 += time.tcp.cwiseProduct(p.topLeftCorner(parameters_, parameters_)).sum();
    if (time.mesh_K.size() == 0) continue;
    const auto found = mistaken.head(parameters_);
    mesh_um2 += time.mesh_um2 + found.dot(time.tcp * found);
  }
  const double count = std::max<double>(1.0, times_.size());
  return {std::sqrt(std::max(variance_um2, 0.0) / count), std::sqrt(std::max(mesh_um2, 0.0) / count)};
}

double SensorChoice::left_after_loss_um(const std::vector<int>& sensors) const {
  double worst = 0.0;
  for (std::size_t lost = 0; lost < sensors.size(); ++lost) {
    std::vector<int> rest = sensors;
    rest.erase(rest.begin() + lost);
    worst = std::max(worst, left_um(rest));
  }
  return worst;
}

double SensorChoice::criterion(const std::vector<int>& sensors) const {
  return options_.any_loss ? left_after_loss_um(sensors) : left_um(sensors);
}

std::vector<int> SensorChoice::greedy(int count, const std::vector<int>& taken) const {
  std::vector<int> sensors = taken;
  core::Progress progress("choosing sensors", std::max<Index>(1, count - std::ssize(taken)));
  while (std::ssize(sensors) < count) {
    VectorXd left = VectorXd::Constant(places_, std::numeric_limits<double>::infinity());
    core::parallel_for(0, places_, [&](std::size_t place) {
      const int index = place;
      if (std::find(sensors.begin(), sensors.end(), index) != sensors.end()) return;
      std::vector<int> with = sensors;
      with.push_back(index);
      left[index] = left_um(with);
    });
    Index best = 0;
    if (!std::isfinite(left.minCoeff(&best))) break;  // every place has a sensor
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
      if (const double without = criterion(rest); without < left) left = without, least = i;
    }
    more.erase(more.begin() + least);
  }
  const std::vector<int> second = exchanged(std::move(more));
  return criterion(second) < criterion(first) ? second : first;
}

std::vector<int> SensorChoice::exchanged(std::vector<int> sensors, int fixed) const {
  double now = criterion(sensors);
  for (int pass = 0; pass < options_.exchanges; ++pass) {
    bool changed = false;
    core::Progress progress("exchanging sensors", std::max<std::size_t>(1, sensors.size()));
    for (std::size_t s = fixed; s < sensors.size(); ++s) {
      VectorXd left = VectorXd::Constant(places_, std::numeric_limits<double>::infinity());
      core::parallel_for(0, places_, [&](std::size_t place) {
        const int index = place;
        if (std::find(sensors.begin(), sensors.end(), index) != sensors.end()) return;
        std::vector<int> with = sensors;
        with[s] = index;
        left[index] = criterion(with);
      });
      Index best = 0;
      const double least = left.minCoeff(&best);
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
