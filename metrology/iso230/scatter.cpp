// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/iso230/scatter.h"

#include <algorithm>
#include <cmath>

#include "core/normal_draws.h"

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index draws = 400, least_sequences = 5;
constexpr Index least_values = 8;        ///< of a course that is smoothed
constexpr double like_the_least = 0.05;  ///< of the least misfit
constexpr double of_scatter = 1.07;      ///< relative uncertainty of a scatter from third differences, times sqrt(n)

double spread(const Eigen::Ref<const VectorXd>& values) { return values.maxCoeff() - values.minCoeff(); }

/// Moving straight line over 2 half + 1 values, fewer at the ends.
/// @param misfit  mean square of a value less the line of the others (leave one out)
VectorXd moving_line(const VectorXd& values, Index half, double& misfit) {
  const Index n = values.size();
  VectorXd sums = VectorXd::Zero(n + 1), moments = sums, course(n);
  for (Index i = 0; i < n; ++i) {
    sums[i + 1] = sums[i] + values[i];
    moments[i + 1] = moments[i] + 1.0 * i * values[i];
  }
  misfit = 0.0;
  for (Index i = 0; i < n; ++i) {
    const Index low = std::max<Index>(0, i - half), high = std::min(n - 1, i + half);
    const double count = high - low + 1, middle = 0.5 * (low + high), squares = count * (count * count - 1.0) / 12.0,
                 sum = sums[high + 1] - sums[low], moment = moments[high + 1] - moments[low] - middle * sum;
    course[i] = sum / count + moment / squares * (i - middle);
    const double own = 1.0 - 1.0 / count - (i - middle) * (i - middle) / squares;
    if (own > 1e-9) misfit += std::pow((values[i] - course[i]) / own, 2) / n;
  }
  return course;
}

}  // namespace

double scatter_of(const VectorXd& time, const VectorXd& values, double stated) {
  std::vector<Index> known;
  for (Index i = 0; i < values.size(); ++i)
    if (!std::isnan(values[i])) known.push_back(i);
  double squares = 0.0;
  Index count = 0;
  for (std::size_t first = 0; first + 3 < known.size(); ++first) {
    const Index* at = &known[first];
    double difference = 0.0, variance = 0.0;
    for (int i = 0; i < 4; ++i) {
      double weight = 1.0;
      for (int k = 0; k < 4; ++k)
        if (k != i) weight *= (time[at[3]] - time[at[0]]) / (time[at[i]] - time[at[k]]);
      difference += weight * values[at[i]];
      variance += weight * weight;
    }
    squares += difference * difference / variance;
    ++count;
  }
  if (count < least_sequences) return stated;
  const double found = std::sqrt(squares / (1.0 * count));
  return found < stated * (1.0 - 2.0 * of_scatter / std::sqrt(1.0 * count)) ? found : stated;
}

VectorXd smooth_course(const VectorXd& values) {
  const Index n = values.size();
  if (n < least_values) return values;
  std::vector<VectorXd> courses;
  std::vector<double> misfits;
  for (Index half = n; half > 0; half /= 2) {
    double misfit = 0.0;
    courses.push_back(moving_line(values, half, misfit));
    misfits.push_back(misfit);
  }
  const double limit = (1.0 + like_the_least) * *std::min_element(misfits.begin(), misfits.end());
  std::size_t longest = 0;
  while (misfits[longest] > limit) ++longest;
  return courses[longest];
}

std::vector<RangeOfMotion> ranges_of_motion(const VectorXd& values, const std::vector<Index>& firsts, double scatter,
                                            double stated) {
  const VectorXd course = scatter > 0.0 ? smooth_course(values) : values;
  const Eigen::Index kinds = std::ssize(firsts);
  Eigen::MatrixXd drawn = Eigen::MatrixXd::Zero(draws, kinds);
  core::NormalDraws normal(1);
  VectorXd one = course;
  for (Index draw = 0; draw < draws && scatter > 0.0; ++draw) {
    for (Index i = 0; i < one.size(); ++i) one[i] = course[i] + scatter * normal();
    for (Index k = 0; k < kinds; ++k)
      if (firsts[k] > 0) drawn(draw, k) = spread(one.head(firsts[k]));
  }
  const double systematic = 2.0 * std::max(0.0, stated * stated - scatter * scatter);
  std::vector<RangeOfMotion> ranges;
  for (Index k = 0; k < kinds; ++k) {
    RangeOfMotion found;
    if (firsts[k] > 0) {
      found.range = found.motion = spread(values.head(firsts[k]));
      double variance = 0.0;
      if (scatter > 0.0) {
        const double mean = drawn.col(k).mean();
        const double added = std::max(0.0, mean - spread(course.head(firsts[k])));
        found.motion = std::max(0.0, found.range - added);
        variance =
            (drawn.col(k).array() - mean).square().sum() / (draws - 1.0) + std::pow(added * of_scatter, 2) / firsts[k];
      }
      found.std = std::sqrt(variance + systematic);
    }
    ranges.push_back(found);
  }
  return ranges;
}

}  // namespace thermotwin::metrology
