/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/special.h"

#include "compensation/control/scalars.h"

double tt_expm1(double x) {
  if (x > 0.5 || x < -0.5) return tt_exp(x) - 1.0;
  /* x + x^2 / 2 + ... + x^15 / 15! */
  double sum = 1.0;
  for (int k = 15; k >= 2; --k) sum = 1.0 + sum * x / k;
  return sum * x;
}

double tt_erfc(double x) {
  const double root_pi = 1.77245385090551602730;
  if (x > 26.0) return 0.0;
  const double bell = tt_exp(-x * x);
  if (x < 1.5) {
    double term = x, sum = x;
    for (int k = 1; k < 60; ++k) {
      term *= 2.0 * x * x / (2 * k + 1);
      sum += term;
    }
    return 1.0 - 2.0 / root_pi * bell * sum;
  }
  double below = x;
  for (int k = 120; k >= 1; --k) below = x + 0.5 * k / below;
  return bell / (root_pi * below);
}

double tt_nth_smallest(int n, const double* values, int nth) {
  for (int i = 0; i < n; ++i) {
    int before = 0;
    for (int j = 0; j < n; ++j) before += values[j] < values[i] || (values[j] == values[i] && j < i);
    if (before == nth) return values[i];
  }
  return tt_nan();
}

double tt_median(int n, const double* values) { return tt_nth_smallest(n, values, n / 2); }
