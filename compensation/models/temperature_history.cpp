// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/temperature_history.h"

#include <cmath>

namespace thermotwin::compensation {

void TemperatureHistory::add(double time, double value) {
  if (cells_.empty() || time - begin_ >= cell_s) {
    // After a long gap what came before says nothing about the filters; the mean starts anew.
    if (!cells_.empty() && time - begin_ > longest_s) cells_.clear();
    const double cells = cells_.empty() ? 1.0 : std::floor((time - begin_) / cell_s);
    for (double i = 1.0; i < cells; ++i) cells_.push_front(cells_.front());  // a gap: as before
    begin_ = cells_.empty() ? time : begin_ + cells * cell_s;
    cells_.push_front({0.0, 0.0});
    while (cells_.size() * cell_s > longest_s) cells_.pop_back();
  }
  cells_.front().first += value;
  cells_.front().second += 1.0;
}

double TemperatureHistory::mean() const {
  double sum = 0.0;
  for (const auto& [total, count] : cells_) sum += total / count;
  return sum / cells_.size();
}

double TemperatureHistory::filtered(double sigma) const {
  double sum = 0.0, weights = 0.0, oldest = 0.0;
  for (double k = 0.0; k * cell_s < 4.0 * sigma; k += 1.0) {
    const double weight = std::exp(-0.5 * std::pow(k * cell_s / sigma, 2));
    if (k < cells_.size()) {
      const auto& [sum_of_cell, count] = cells_[static_cast<std::size_t>(k)];
      oldest = sum_of_cell / count;
    }
    sum += weight * oldest;
    weights += weight;
  }
  return sum / weights;
}

}  // namespace thermotwin::compensation
