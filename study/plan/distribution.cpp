// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/plan/distribution.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <utility>

namespace thermotwin::study {
Distribution Distribution::fixed(std::vector<double> values) {
  Distribution made;
  made.spread = Spread::values;
  made.values = std::move(values);
  return made;
}

Distribution Distribution::uniform(double low, double high) {
  Distribution made;
  made.spread = Spread::uniform;
  made.low = low;
  made.high = high;
  return made;
}

Distribution Distribution::normal(double mean, double std) {
  Distribution made;
  made.spread = Spread::normal;
  made.mean = mean;
  made.std = std;
  made.low = mean - most_deviations * std;
  made.high = mean + most_deviations * std;
  return made;
}

double Distribution::at(double share) const {
  if (spread == Spread::values) {
    const auto place = static_cast<std::size_t>(share * values.size());
    return values[std::min(place, values.size() - 1)];
  }
  if (spread == Spread::uniform) return low + share * (high - low);
  const boost::math::normal standard;
  const double outside = boost::math::cdf(standard, -most_deviations);
  const double deviations = boost::math::quantile(standard, outside + share * (1.0 - 2.0 * outside));
  return std::clamp(mean + std * deviations, low, high);
}

Polynomials::Polynomials(const Distribution& distribution) {
  constexpr int points = 2000;
  std::vector<double> x(points);
  for (int i = 0; i < points; ++i) x[i] = distribution.at((i + 0.5) / points);
  double sum = 0.0, squares = 0.0, third = 0.0, fourth = 0.0;
  for (const double value : x) sum += value;
  centre = sum / points;
  for (const double value : x) squares += (value - centre) * (value - centre);
  scale = squares > 0.0 ? std::sqrt(squares / points) : 1.0;
  for (const double value : x) {
    const double p = first(value);
    third += p * p * p / points;
    fourth += p * p * p * p / points;
  }
  linear = third;
  square = std::sqrt(std::max(fourth - third * third - 1.0, 1e-12));
}

}  // namespace thermotwin::study
