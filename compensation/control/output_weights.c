/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/output_weights.h"

#include <math.h>

#include "compensation/control/linear.h"
#include "compensation/control/scalars.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

enum { poses_more = 3, middle = poses_more + 1 }; /* on each half of a line; where its middle is */

/* The cell of rising positions that holds x, from 0 to n - 2. */
static int cell_of(int n, const double* x, double at) {
  int cell = 0;
  while (cell + 2 < n && at > x[cell + 1]) ++cell;
  return cell;
}

static void linear_weights(int n, const double* x, double at, double* weights) {
  tt_zero(n, weights);
  if (n == 1) {
    weights[0] = 1.0;
    return;
  }
  const double inside = tt_clamp(at, x[0], x[n - 1]);
  const int cell = cell_of(n, x, inside);
  const double share = (inside - x[cell]) / (x[cell + 1] - x[cell]);
  weights[cell] = 1.0 - share;
  weights[cell + 1] = share;
}

/* Quadratic for three positions; else straight lines. */
static void smooth_weights(int n, const double* x, double at, double* weights) {
  if (n != 3) {
    linear_weights(n, x, at, weights);
    return;
  }
  const double a = x[0], b = x[1], c = x[2], t = tt_clamp(at, a, c);
  weights[0] = (t - b) * (t - c) / ((a - b) * (a - c));
  weights[1] = (t - a) * (t - c) / ((b - a) * (b - c));
  weights[2] = (t - a) * (t - b) / ((c - a) * (c - b));
}

/* Cubic through the four positions about x. Returns the first. */
static int cubic_weights(int n, const double* x, double at, double weights[4]) {
  const double t = tt_clamp(at, x[0], x[n - 1]);
  const int cell = cell_of(n, x, t), before = cell == 0 ? 0 : cell - 1, first = before < n - 4 ? before : n - 4;
  for (int i = 0; i < 4; ++i) {
    double product = 1.0;
    for (int j = 0; j < 4; ++j) {
      if (j != i) product *= (t - x[first + j]) / (x[first + i] - x[first + j]);
    }
    weights[i] = product;
  }
  return first;
}

static double half_sine(double angle) { return tt_sin(0.5 * angle); }

/* Exact for 1, cosine and sine through three angles. */
static void swivel_weights(int n, const double* x, double at, int endless, double* weights) {
  const double turn = 2.0 * TT_PI;
  if (n == 1) {
    weights[0] = 1.0;
    return;
  }
  const double last = endless ? x[0] + turn : x[n - 1];
  const int closed = endless ? n + 1 : n;
  if (endless) at -= turn * floor((at - x[0]) / turn);
  const double t = tt_clamp(at, x[0], last);
  int cell = 0;
  while (cell + 2 < closed && t > x[cell + 1]) ++cell;
  tt_zero(n, weights);
  if (n == 2) {
    const double from = x[cell], to = cell + 1 < n ? x[cell + 1] : last, share = (t - from) / (to - from);
    weights[cell % 2] += 1.0 - share;
    weights[(cell + 1) % 2] += share;
    return;
  }
  const int used[3] = {cell % n, (cell + 1) % n, cell > 0 ? cell - 1 : endless ? n - 1 : 2};
  for (int i = 0; i < 3; ++i) {
    const double own = x[used[i]], a = x[used[(i + 1) % 3]], b = x[used[(i + 2) % 3]];
    weights[used[i]] = half_sine(t - a) * half_sine(t - b) / (half_sine(own - a) * half_sine(own - b));
  }
}

typedef struct grid {
  int axes;
  const int32_t *axis, *linear, *endless, *first;
  const double* positions;
} grid;

static grid tool_grid(const tt_model* m) {
  const grid g = {m->tool_grid, m->tool_axis, m->tool_linear, m->tool_endless, m->tool_first, m->tool_positions};
  return g;
}

