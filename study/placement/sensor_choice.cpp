// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/placement/sensor_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/progress.h"
#include "core/range.h"
#include "core/thread_pool.h"

namespace thermotwin::study {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void ChoiceOptions::validate() const {
  core::require_within("sensors: noise_K", noise_K, {1e-6, 100.0});
  core::require_within("sensors: bias_K", bias_K, {0.0, 100.0});
  core::require_within("sensors: exchanges", exchanges, {0.0, 1000.0});
}

SensorChoice::SensorChoice(const std::vector<LoadResponses>& loads, const std::vector<UncertainParameter>& parameters,
                           const MatrixXd& places, const MatrixXd& tcp, const ChoiceOptions& options)
    : options_(options),
      places_(options.choosable < 0 ? places.rows() : options.choosable),
      parameters_(std::ssize(parameters)) {
  options.validate();
  const double poses = static_cast<double>(tcp.rows()) / 3.0;
  for (const LoadResponses& load : loads) {
    double before = 0.0;
    for (std::size_t t = 0; t < load.times.size(); ++t) {
      Time time;
      time.places = places * load.states[t];
      const MatrixXd errors = tcp * load.states[t];
      time.tcp = errors.transpose() * errors / poses;
      time.decay.resize(parameters_);
      for (Index p = 0; p < parameters_; ++p)
        time.decay[p] = std::exp(-(load.times[t] - before) / parameters[p].memory);
      time.first = t == 0;
      before = load.times[t];
      times_.push_back(std::move(time));
    }
  }
}

double SensorChoice::left_um(const std::vector<int>& sensors) const {
  const Index k = std::ssize(sensors), size = parameters_ + k;
  MatrixXd p(size, size);
  VectorXd row(size), gain(size);
  double sum = 0.0;
  for (const Time& time : times_) {
    if (time.first) {
      p.setIdentity();
      p.bottomRightCorner(k, k) *= options_.bias_K * options_.bias_K;
    } else {
      p.topRows(parameters_).array().colwise() *= time.decay.array();
      p.leftCols(parameters_).array().rowwise() *= time.decay.array().transpose();
      p.diagonal().head(parameters_).array() += 1.0 - time.decay.array().square();
    }
    for (Index s = 0; s < k; ++s) {
      row.head(parameters_) = time.places.row(sensors[s]).transpose();
      row.tail(k).setZero();
      row[parameters_ + s] = 1.0;
      gain.noalias() = p * row;
      const double variance = row.dot(gain) + options_.noise_K * options_.noise_K;
      p.noalias() -= gain * (gain.transpose() / variance);
    }
    sum += time.tcp.cwiseProduct(p.topLeftCorner(parameters_, parameters_)).sum();
  }
  return std::sqrt(std::max(sum, 0.0) / std::max<double>(1.0, static_cast<double>(times_.size())));
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
