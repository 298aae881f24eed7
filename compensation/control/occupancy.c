/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/occupancy.h"

#include <math.h>

#include "compensation/control/linear.h"
#include "compensation/control/scalars.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

static const double turn = 2.0 * TT_PI;

/* Adds scale times the integrals over [a, b] of the two hat functions of the cell [left, right]. */
static void add_cell(double left, double right, double a, double b, double scale, double* at_left, double* at_right) {
  const double length = right - left, width = b - a;
  const double to_right = width * (0.5 * (a + b) - left) / length;
  *at_left += scale * (width - to_right);
  *at_right += scale * to_right;
}

static void linear_occupancy(int n, const double* x, double low, double high, double* weights) {
  if (high - low <= 1e-12 * (1.0 + fabs(low))) {
    const double p = tt_clamp(low, x[0], x[n - 1]);
    int cell = 0;
    while (cell < n - 2 && x[cell + 1] <= p) ++cell;
    const double s = (p - x[cell]) / (x[cell + 1] - x[cell]);
    weights[cell] += 1.0 - s;
    weights[cell + 1] += s;
    return;
  }
  const double scale = 1.0 / (high - low);
  /* Beyond the grid the matrices of its end hold. */
  weights[0] += scale * tt_max(0.0, tt_min(high, x[0]) - low);
  weights[n - 1] += scale * tt_max(0.0, high - tt_max(low, x[n - 1]));
  for (int i = 0; i + 1 < n; ++i) {
    const double a = tt_max(low, x[i]), b = tt_min(high, x[i + 1]);
    if (b > a) add_cell(x[i], x[i + 1], a, b, scale, weights + i, weights + i + 1);
  }
}

static double place(int n, const double* x, int i) { return x[i % n] + (i >= n ? turn * (i / n) : 0.0); }

static void periodic_occupancy(int n, const double* x, double low, double high, double* weights) {
  const double span = high - low;
  const double start = low - turn * floor((low - x[0]) / turn); /* from x0 to x0 + turn */
  if (span <= 1e-12 * turn) {
    for (int i = 0; i < n; ++i) {
      const double here = place(n, x, i), next = place(n, x, i + 1);
      if (start > next) continue;
      const double s = tt_max(0.0, (start - here) / (next - here));
      weights[i] += 1.0 - s;
      weights[(i + 1) % n] += s;
      return;
    }
    weights[0] += 1.0;
    return;
  }
  const double whole = floor(span / turn);
  for (int i = 0; whole > 0.0 && i < n; ++i) {
    const double here = place(n, x, i), next = place(n, x, i + 1);
    add_cell(here, next, here, next, whole / span, weights + i, weights + (i + 1) % n);
  }
  const double end = start + (span - whole * turn);
  for (int i = 0; i < 2 * n; ++i) {
    const double here = place(n, x, i), next = place(n, x, i + 1);
    const double a = tt_max(start, here), b = tt_min(end, next);
    if (b > a) add_cell(here, next, a, b, 1.0 / span, weights + i % n, weights + (i + 1) % n);
  }
}

void tt_grid_occupancy(const tt_model* m, int joint, double low, double high, double* weights) {
  const int first = m->joint_grid_first[joint], n = m->joint_grid_first[joint + 1] - first;
  const double* x = m->joint_positions + first;
  if (n < 2) {
    for (int i = 0; i < n; ++i) weights[i] = 1.0;
    return;
  }
  tt_zero(n, weights);
  if (high < low) {
    const double kept = low;
    low = high;
    high = kept;
  }
  if (m->joint_periodic[joint])
    periodic_occupancy(n, x, low, high, weights);
  else
    linear_occupancy(n, x, low, high, weights);
}