/* Kronecker product, first axis slowest. */
static void weights_on(grid g, const double* pose, double* weights) {
  double own[TT_MOST_POSITIONS];
  int count = 1;
  weights[0] = 1.0;
  for (int k = 0; k < g.axes; ++k) {
    const int n = g.first[k + 1] - g.first[k];
    const double *x = g.positions + g.first[k], at = pose[g.axis[k]];
    if (g.linear[k])
      smooth_weights(n, x, at, own);
    else
      swivel_weights(n, x, at, g.endless[k], own);
    for (int i = count - 1; i >= 0; --i) {
      const double outer = weights[i];
      for (int j = 0; j < n; ++j) weights[i * n + j] = outer * own[j];
    }
    count *= n;
  }
}

static double upper_share(double x, double low, double high) { return (tt_clamp(x, low, high) - low) / (high - low); }

/* Between the outer lines straight; the middle one takes what its quadratics do, where there is one. */
static double line_share(const tt_model* m, int line, const double* pose) {
  double straight = 1.0, in_middle = 1.0, bubble = 1.0;
  const int axes = m->tool_grid, along = m->line_axis[line];
  int is_middle = axes > 1;
  for (int k = 0; k < axes; ++k) {
    const int n = m->tool_first[k + 1] - m->tool_first[k], at = m->line_at[line * axes + k];
    const double *x = m->tool_positions + m->tool_first[k], here = pose[m->tool_axis[k]];
    if (k == along || n == 1) continue;
    const double share = upper_share(here, x[0], x[n - 1]);
    straight *= at == 0 ? 1.0 - share : share;
    is_middle = is_middle && at == 1 && n == 3;
    if (!m->has_middle) continue;
    const double of_middle = upper_share(x[1], x[0], x[n - 1]);
    double smooth[3];
    smooth_weights(n, x, here, smooth);
    in_middle *= at == 0 ? 1.0 - of_middle : of_middle;
    bubble *= smooth[1];
  }
  if (!m->has_middle) return straight;
  return is_middle ? bubble : straight - bubble * in_middle;
}

void tt_tool_weights(const tt_model* m, const double* pose, double* weights) {
  tt_zero(m->tool_poses, weights);
  weights_on(tool_grid(m), pose, weights);
  int next = m->tool_poses - 2 * poses_more * m->lines, first = 0;
  double fine[4], coarse[TT_MOST_POSITIONS];
  for (int l = 0; l < m->lines; ++l, next += 2 * poses_more) {
    const int k = m->line_axis[l];
    if (l == 0 || m->line_axis[l - 1] != k) {
      const double at = pose[m->tool_axis[k]];
      first = cubic_weights(m->fine_first[k + 1] - m->fine_first[k], m->fine_positions + m->fine_first[k], at, fine);
      smooth_weights(m->tool_first[k + 1] - m->tool_first[k], m->tool_positions + m->tool_first[k], at, coarse);
    }
    const double share = line_share(m, l, pose);
    const int32_t* on_grid = m->line_on_grid + 3 * l;
    for (int i = 0; i < 3; ++i) weights[on_grid[i]] -= share * coarse[i];
    for (int i = 0; i < 4; ++i) {
      const int at = first + i;
      const int stored = at % middle == 0 ? on_grid[at / middle] : next + (at < middle ? at - 1 : at - 2);
      weights[stored] += share * fine[i];
    }
  }
}

void tt_table_weights(const tt_model* m, const double* pose, double* weights) {
  const grid g = {m->table_grid, m->table_axis, m->table_linear, m->table_endless, m->table_first, m->table_positions};
  weights_on(g, pose, weights);
}

void tt_grid_weights(const tt_model* m, const double* pose, double* weights) {
  weights_on(tool_grid(m), pose, weights);
}

void tt_grid_table_weights(const tt_model* m, const double* pose, double* weights) {
  const grid g = {m->table_grid,    m->table_axis,       m->table_linear,
                  m->table_endless, m->grid_table_first, m->grid_table_positions};
  weights_on(g, pose, weights);
}
