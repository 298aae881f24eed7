// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The distribution of a parameter of a study, sampled by its quantile function.

#include <vector>

namespace thermotwin::study {

/// Largest deviation of a drawn value from the mean, in standard deviations: normal distributions are truncated there.
/// A machine with a larger deviation would have a defect.
inline constexpr double most_deviations = 2.5;

enum class Spread {
  values,   ///< fixed values, of which every combination is computed
  uniform,  ///< between low and high
  normal    ///< truncated at most_deviations
};

struct Distribution {
  Spread spread = Spread::normal;
  std::vector<double> values;  ///< fixed ones
  double low = 0, high = 0;    ///< of a uniform distribution, or bounds of the truncated normal one
  double mean = 0, std = 0;    ///< of the normal distribution before truncation

  static Distribution fixed(std::vector<double> values);
  static Distribution uniform(double low, double high);
  static Distribution normal(double mean, double std);

  bool is_drawn() const { return spread != Spread::values; }
  /// Quantile function. @param share  in (0, 1)
  double at(double share) const;
};

/// Polynomials of degree 1 and 2 that are orthonormal in a distribution, for regression.
struct Polynomials {
  double centre = 0, scale = 1;   ///< mean and standard deviation: p1(x) = (x - centre) / scale
  double linear = 0, square = 1;  ///< coefficients of p2 = (p1^2 - linear p1 - 1) / square

  explicit Polynomials(const Distribution& distribution);
  /// p1
  double first(double x) const { return (x - centre) / scale; }
  /// p2
  double second(double x) const {
    const double p = first(x);
    return (p * p - linear * p - 1.0) / square;
  }
};

}  // namespace thermotwin::study
